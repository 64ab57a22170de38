//! Truth above prediction, on one colour scale.

use crate::components::ObjectPose;
use crate::dataset::inspect::frame;
use crate::dataset::{Grasp, ObjectFile};
use crate::error::{Error, Result};
use crate::gnn::predict::PadState;
use crate::record::{Frame, PadFrame, Wrench};
use crate::render::{Pixmap, Scalar, Style, WIDTH, render_pads};
use glam::DVec3;
use tiny_skia::{PixmapPaint, Transform};

/// Draws frame `k` of `grasp` and what was predicted for it; `object` is the predicted pose.
///
/// # Errors
/// Those of drawing.
pub fn draw(
    file: &ObjectFile,
    grasp: &Grasp,
    number: usize,
    k: usize,
    states: &[PadState],
    object: ObjectPose,
) -> Result<Pixmap> {
    let truth = frame(file, grasp, k);
    let predicted = predicted(file, &truth, grasp, k, states, object);
    let topologies = vec![file.pad.clone(); file.sizes.pads];
    let largest = truth.pads.iter().flat_map(|p| Scalar::Stress.values(p)).fold(0.0, f64::max);
    let picture = |what: &str, frame: &Frame| {
        let title = format!("{}, grasp {number:03}: {what}", file.name);
        let style = Style { title, range: (largest > 0.0).then_some((0.0, largest)), ..Style::default() };
        render_pads(&topologies, frame, Some(&file.object), &style)
    };
    let (above, below) = (picture("finite elements", &truth)?, picture("network", &predicted)?);
    let no_memory = || Error::file("picture", "no memory for the picture");
    let mut page = Pixmap::new(WIDTH, above.height() + below.height()).ok_or_else(no_memory)?;
    let mut paste = |picture: &Pixmap, y: u32| {
        page.draw_pixmap(0, y as i32, picture.as_ref(), &PixmapPaint::default(), Transform::identity(), None);
    };
    paste(&above, 0);
    paste(&below, above.height());
    Ok(page)
}

/// The prediction as a frame of the hand frame.
fn predicted(
    file: &ObjectFile,
    truth: &Frame,
    grasp: &Grasp,
    k: usize,
    states: &[PadState],
    object: ObjectPose,
) -> Frame {
    let pads = file.sizes.pads;
    let pad = |(i, state): (usize, &PadState)| {
        let (pose, at) = (&file.pad_poses[i], k * pads + i);
        let touch = grasp.finger_position[at] - grasp.travel[at];
        let carried = pose.position + file.closing[i] * (touch + state.travel);
        let displacement: Vec<DVec3> = state.displacement.iter().map(|u| pose.rotation * *u).collect();
        PadFrame {
            position: file.pad.rest.iter().zip(&displacement).map(|(x, u)| pose.rotation * *x + carried + *u).collect(),
            displacement,
            contact_force: state.contact.iter().map(|f| pose.rotation * *f).collect(),
            von_mises_node: state.stress.clone(),
            wrench: Wrench::default(),
            ..PadFrame::default()
        }
    };
    Frame {
        index: truth.index,
        applied_force: truth.applied_force,
        travel: states.iter().map(|s| s.travel).collect(),
        object_position: object.position,
        object_rotation: object.rotation,
        pads: states.iter().enumerate().map(pad).collect(),
        ..Frame::default()
    }
}
