//! Triangles of a sensing face, seen from above.

use super::barycentric::barycentric;
use glam::{DVec2, DVec3, Vec3Swizzles};

/// Triangles that are looked up by x and y.
#[derive(Debug)]
pub struct FaceLookup<'a> {
    points: &'a [DVec3],
    triangles: &'a [[u32; 3]],
    bounds: Vec<[DVec2; 2]>,
    margin: DVec2,
}

/// Part of the face within which a point still counts as inside a triangle.
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

    /// Returns the corners of the triangle above or below `x` with their weights, which are not negative and sum to one; beside the face,
    /// those of the nearest place in the triangle that `x` is least outside of.
    pub fn under(&self, x: DVec3) -> [(u32, f64); 3] {
        let weights = |t: &[u32; 3]| barycentric(x.xy(), t.map(|i| self.points[i as usize].xy()));
        // The triangle that the point is most inside of; beside the face, the least outside.
        let inside = |w: &[f64; 3]| w.iter().copied().fold(f64::INFINITY, f64::min);
        let among = |near: &dyn Fn(&[DVec2; 2]) -> bool| {
            let some = self.triangles.iter().zip(&self.bounds).filter(|(_, bounds)| near(bounds));
            some.map(|(t, _)| (t, weights(t))).max_by(|a, b| inside(&a.1).total_cmp(&inside(&b.1)))
        };
        // Whoever is in a triangle is within its bounds.
        let p = x.xy();
        let best = among(&|[low, high]| p.cmpge(*low - self.margin).all() && p.cmple(*high + self.margin).all());
        let best = best.filter(|(_, w)| inside(w) > -1e-9).or_else(|| among(&|_| true));
        let (t, w) = best.unwrap_or((&[0, 0, 0], [1.0, 0.0, 0.0]));
        let w = w.map(|w| w.max(0.0));
        let sum: f64 = w.iter().sum();
        [0, 1, 2].map(|k| (t[k], w[k] / sum))
    }
}
