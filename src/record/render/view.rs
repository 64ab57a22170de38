//! Orthographic 3-D view of pads and object in the hand frame, optionally cut through the middle.

use super::colormap::{color, fraction};
use super::draw::{SECONDARY_COLOR, TEXT_COLOR, arrow, polyline};
use super::normals::corner_normals;
use super::raster::{Raster, Vertex};
use super::section::CutPlane;
use super::style::Scalar;
use super::surface::Surface;
use super::text::{Align, Label};
use crate::{Frame, PadTopology, pad_name};
use geometry::mesh::TriMesh;
use glam::{DVec2, DVec3};
use tiny_skia::Pixmap;

/// Body numbers of the object in the raster: outer surface, and inner surface exposed by the cut.
const OBJECT: u8 = 200;
const OBJECT_CUT: u8 = 201;
const OBJECT_RGB: [f32; 3] = [226.0, 219.0, 206.0];
const OBJECT_CUT_RGB: [f32; 3] = [212.0, 205.0, 192.0];

/// Depth offset too small to be visible, m.
const DEPTH_OFFSET: f64 = 1e-6;

/// Offset of the cut from the middle, m, so that all nodes in the middle plane lie on one side of the cut.
const CUT_OFFSET: f64 = 1e-7;

/// Content of the view.
pub struct CutView<'a> {
    /// Topologies of the pads.
    pub topologies: &'a [PadTopology],
    /// State of pads and object.
    pub frame: &'a Frame,
    /// Quantity that colours the pads.
    pub scalar: Scalar,
    /// Colour range.
    pub range: (f64, f64),
    /// Object surface in the object frame, m.
    pub object: Option<&'a TriMesh>,
    /// Flag: remove the part in front of the middle plane.
    pub cut: bool,
}

/// Orthographic camera; "up" is opposite to the approach direction, so the hand is shown above.
struct Camera {
    right: DVec3,
    up: DVec3,
    towards: DVec3,
    center: DVec3,
    middle: DVec2,
    scale: f64,
    /// Direction towards the light: from the upper left behind the camera.
    light: DVec3,
}

impl Camera {
    fn new() -> Self {
        let (turn, lift) = (19f64.to_radians(), 17f64.to_radians());
        let towards = DVec3::new(turn.sin() * lift.cos(), turn.cos() * lift.cos(), -lift.sin());
        let right = (-DVec3::Z).cross(towards).normalize_or(DVec3::X);
        let up = towards.cross(right);
        let light = (towards * 0.75 + up * 0.6 - right * 0.35).normalize_or_zero();
        Camera { right, up, towards, center: DVec3::ZERO, middle: DVec2::ZERO, scale: 1.0, light }
    }

    /// Projects a point to raster position (x, y) and depth (z).
    fn project(&self, p: DVec3) -> DVec3 {
        let d = p - self.center;
        let (x, y) = (self.scale * d.dot(self.right), self.scale * d.dot(self.up));
        DVec3::new(self.middle.x + x, self.middle.y - y, -d.dot(self.towards))
    }

    /// Returns the depth of a plane at a raster position.
    fn depth(&self, plane: CutPlane, at: DVec2) -> f64 {
        let aside = (at - self.middle) / self.scale;
        let p = self.center + self.right * aside.x - self.up * aside.y;
        (plane.normal.dot(p) - plane.offset) / plane.normal.dot(self.towards)
    }

    /// Fits the view to `pads` and `object`. A large object is cropped: the scale is at least half of that which fits
    /// the pads alone.
    fn fit(&mut self, pads: &[DVec3], object: &[DVec3], size: DVec2) {
        let extent = |points: &mut dyn Iterator<Item = DVec3>| {
            points.fold(None, |bounds: Option<(DVec3, DVec3)>, p| {
                let q = DVec3::new(p.dot(self.right), p.dot(self.up), p.dot(self.towards));
                Some(bounds.map_or((q, q), |(low, high)| (low.min(q), high.max(q))))
            })
        };
        let zoom = |(low, high): (DVec3, DVec3)| {
            let span = (high - low).max(DVec3::splat(1e-6));
            0.92 * (size.x / span.x).min(size.y / span.y)
        };
        let inner = extent(&mut pads.iter().copied());
        let outer = extent(&mut pads.iter().chain(object).copied());
        let (Some(inner), Some(outer)) = (inner, outer) else { return };
        let (chosen, scale) =
            if zoom(outer) * 2.0 >= zoom(inner) { (outer, zoom(outer)) } else { (inner, zoom(inner) / 2.0) };
        let middle = (chosen.0 + chosen.1) / 2.0;
        self.center = self.right * middle.x + self.up * middle.y + self.towards * middle.z;
        self.scale = scale;
        self.middle = size / 2.0;
    }
}

impl CutView<'_> {
    /// Draws into the rectangle of the page; axes and scale bar use the 60 pixels below it.
    pub fn draw(&self, page: &mut Pixmap, label: &Label, at: (f32, f32), size: (f32, f32)) {
        let pads: Vec<DVec3> = self.frame.pads.iter().flat_map(|pad| pad.position.iter().copied()).collect();
        let pose = |v: &DVec3| self.frame.object_position + self.frame.object_rotation * *v;
        let object: Vec<DVec3> = self.object.map_or(Vec::new(), |mesh| mesh.vertices.iter().map(pose).collect());
        let mut camera = Camera::new();
        camera.fit(&pads, &object, DVec2::new(f64::from(size.0), f64::from(size.1)));
        let middle = pads.iter().map(|p| p.y).sum::<f64>() / pads.len().max(1) as f64;
        let plane = self.cut.then_some(CutPlane { normal: -DVec3::Y, offset: CUT_OFFSET - middle });
        let mut raster = Raster::new(size.0 as usize, size.1 as usize);
        for index in 0..self.topologies.len() {
            self.pad(&mut raster, &camera, plane, index);
        }
        if let Some(mesh) = self.object {
            let mut solid = Raster::new(size.0 as usize, size.1 as usize);
            draw_object(&mut solid, &camera, plane, &object, &mesh.triangles);
            if let Some(plane) = plane {
                // The section of the object is drawn in the cut plane, slightly behind the section of the pads, instead
                // of at the depth of the far side.
                solid.move_to(OBJECT_CUT, |x, y| camera.depth(plane, DVec2::new(x, y)) + DEPTH_OFFSET);
            }
            raster.merge(&solid);
        }
        raster.outline(0.45);
        raster.paste(page, at.0 as i32, at.1 as i32, 1.0);
        self.names(page, label, &camera, at);
        triad(page, label, &camera, (at.0 + 48.0, at.1 + size.1 + 8.0));
        scale_bar(page, label, &camera, (at.0 + size.0 - 20.0, at.1 + size.1 + 38.0));
    }

    fn pad(&self, raster: &mut Raster, camera: &Camera, plane: Option<CutPlane>, index: usize) {
        let (topology, pad) = (&self.topologies[index], &self.frame.pads[index]);
        let field = self.scalar.field(pad);
        let body = u8::try_from(2 * index + 1).unwrap_or(199).min(199);
        let tint = |value: f64| color(fraction(value, self.range));
        let lit = |value: f64, normal: DVec3| tint(value).map(|c| c * light(normal, camera) as f32);
        for surface in Surface::sensing_and_outer(topology, self.scalar.is_field()) {
            for corners in surface.shaded(&pad.position, &field) {
                each_visible(corners, plane, |part| raster.triangle(project(camera, part), body, lit));
            }
        }
        if let Some(plane) = plane {
            for part in plane.cut(&topology.elements, &pad.position, &field) {
                // Unlit, so that the colour on the section can be read as a value.
                raster.triangle(project(camera, part), body + 1, |value, _| tint(value));
            }
        }
    }

    /// Draws the pad names above the pads.
    fn names(&self, page: &mut Pixmap, label: &Label, camera: &Camera, at: (f32, f32)) {
        for (index, pad) in self.frame.pads.iter().enumerate() {
            let projected: Vec<DVec3> = pad.position.iter().map(|&p| camera.project(p)).collect();
            let top = projected.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
            let x = projected.iter().map(|p| p.x).sum::<f64>() / projected.len().max(1) as f64;
            if top.is_finite() {
                let spot = (at.0 + x as f32, (at.1 + top as f32 - 12.0).max(at.1 + 4.0));
                label.draw(page, &pad_name(index), spot, 17.0, TEXT_COLOR, Align::Center);
            }
        }
    }
}

fn draw_object(
    raster: &mut Raster,
    camera: &Camera,
    plane: Option<CutPlane>,
    vertices: &[DVec3],
    triangles: &[[u32; 3]],
) {
    let normals = corner_normals(vertices, triangles);
    for (triangle, normals) in triangles.iter().zip(normals) {
        let [a, b, c] = triangle.map(|n| vertices[n as usize]);
        let front = (b - a).cross(c - a).dot(camera.towards) >= 0.0;
        let corners = [(a, normals[0]), (b, normals[1]), (c, normals[2])].map(|(position, normal)| Vertex {
            position,
            value: 0.0,
            normal,
        });
        each_visible(corners, plane, |part| {
            let part = project(camera, part);
            if front || plane.is_none() {
                raster.triangle(part, OBJECT, |_, normal| OBJECT_RGB.map(|c| c * light(normal, camera) as f32));
            } else {
                // Back faces of a closed surface are visible only through the cut.
                raster.triangle(part, OBJECT_CUT, |_, _| OBJECT_CUT_RGB);
            }
        });
    }
}

fn each_visible(corners: [Vertex; 3], plane: Option<CutPlane>, mut draw: impl FnMut([Vertex; 3])) {
    match plane {
        None => draw(corners),
        Some(plane) => plane.clip(corners).into_iter().for_each(draw),
    }
}

fn project(camera: &Camera, corners: [Vertex; 3]) -> [Vertex; 3] {
    corners.map(|v| Vertex { position: camera.project(v.position), ..v })
}

/// Returns the brightness of a diffuse light: 0.62 on a surface facing away from the light, 1.05 on a surface facing
/// it.
fn light(normal: DVec3, camera: &Camera) -> f64 {
    // Half-Lambert shading: gradual, without black regions.
    0.62 + 0.43 * (0.5 + 0.5 * normal.dot(camera.light)).powi(2)
}

fn triad(page: &mut Pixmap, label: &Label, camera: &Camera, at: (f32, f32)) {
    for (axis, name) in [(DVec3::X, "x"), (DVec3::Y, "y"), (DVec3::Z, "z")] {
        let (dx, dy) = (axis.dot(camera.right) as f32, -axis.dot(camera.up) as f32);
        let tip = (at.0 + 40.0 * dx, at.1 + 40.0 * dy);
        arrow(page, at, tip, 1.6, TEXT_COLOR);
        let spot = (tip.0 + 9.0 * dx, tip.1 + 9.0 * dy + 5.0);
        label.draw(page, name, spot, 15.0, TEXT_COLOR, Align::Center);
    }
}

/// Draws a scale bar of a round length whose right end is at `at`.
fn scale_bar(page: &mut Pixmap, label: &Label, camera: &Camera, at: (f32, f32)) {
    let wanted = 180.0 / camera.scale * 1e3;
    let power = 10f64.powf(wanted.log10().floor());
    let Some(length) = [5.0, 2.0, 1.0].map(|f| f * power).into_iter().find(|&l| l <= wanted) else { return };
    let pixels = (length * 1e-3 * camera.scale) as f32;
    polyline(page, &[(at.0 - pixels, at.1), at], 2.5, TEXT_COLOR, 1.0);
    label.draw(page, &format!("{length} mm"), (at.0 - pixels / 2.0, at.1 - 9.0), 15.0, SECONDARY_COLOR, Align::Center);
}
