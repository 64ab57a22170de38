//! Front view of a deformed sensing face in millimetres of the pad frame, coloured by value.

use super::colorbar::ticks;
use super::colormap::{color, fraction};
use super::draw::{GRID_COLOR, SECONDARY_COLOR, TEXT_COLOR, frame, outlined_arrow, polyline};
use super::raster::{Raster, Vertex};
use super::style::Scalar;
use super::surface::Surface;
use super::text::{Align, Label};
use crate::{PadFrame, PadTopology};
use glam::{DMat3, DVec2, DVec3};
use std::collections::BTreeMap;
use tiny_skia::Pixmap;

/// Distance between displacement arrows, m.
const MARKER_SPACING: f64 = 2.0e-3;

/// Sensing face of a pad in the pad frame, refined between the nodes.
pub struct SensingFace {
    triangles: Vec<[u32; 3]>,
    values: Vec<f64>,
    /// Reference positions in the pad frame, m.
    rest: Vec<DVec3>,
    /// Deformed positions in the pad frame, m.
    now: Vec<DVec3>,
}

/// Area and scale of the drawing of a face.
#[derive(Debug, Clone, Copy)]
pub struct Panel {
    /// Top left corner of the drawing, pixels.
    pub at: (f32, f32),
    /// Width and height, pixels.
    pub size: (f32, f32),
    /// Centre of the drawing in the pad frame, m.
    pub center: DVec2,
    /// Pixels per metre.
    pub scale: f64,
}

impl Panel {
    fn pixel(&self, p: DVec3) -> (f32, f32) {
        let offset = (DVec2::new(p.x, p.y) - self.center) * self.scale;
        (self.at.0 + self.size.0 / 2.0 + offset.x as f32, self.at.1 + self.size.1 / 2.0 - offset.y as f32)
    }
}

impl SensingFace {
    /// Creates the face from a frame; `pose` is the rotation and the origin of the pad frame in the hand frame.
    pub fn new(topology: &PadTopology, pad: &PadFrame, scalar: Scalar, pose: (DMat3, DVec3)) -> Self {
        let [surface, _] = Surface::sensing_and_outer(topology, scalar.is_field());
        let back = pose.0.transpose();
        SensingFace {
            values: surface.values(&scalar.field(pad)),
            rest: surface.positions(&topology.rest),
            now: surface.positions(&pad.position).into_iter().map(|p| back * (p - pose.1)).collect(),
            triangles: surface.triangles,
        }
    }

    /// Returns the bounding box of the deformed sensing face in x and y, m; `None` if it is empty.
    pub fn bounds(&self) -> Option<(DVec2, DVec2)> {
        let points = self.now.iter().map(|p| p.truncate());
        points.fold(None, |bounds: Option<(DVec2, DVec2)>, p| match bounds {
            None => Some((p, p)),
            Some((low, high)) => Some((low.min(p), high.max(p))),
        })
    }

    /// Draws the face, the axes and the name into the panel.
    pub fn draw(&self, page: &mut Pixmap, label: &Label, panel: Panel, range: (f64, f64), name: &str) {
        let mut raster = Raster::new(panel.size.0 as usize, panel.size.1 as usize);
        for triangle in &self.triangles {
            let corners = triangle.map(|n| {
                let p = self.now[n as usize];
                let (x, y) = panel.pixel(p);
                let position = DVec3::new(f64::from(x - panel.at.0), f64::from(y - panel.at.1), -p.z);
                Vertex { position, value: self.values[n as usize], normal: DVec3::Z }
            });
            raster.triangle(corners, 1, |value, _| color(fraction(value, range)));
        }
        raster.paste(page, panel.at.0 as i32, panel.at.1 as i32, 1.0);
        self.axes(page, label, panel);
        let corner = (panel.at.0, panel.at.1 - 9.0);
        label.draw(page, name, corner, 17.0, TEXT_COLOR, Align::Left);
    }

    fn axes(&self, page: &mut Pixmap, label: &Label, panel: Panel) {
        let ((x, y), (w, h)) = (panel.at, panel.size);
        frame(page, x, y, w, h, GRID_COLOR);
        let half = DVec2::new(f64::from(w), f64::from(h)) / (2.0 * panel.scale);
        let span = |center: f64, half: f64| ((center - half) * 1e3, (center + half) * 1e3);
        for (value, text) in ticks(span(panel.center.x, half.x), 6) {
            let at = panel.pixel(DVec3::new(value * 1e-3, 0.0, 0.0)).0;
            polyline(page, &[(at, y + h), (at, y + h + 4.0)], 1.0, SECONDARY_COLOR, 1.0);
            label.draw(page, &text, (at, y + h + 18.0), 14.0, SECONDARY_COLOR, Align::Center);
        }
        for (value, text) in ticks(span(panel.center.y, half.y), 5) {
            let at = panel.pixel(DVec3::new(0.0, value * 1e-3, 0.0)).1;
            polyline(page, &[(x - 4.0, at), (x, at)], 1.0, SECONDARY_COLOR, 1.0);
            label.draw(page, &text, (x - 8.0, at + 5.0), 14.0, SECONDARY_COLOR, Align::Right);
        }
    }

    /// Returns the in-plane displacement at the points of a regular grid on the reference face: (current position,
    /// displacement), m.
    pub fn markers(&self) -> Vec<(DVec3, DVec2)> {
        let rest = |n: u32| self.rest[n as usize].truncate();
        let mut markers = BTreeMap::new();
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(rest);
            let area = (b - a).perp_dot(c - a);
            let (low, high) = (a.min(b).min(c) / MARKER_SPACING, a.max(b).max(c) / MARKER_SPACING);
            // Skips degenerate triangles, and huge ones, which would need millions of arrows.
            if area.abs() < 1e-18 || (high - low).max_element() > 50.0 {
                continue;
            }
            for (i, j) in grid(low, high) {
                let p = DVec2::new(i as f64, j as f64) * MARKER_SPACING;
                let weights =
                    [(c - b).perp_dot(p - b), (a - c).perp_dot(p - c), (b - a).perp_dot(p - a)].map(|w| w / area);
                // The tolerance includes points on shared edges, which lie in two triangles but are drawn once.
                if weights.iter().all(|&w| w >= -1e-9) {
                    let at = (0..3).map(|k| weights[k] * self.now[triangle[k] as usize]).sum::<DVec3>();
                    markers.entry((i, j)).or_insert((at, at.truncate() - p));
                }
            }
        }
        markers.into_values().collect()
    }

    /// Draws displacement arrows, scaled so that `longest` metres are drawn almost as long as the grid spacing.
    pub fn draw_markers(&self, page: &mut Pixmap, panel: Panel, longest: f64) {
        let length = 0.95 * MARKER_SPACING * panel.scale / longest;
        for (at, shift) in self.markers() {
            let (x, y) = panel.pixel(at);
            let tip = (x + (shift.x * length) as f32, y - (shift.y * length) as f32);
            if shift.length() > 0.08 * longest {
                outlined_arrow(page, (x, y), tip, 1.3, [255, 255, 255]);
            }
        }
    }
}

/// Returns the integer grid points between the corners.
fn grid(low: DVec2, high: DVec2) -> impl Iterator<Item = (i64, i64)> {
    let (x, y) = (low.x.ceil() as i64..=high.x.floor() as i64, low.y.ceil() as i64..=high.y.floor() as i64);
    x.flat_map(move |i| y.clone().map(move |j| (i, j)))
}
