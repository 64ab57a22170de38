//! Picture of a frame: sensing faces, colour bars and 3-D view.

use super::colorbar;
use super::draw::{BACKGROUND_COLOR, GRID_COLOR, SECONDARY_COLOR, TEXT_COLOR, clear, polyline};
use super::face::{Panel, SensingFace};
use super::pose::pad_pose;
use super::style::{HEIGHT, Scalar, Style, WIDTH};
use super::text::{Align, Label};
use super::view::CutView;
use crate::{Frame, PadFrame, PadTopology, check, pad_name};
use base::error::{Error, Result};
use base::files::atomic;
use geometry::mesh::TriMesh;
use glam::DVec2;
use std::path::Path;
use tiny_skia::Pixmap;

/// Left and right edge of the face panels, pixels.
const FACE_X: (f32, f32) = (64.0, 354.0);
/// Left edges of the colour bars of faces and view, pixels.
const BAR_X: [f32; 2] = [FACE_X.1 + 30.0, FACE_X.1 + 186.0];
/// Left edge and width of the view, pixels.
const VIEW_X: (f32, f32) = (600.0, 772.0);
/// Top and bottom edge of the area below the title, pixels.
const BODY_Y: (f32, f32) = (136.0, 744.0);

/// Draws a frame as a picture of [`WIDTH`] x [`HEIGHT`] pixels. `object` is the object's surface in the object frame,
/// m.
///
/// # Errors
/// Fails if input sizes do not match or numbers are not finite; the message names the field.
pub fn render_pads(
    topologies: &[PadTopology],
    frame: &Frame,
    object: Option<&TriMesh>,
    style: &Style,
) -> Result<Pixmap> {
    let refuse = |message: String| Error::file("picture", format!("not drawn: {message}"));
    for (pad, topology) in topologies.iter().enumerate() {
        check::topology(pad, topology).map_err(refuse)?;
    }
    check::frame(topologies, frame).map_err(refuse)?;
    object.map_or(Ok(()), check::object).map_err(refuse)?;
    let range = color_range(frame, style.scalar, style.range)?;
    let face_range = color_range(frame, style.face, style.face_range)?;

    let label = Label::new()?;
    let mut page = Pixmap::new(WIDTH, HEIGHT).ok_or_else(|| refuse("no memory for the picture".into()))?;
    clear(&mut page, BACKGROUND_COLOR);
    heading(&mut page, &label, frame, style);
    faces(&mut page, &label, topologies, frame, face_range, style);
    for (x, scalar, range) in [(BAR_X[0], style.face, face_range), (BAR_X[1], style.scalar, range)] {
        colorbar::draw(&mut page, &label, (x, BODY_Y.0), (20.0, BODY_Y.1 - BODY_Y.0), range, scalar.label());
    }
    let view = CutView { topologies, frame, scalar: style.scalar, range, object, cut: style.cut };
    view.draw(&mut page, &label, (VIEW_X.0, 150.0), (VIEW_X.1, 556.0));
    if style.cut {
        let note = "hand frame, section through the middle of the pads";
        label.draw(&mut page, note, (WIDTH as f32 - 28.0, BODY_Y.0 - 14.0), 15.0, SECONDARY_COLOR, Align::Right);
    }
    Ok(page)
}

/// Encodes the picture as PNG.
///
/// # Errors
/// Fails if the picture cannot be encoded.
pub fn encode(picture: &Pixmap) -> Result<Vec<u8>> {
    picture.encode_png().map_err(|e| Error::file("picture", format!("cannot encode as PNG: {e}")))
}

/// Writes the picture to `path`; the file is replaced atomically.
///
/// # Errors
/// Fails if the picture cannot be encoded or the file cannot be written.
pub fn save(picture: &Pixmap, path: &Path) -> Result<()> {
    atomic::write_atomic(path, &encode(picture)?)
}

fn color_range(frame: &Frame, scalar: Scalar, given: Option<(f64, f64)>) -> Result<(f64, f64)> {
    if let Some((low, high)) = given {
        if low.is_finite() && high.is_finite() && low < high {
            return Ok((low, high));
        }
        let message =
            format!("not drawn: colour range {low} to {high}; two finite numbers are needed, the smaller first");
        return Err(Error::file("picture", message));
    }
    let largest = frame.pads.iter().flat_map(|pad| scalar.values(pad)).fold(0.0, f64::max);
    // The values of an unloaded pad are all zero; any non-empty range will do.
    Ok((0.0, if largest > 0.0 { largest } else { 1.0 }))
}

fn heading(page: &mut Pixmap, label: &Label, frame: &Frame, style: &Style) {
    let title = label.fit(&style.title, 32.0, WIDTH as f32 - 60.0);
    label.draw(page, &title, (28.0, 46.0), 32.0, TEXT_COLOR, Align::Left);
    let travel: Vec<String> =
        frame.travel.iter().enumerate().map(|(i, t)| format!("{} {:.2} mm", pad_name(i), t * 1e3)).collect();
    let force = format!("applied force {:.2} N (sum over the fingers)", frame.applied_force);
    let time = frame.moving.map_or(String::new(), |_| format!("   ·   {:.3} s", frame.time));
    let line = format!("{force}   ·   travel {}   ·   frame {}{time}", travel.join(", "), frame.index);
    let line = label.fit(&line, 19.0, WIDTH as f32 - 60.0);
    label.draw(page, &line, (28.0, 76.0), 19.0, SECONDARY_COLOR, Align::Left);
    polyline(page, &[(28.0, 92.0), (WIDTH as f32 - 28.0, 92.0)], 1.0, GRID_COLOR, 1.0);
}

fn sensing_faces(topologies: &[PadTopology], frame: &Frame, scalar: Scalar) -> Vec<(usize, SensingFace)> {
    let face = |(pad, (topology, own)): (usize, (&PadTopology, &PadFrame))| {
        pad_pose(topology, own).map(|pose| (pad, SensingFace::new(topology, own, scalar, pose)))
    };
    topologies.iter().zip(&frame.pads).enumerate().filter_map(face).collect()
}

fn longest(faces: &[(usize, SensingFace)]) -> f64 {
    faces.iter().flat_map(|(_, face)| face.markers()).map(|(_, u)| u.length()).fold(0.0, f64::max)
}

/// Returns the largest in-plane displacement shown by an arrow, m; use it as [`Style::longest`] of pictures that are
/// compared.
pub fn longest_arrow(topologies: &[PadTopology], frame: &Frame) -> f64 {
    longest(&sensing_faces(topologies, frame, Scalar::default()))
}

fn faces(
    page: &mut Pixmap,
    label: &Label,
    topologies: &[PadTopology],
    frame: &Frame,
    range: (f64, f64),
    style: &Style,
) {
    let faces = sensing_faces(topologies, frame, style.face);
    let bounds = faces.iter().filter_map(|(_, face)| face.bounds()).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
    let Some((low, high)) = bounds else { return };
    // All pads have the same scale and centre, so that they can be compared.
    let gap = 62.0;
    let height = (BODY_Y.1 - BODY_Y.0 - gap * (faces.len() as f32 - 1.0)) / faces.len() as f32;
    let size = (FACE_X.1 - FACE_X.0, height.max(1.0).floor());
    let span = (high - low).max(DVec2::splat(1e-6));
    let scale = 0.94 * (f64::from(size.0) / span.x).min(f64::from(size.1) / span.y);
    let longest = style.longest.unwrap_or_else(|| longest(&faces));
    for (row, (pad, face)) in faces.iter().enumerate() {
        let at = (FACE_X.0, BODY_Y.0 + row as f32 * (size.1 + gap));
        let panel = Panel { at, size, center: (low + high) / 2.0, scale };
        face.draw(page, label, panel, range, &format!("{} pad, sensing face (mm)", pad_name(*pad)));
        // Displacements below 0.1 um are rounding errors.
        if style.markers && longest > 1e-7 {
            face.draw_markers(page, panel, longest);
        }
    }
    if style.markers && longest > 1e-7 {
        let note = format!("arrows: in-plane displacement, longest {:.3} mm", longest * 1e3);
        label.draw(page, &note, (FACE_X.0, HEIGHT as f32 - 16.0), 15.0, SECONDARY_COLOR, Align::Left);
    }
}
