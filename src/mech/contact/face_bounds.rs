//! Closest point of a deformed pad surface.

use super::cells::FaceGrid;
pub use super::closest_point::ClosestPoint;
use super::closest_point::{clamp_to_triangle, on_face, project_flat};
use super::surface::{ContactSurface, SurfaceFace};
use base::scales::EXACT_GAP_RADIUS;
use glam::DVec3;

/// Bounds of the faces of a deformed surface, which exclude most of them from a query.
#[derive(Debug, Clone)]
pub struct FaceBounds {
    /// Contact offset, m.
    pub(crate) offset: f64,
    boxes: Vec<[DVec3; 2]>,
    /// Largest distance of each face from its flat triangle, m.
    bulges: Vec<f64>,
    cells: FaceGrid,
    min: DVec3,
    max: DVec3,
}

impl FaceBounds {
    /// Creates bounds without faces, for contact with this `offset` (m).
    pub fn new(offset: f64) -> Self {
        let cells = FaceGrid::new(EXACT_GAP_RADIUS * offset);
        Self { offset, boxes: Vec::new(), bulges: Vec::new(), cells, min: DVec3::ZERO, max: DVec3::ZERO }
    }

    /// Distance up to which the cells contain the nearest face, m.
    pub(crate) fn cell_radius(&self) -> f64 {
        self.cells.near
    }

    /// Updates the bounds of every face to node positions `x`.
    pub fn update(&mut self, surface: &ContactSurface, x: &[DVec3]) {
        self.boxes.clear();
        self.bulges.clear();
        (self.min, self.max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for face in surface.faces.iter() {
            let mut nodes = [DVec3::ZERO; 6];
            let (mut count, mut sagitta) = (3, 0.0_f64);
            for (k, n) in face.corners.iter().enumerate() {
                nodes[k] = x[*n as usize];
            }
            if let Some(mids) = face.mids {
                for (k, n) in mids.iter().enumerate() {
                    // The Bezier control point of the edge bounds the curve: 2 m - (a + b) / 2.
                    let middle = (nodes[k] + nodes[(k + 1) % 3]) * 0.5;
                    nodes[3 + k] = x[*n as usize] * 2.0 - middle;
                    sagitta = sagitta.max(x[*n as usize].distance(middle));
                }
                count = 6;
            }
            self.bulges.push(QUADRATIC_BULGE_RATIO * sagitta);
            let around =
                nodes[..count].iter().fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |b, p| [b[0].min(*p), b[1].max(*p)]);
            (self.min, self.max) = (self.min.min(around[0]), self.max.max(around[1]));
            self.boxes.push(around);
        }
        self.cells.update(&self.boxes, self.min, self.max);
    }

    /// Closest point of the surface to `y` if nearer than `reach` outside, or anywhere inside the gel near the surface.
    pub fn closest(&self, surface: &ContactSurface, x: &[DVec3], y: DVec3, reach: f64) -> Option<ClosestPoint> {
        self.closest_as(surface, x, y, reach, |closest_point| closest_point)
    }

    /// Returns the closest point as [`FaceBounds::closest`] does, where `side` decides on which side of the surface `y`
    /// is.
    pub(crate) fn closest_as(
        &self,
        surface: &ContactSurface,
        x: &[DVec3],
        y: DVec3,
        reach: f64,
        side: impl Fn(ClosestPoint) -> ClosestPoint,
    ) -> Option<ClosestPoint> {
        if y.cmplt(self.min - reach).any() || y.cmpgt(self.max + reach).any() {
            return None;
        }
        let best = self.near(surface, x, y, self.cell_radius());
        let best = best.or_else(|| self.nearest(surface, x, y, 0..self.boxes.len(), f64::INFINITY));
        best.map(side).filter(|closest_point| closest_point.gap < reach)
    }

    /// Closest point of the surface to `y` if nearer than `limit`, up to the reach of the cells, inside or outside.
    pub(crate) fn near(&self, surface: &ContactSurface, x: &[DVec3], y: DVec3, limit: f64) -> Option<ClosestPoint> {
        let faces = self.cells.at(y).iter().map(|i| *i as usize);
        self.nearest(surface, x, y, faces, limit)
    }

    /// Lower bound of the distance of `y` outside the surface, m: exact near the surface, not positive inside. `side`
    /// decides on which side of the surface `y` is.
    pub(crate) fn outside(
        &self,
        surface: &ContactSurface,
        x: &[DVec3],
        y: DVec3,
        side: impl Fn(ClosestPoint) -> ClosestPoint,
    ) -> f64 {
        let beyond = y.clamp(self.min, self.max).distance(y);
        if beyond > self.cell_radius() {
            return beyond;
        }
        self.closest_as(surface, x, y, f64::INFINITY, side).map_or(f64::INFINITY, |closest_point| closest_point.gap)
    }

    /// Closest point on those of `faces` that are nearer than `limit`.
    fn nearest(
        &self,
        surface: &ContactSurface,
        x: &[DVec3],
        y: DVec3,
        faces: impl Iterator<Item = usize> + Clone,
        limit: f64,
    ) -> Option<ClosestPoint> {
        // The face with the smallest lower bound is tested first: it excludes most of the others.
        let (mut first, mut least) = (None, limit);
        for i in faces.clone() {
            let away = self.distance_bound(i, &surface.faces[i], x, y, least);
            if away < least {
                (first, least) = (Some(i), away);
            }
        }
        let (mut best, mut nearest): (Option<ClosestPoint>, f64) = (None, limit);
        for i in first.into_iter().chain(faces.filter(|i| Some(*i) != first)) {
            let most = nearest * (1.0 + DISTANCE_ROUNDING);
            if self.distance_bound(i, &surface.faces[i], x, y, most) > most {
                continue;
            }
            let closest_point = on_face(i, &surface.faces[i], x, y);
            let distance = closest_point.gap.abs();
            // On an edge shared by two faces, only the face that the point lies over gives the correct side.
            let better = match best {
                Some(ClosestPoint { facing, .. }) if (distance - nearest).abs() <= DISTANCE_ROUNDING * nearest => {
                    closest_point.facing > facing
                }
                _ => distance < nearest,
            };
            if better {
                nearest = distance;
                best = Some(closest_point);
            }
        }
        best.map(|closest_point| closest_point.signed(surface, x, y))
    }

    /// Lower bound of the distance of face `i` from `y`, m: that of its flat triangle, minus its bulge. For a face
    /// whose box is beyond `limit` (m), it is the distance of the box.
    pub(crate) fn distance_bound(&self, i: usize, face: &SurfaceFace, x: &[DVec3], y: DVec3, limit: f64) -> f64 {
        let [low, high] = self.boxes[i];
        let beyond = y.clamp(low, high).distance(y);
        if beyond > limit {
            return beyond;
        }
        let [a, b, c] = face.corners.map(|n| x[n as usize]);
        let l = clamp_to_triangle(project_flat(a, b, c, y), a, b, c, y);
        ((a * l[0] + b * l[1] + c * l[2]).distance(y) - self.bulges[i]).max(beyond)
    }
}

/// Largest distance of a quadratic face from its flat triangle, over that of its mid-edge nodes: the maximum of the sum
/// of their shape functions.
const QUADRATIC_BULGE_RATIO: f64 = 4.0 / 3.0;
/// Relative difference of distances that counts as rounding.
const DISTANCE_ROUNDING: f64 = 1e-9;
