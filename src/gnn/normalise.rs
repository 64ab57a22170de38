//! Brings features to mean 0 and variance 1, with the statistics of the training set only.

use super::features::Parity;
use serde::{Deserialize, Serialize};

/// Deviation of a feature below which its changes are not magnified: features are dimensionless, and what hardly varies in a
/// training set would else make a network wild where it does.
const SMALL: f64 = 1e-3;

/// Mean and scale of each column.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Normaliser {
    mean: Vec<f32>,
    scale: Vec<f32>,
}

impl Normaliser {
    /// From the rows of a training set. A column that changes sign in a mirror has mean zero, so that mirroring commutes.
    pub fn fit<'a>(sets: impl Iterator<Item = &'a [f32]>, parity: &[Parity]) -> Self {
        let cols = parity.len();
        let (mut count, mut sum, mut square) = (0.0, vec![0.0; cols], vec![0.0; cols]);
        for row in sets.flat_map(|s| s.chunks_exact(cols)) {
            count += 1.0;
            for (c, v) in row.iter().enumerate() {
                sum[c] += f64::from(*v);
                square[c] += f64::from(*v).powi(2);
            }
        }
        let mean = |c: usize| if parity[c] == Parity::Even { sum[c] / f64::max(count, 1.0) } else { 0.0 };
        let scale = |c: usize| {
            let deviation = (square[c] / f64::max(count, 1.0) - mean(c).powi(2)).max(0.0).sqrt();
            // A column that never changes says nothing: it becomes zero.
            if deviation > 1e-6 * mean(c).abs().max(1e-6) { deviation.max(SMALL) } else { f64::INFINITY }
        };
        let inverse = |c: usize| (1.0 / scale(c)) as f32;
        Self { mean: (0..cols).map(|c| mean(c) as f32).collect(), scale: (0..cols).map(inverse).collect() }
    }

    /// Normalised rows, mirrored first.
    pub fn apply(&self, rows: &[f32], parity: &[Parity], mirror: (bool, bool)) -> Vec<f32> {
        let columns: Vec<_> =
            (0..parity.len()).map(|c| (parity[c].sign(mirror), self.mean[c], self.scale[c])).collect();
        let row = |row: &[f32]| row.iter().zip(&columns).map(|(v, (s, m, k))| (v * s - m) * k).collect::<Vec<_>>();
        rows.chunks_exact(parity.len().max(1)).flat_map(row).collect()
    }

    /// Normalised rows into rows of `stride` numbers.
    pub fn apply_to(&self, rows: &[f32], out: &mut [f32], stride: usize) {
        let cols = self.mean.len();
        for (row, out) in rows.chunks_exact(cols).zip(out.chunks_exact_mut(stride)) {
            for c in 0..cols {
                out[c] = (row[c] - self.mean[c]) * self.scale[c];
            }
        }
    }
}
