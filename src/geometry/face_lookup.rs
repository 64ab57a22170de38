//! Point location in the triangles of a sensing face, projected along z.

use super::barycentric::{barycentric, clamp_to_triangle, min_coordinate};
use glam::{DVec2, DVec3, Vec3Swizzles};

/// Triangles that are queried by x and y.
#[derive(Debug)]
pub struct FaceLookup<'a> {
    points: &'a [DVec3],
    triangles: &'a [[u32; 3]],
    bounds: Vec<[DVec2; 2]>,
    margin: DVec2,
}

/// Margin of the bounding rectangles of the triangles, over the size of the face.
const MARGIN: f64 = 1e-7;

impl<'a> FaceLookup<'a> {
    /// Creates the lookup of `triangles` among `points`.
    pub fn new(points: &'a [DVec3], triangles: &'a [[u32; 3]]) -> Self {
        let bounds = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| points[i as usize].xy());
            [a.min(b).min(c), a.max(b).max(c)]
        };
        let bounds: Vec<[DVec2; 2]> = triangles.iter().map(bounds).collect();
        let low = bounds.iter().map(|b| b[0]).fold(DVec2::INFINITY, DVec2::min);
        let high = bounds.iter().map(|b| b[1]).fold(DVec2::NEG_INFINITY, DVec2::max);
        Self { points, triangles, bounds, margin: DVec2::splat(MARGIN * (high - low).max_element().max(0.0)) }
    }

    /// Returns the index of the triangle at `p` and its barycentric coordinates there, which are not negative and sum
    /// to one. Outside the face, returns the triangle whose smallest barycentric coordinate is largest, with clamped
    /// coordinates. None without triangles.
    pub fn locate(&self, p: DVec2) -> Option<(usize, [f64; 3])> {
        let weights = |t: &[u32; 3]| barycentric(p, t.map(|i| self.points[i as usize].xy()));
        // The triangle whose smallest barycentric coordinate is largest.
        let among = |near: &dyn Fn(&[DVec2; 2]) -> bool| {
            let all = self.triangles.iter().zip(&self.bounds).enumerate();
            let some = all.filter(|(_, (_, bounds))| near(bounds)).map(|(k, (t, _))| (k, weights(t)));
            some.max_by(|a, b| min_coordinate(a.1).total_cmp(&min_coordinate(b.1)))
        };
        // A point inside a triangle is within its bounds.
        let best = among(&|[low, high]| p.cmpge(*low - self.margin).all() && p.cmple(*high + self.margin).all());
        let best = best.filter(|(_, l)| min_coordinate(*l) > -1e-9).or_else(|| among(&|_| true));
        best.map(|(k, l)| (k, clamp_to_triangle(l)))
    }

    /// Returns the corners of the triangle above or below `x` with their weights, as [`FaceLookup::locate`] does.
    pub fn interpolation_at(&self, x: DVec3) -> [(u32, f64); 3] {
        let (nodes, l) = self.locate(x.xy()).map_or(([0; 3], [1.0, 0.0, 0.0]), |(k, l)| (self.triangles[k], l));
        [0, 1, 2].map(|k| (nodes[k], l[k]))
    }
}
