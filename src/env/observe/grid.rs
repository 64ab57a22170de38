//! A regular grid of taxels on the sensing face.

use crate::geometry::barycentric::barycentric;
use crate::geometry::height_field::PlaneGrid;
use crate::record::PadTopology;
use crate::scene::Grid;
use glam::{DVec2, DVec3};

impl Grid {
    /// Returns the middles of the taxels on the sensing face of `pad`, m, pad frame.
    pub(crate) fn over(&self, pad: &PadTopology) -> PlaneGrid {
        let (low, size) = extent(pad);
        PlaneGrid { low, size, cells: [self.rows.get(), self.cols.get()] }
    }

    /// Returns, for every node, the taxels among which its force is shared out. The weights are non-negative and sum to one, so the
    /// image sums to the resultant. Shares are bilinear between the taxels' centres; beyond the outermost centres the whole force
    /// goes to the outermost taxels.
    pub(crate) fn shares(&self, pad: &PadTopology) -> Vec<[(u32, f64); 4]> {
        let (low, size) = extent(pad);
        let along = |x: f64, low: f64, size: f64, n: usize| {
            let at = ((x - low) / size * n as f64 - 0.5).clamp(0.0, (n - 1) as f64);
            let cell = (at.floor() as usize).min(n.saturating_sub(2));
            [(cell, 1.0 - (at - cell as f64)), ((cell + 1).min(n - 1), at - cell as f64)]
        };
        let (rows, cols) = (self.rows.get(), self.cols.get());
        let share = |x: &DVec3| {
            let [a, b] = along(x.x, low.x, size.x, rows);
            let [c, d] = along(x.y, low.y, size.y, cols);
            [(a, c), (a, d), (b, c), (b, d)].map(|((r, u), (c, v))| ((r * cols + c) as u32, u * v))
        };
        pad.rest.iter().map(share).collect()
    }

    /// Returns, for every taxel, the nodes of the sensing triangle at its centre with their weights. Where the face does not reach,
    /// it returns those of the nearest triangle.
    pub(crate) fn samples(&self, pad: &PadTopology) -> Vec<[(u32, f64); 3]> {
        let flat = |n: u32| pad.rest[n as usize].truncate();
        let (grid, cols) = (self.over(pad), self.cols.get());
        let sample = |p: DVec2| {
            let weights = |t: &[u32; 3]| barycentric(p, t.map(flat));
            let inside = |w: &[f64; 3]| w.iter().copied().fold(f64::INFINITY, f64::min);
            let best = pad.sensing.iter().map(|t| (t, weights(t))).max_by(|a, b| inside(&a.1).total_cmp(&inside(&b.1)));
            let (t, w) = best.unwrap_or((&[0; 3], [1.0, 0.0, 0.0]));
            let w = w.map(|w| w.max(0.0));
            let sum: f64 = w.iter().sum();
            [0, 1, 2].map(|k| (t[k], w[k] / sum))
        };
        (0..self.taxels()).map(|k| sample(grid.point(k / cols, k % cols))).collect()
    }
}

/// Returns lower corner and size of the sensing face, m, pad frame.
fn extent(pad: &PadTopology) -> (DVec2, DVec2) {
    let face = pad.sensing.iter().flatten().map(|n| pad.rest[*n as usize].truncate());
    let (low, high) = face.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    (low, high - low)
}
