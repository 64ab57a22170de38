//! Height of a curved face over a regular grid of points in the plane below it.

use super::barycentric::{barycentric, min_coordinate};
use super::face_lookup::FaceLookup;
use super::triangle6::{position, tangents};
use glam::{DMat2, DVec2, DVec3, Vec3Swizzles};

/// Regular grid of cells over a rectangle in the plane, with a point at the centre of each.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PlaneGrid {
    /// Corner of the rectangle with the smallest coordinates.
    pub low: DVec2,
    /// Size of the rectangle.
    pub size: DVec2,
    /// Number of cells along x and y.
    pub cells: [usize; 2],
}

/// Number of Newton iterations for the point of a triangle above a given point.
const ITERATIONS: usize = 8;
/// Distance from the given point, over the size of the triangle, at which the iteration has converged.
const TOLERANCE: f64 = 1e-9;
/// Barycentric coordinate below which a point lies outside its triangle.
const MIN_BARYCENTRIC: f64 = -1e-6;

impl PlaneGrid {
    /// Returns point (row, column), the centre of that cell.
    pub fn point(&self, row: usize, col: usize) -> DVec2 {
        self.low + self.cell() * DVec2::new(row as f64 + 0.5, col as f64 + 0.5)
    }

    /// Returns the size of a cell.
    pub fn cell(&self) -> DVec2 {
        self.size / DVec2::new(self.cells[0] as f64, self.cells[1] as f64)
    }

    /// Returns the row and column of the cell that is nearest to a point.
    pub fn nearest(&self, p: DVec2) -> [usize; 2] {
        let at = (p - self.low) / self.cell();
        [0, 1].map(|axis| at[axis].clamp(0.0, (self.cells[axis] - 1) as f64) as usize)
    }

    /// Returns the rows and columns of the cells whose centres lie in the bounding rectangle of `points`.
    pub fn cells_around(&self, points: &[DVec2]) -> impl Iterator<Item = [usize; 2]> + use<> {
        let (low, high) =
            points.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
        let [rows, cols] = [0, 1].map(|axis| self.cell_range(axis, [low[axis], high[axis]]));
        rows.flat_map(move |row| cols.clone().map(move |col| [row, col]))
    }

    /// Returns the indices along one axis of the cells whose centres lie between two coordinates.
    fn cell_range(&self, axis: usize, [low, high]: [f64; 2]) -> std::ops::Range<usize> {
        let at = |x: f64| (x - self.low[axis]) / self.size[axis] * self.cells[axis] as f64 - 0.5;
        let bound = |v: f64| v.clamp(0.0, self.cells[axis] as f64) as usize;
        bound(at(low).ceil())..bound(at(high).floor() + 1.0)
    }

    /// Computes the height (rows, columns) of a face of 6-node `triangles`: three corners, then the midpoints of (0,1),
    /// (1,2) and (2,0). A point outside the face has the height at the point that [`FaceLookup::locate`] returns for
    /// it.
    pub fn heights(&self, triangles: &[[DVec3; 6]]) -> Vec<f64> {
        let [rows, cols] = self.cells;
        let mut heights = vec![None; rows * cols];
        for x in triangles {
            let nodes = x.map(|p| p.xy());
            // A curved edge may extend beyond the bounding rectangle of its nodes.
            let (low, high) = (nodes.into_iter().reduce(DVec2::min), nodes.into_iter().reduce(DVec2::max));
            let (low, high) = (low.unwrap_or_default(), high.unwrap_or_default());
            let more = 0.25 * (high - low);
            for [row, col] in self.cells_around(&[low - more, high + more]) {
                let height = &mut heights[row * cols + col];
                *height = height.or_else(|| height_above(x, self.point(row, col)));
            }
        }
        let corners: Vec<[u32; 3]> = (0..triangles.len() as u32).map(|k| [6 * k, 6 * k + 1, 6 * k + 2]).collect();
        let lookup = FaceLookup::new(triangles.as_flattened(), &corners);
        let beside = |k: usize| {
            let place = lookup.locate(self.point(k / cols, k % cols));
            place.map_or(0.0, |(triangle, l)| position(&triangles[triangle], l).z)
        };
        heights.into_iter().enumerate().map(|(k, height)| height.unwrap_or_else(|| beside(k))).collect()
    }
}

/// Height of the triangle above a point; None outside the triangle, or if the iteration does not converge.
fn height_above(x: &[DVec3; 6], p: DVec2) -> Option<f64> {
    let size = x[0].xy().distance(x[1].xy());
    let mut l = barycentric(p, [x[0].xy(), x[1].xy(), x[2].xy()]);
    for _ in 0..ITERATIONS {
        let off = p - position(x, l).xy();
        if off.length() < TOLERANCE * size {
            return (min_coordinate(l) > MIN_BARYCENTRIC).then(|| position(x, l).z);
        }
        let [u, v] = tangents(x, l).map(|t| t.xy());
        let step = DMat2::from_cols(u, v).inverse() * off;
        l = [1.0 - l[1] - step.x - l[2] - step.y, l[1] + step.x, l[2] + step.y];
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A face of two triangles deformed by a quadratic map, which their shape functions reproduce exactly.
    #[test]
    fn heights_of_a_bent_face_are_exact() {
        let map = |u: f64, v: f64| {
            DVec3::new(u + 0.1 * u * v + 0.05 * v * v, v - 0.08 * u * v + 0.1 * u, 0.3 * u * u - 0.2 * u * v + 0.1 * v)
        };
        let triangle = |corners: [(f64, f64); 3]| {
            let middle = |a: usize, b: usize| {
                let ((a, b), (c, d)) = (corners[a], corners[b]);
                map(0.5 * (a + c), 0.5 * (b + d))
            };
            let [a, b, c] = corners.map(|(u, v)| map(u, v));
            [a, b, c, middle(0, 1), middle(1, 2), middle(2, 0)]
        };
        let face = [triangle([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)]), triangle([(0.0, 0.0), (1.0, 1.0), (0.0, 1.0)])];
        let grid = PlaneGrid { low: DVec2::new(0.2, 0.3), size: DVec2::new(0.6, 0.4), cells: [7, 5] };
        for (k, height) in grid.heights(&face).into_iter().enumerate() {
            let p = grid.point(k / 5, k % 5);
            // The parameters of the point, by fixed-point iteration.
            let (mut u, mut v) = (p.x, p.y);
            for _ in 0..200 {
                (u, v) = (p.x - 0.1 * u * v - 0.05 * v * v, p.y + 0.08 * u * v - 0.1 * u);
            }
            assert!((height - map(u, v).z).abs() < 1e-9, "{height} at {p}, {} by the map", map(u, v).z);
        }
    }

    #[test]
    fn points_beside_a_face_have_the_height_of_its_rim() {
        let [a, b, c] = [DVec3::Z, DVec3::X + DVec3::Z, DVec3::Y + DVec3::Z];
        let face = [[a, b, c, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)]];
        let grid = PlaneGrid { low: DVec2::splat(-1.0), size: DVec2::splat(4.0), cells: [6, 6] };
        assert!(grid.heights(&face).iter().all(|z| (z - 1.0).abs() < 1e-12));
    }
}
