//! Normalisation of features to mean 0 and variance 1, with the statistics of the training set only. Features are also
//! clamped to the bounds of the training set: outside them a network may be wrong by orders of magnitude.

use super::parity::Parity;
use serde::{Deserialize, Serialize};

/// Largest number allowed in a card.
pub(crate) const MOST: f64 = 1e30;

/// Smallest deviation by which a feature is divided. Features are dimensionless; amplifying one that hardly varies in a
/// training set would make the network unstable where it does vary.
const SMALL: f64 = 1e-3;

/// Mean, scale and extremes of each column.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(from = "Stored")]
pub struct Normaliser {
    mean: Vec<f32>,
    scale: Vec<f32>,
    /// Smallest and largest value in the training set.
    seen: Vec<[f32; 2]>,
}

/// Stored form of a normaliser in a card; older cards have no bounds.
#[derive(Deserialize)]
struct Stored {
    mean: Vec<f32>,
    scale: Vec<f32>,
    #[serde(default)]
    seen: Vec<[f32; 2]>,
}

impl From<Stored> for Normaliser {
    fn from(Stored { mean, scale, mut seen }: Stored) -> Self {
        seen.resize(mean.len(), [f32::NEG_INFINITY, f32::INFINITY]);
        Self { mean, scale, seen }
    }
}

impl Normaliser {
    /// Fits the rows of a training set. A column that changes sign under a mirror has mean zero, so that normalisation
    /// commutes with mirroring.
    pub fn fit<'a>(sets: impl Iterator<Item = &'a [f32]> + Clone, parity: &[Parity]) -> Self {
        let all = sets.clone();
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
            // A constant column carries no information and is set to zero.
            if deviation > 1e-6 * mean(c).abs().max(1e-6) { deviation.max(SMALL) } else { f64::INFINITY }
        };
        let inverse = |c: usize| (1.0 / scale(c)) as f32;
        let [mean, scale] = [(0..cols).map(|c| mean(c) as f32).collect(), (0..cols).map(inverse).collect()];
        Self { mean, scale, seen: Vec::new() }.with_bounds_of(all, parity)
    }

    /// Extends the bounds to the rows of these sets. The bounds of a column that changes sign under a mirror are
    /// symmetric.
    pub fn with_bounds_of<'a>(mut self, sets: impl Iterator<Item = &'a [f32]>, parity: &[Parity]) -> Self {
        self.seen.resize(parity.len(), [f32::INFINITY, f32::NEG_INFINITY]);
        for row in sets.flat_map(|s| s.chunks_exact(parity.len())) {
            for ((v, [low, high]), parity) in row.iter().zip(&mut self.seen).zip(parity) {
                let mirrored = if *parity == Parity::Even { *v } else { -*v };
                *low = low.min(*v).min(mirrored);
                *high = high.max(*v).max(mirrored);
            }
        }
        self
    }

    /// Extends the bounds to those of another normaliser of the same columns; mean and scale remain.
    pub fn with_bounds_from(mut self, other: &Self) -> Self {
        for ([low, high], [other_low, other_high]) in self.seen.iter_mut().zip(&other.seen) {
            (*low, *high) = (low.min(*other_low), high.max(*other_high));
        }
        self
    }

    /// Checks that the values of the field `name`, of `cols` columns, are valid. The error states what is wrong.
    pub(crate) fn check(&self, name: &str, cols: usize) -> Result<(), String> {
        let lengths = [self.mean.len(), self.scale.len(), self.seen.len()];
        if lengths != [cols; 3] {
            return Err(format!("`normalisers.{name}` has columns of {lengths:?} numbers; allowed: {cols} each"));
        }
        let plain = |v: &f32| v.is_finite() && f64::from(v.abs()) <= MOST;
        if let Some(bad) = self.mean.iter().find(|v| !plain(v)) {
            return Err(format!("`normalisers.{name}.mean` contains {bad}; allowed: up to {MOST:e}"));
        }
        if let Some(bad) = self.scale.iter().find(|v| !plain(v) || **v < 0.0) {
            return Err(format!("`normalisers.{name}.scale` contains {bad}; allowed: 0 to {MOST:e}"));
        }
        // The bounds of an older card are infinite.
        let bounds =
            |[low, high]: [f32; 2]| (plain(&low) && plain(&high) && low <= high) || (low < high && high == -low);
        match self.seen.iter().find(|seen| !bounds(**seen)) {
            Some([low, high]) => {
                Err(format!("`normalisers.{name}.seen` goes from {low} to {high}; allowed: ascending, up to {MOST:e}"))
            }
            None => Ok(()),
        }
    }

    /// Returns normalised rows, after mirroring them.
    pub fn apply(&self, rows: &[f32], parity: &[Parity], mirror: (bool, bool)) -> Vec<f32> {
        let column = |c: usize| (parity[c].sign(mirror), self.seen[c], self.mean[c], self.scale[c]);
        let columns: Vec<_> = (0..parity.len()).map(column).collect();
        let value = |(v, (s, bounds, m, k)): (&f32, &(f32, [f32; 2], f32, f32))| (clamped(v * s, *bounds) - m) * k;
        let row = |row: &[f32]| row.iter().zip(&columns).map(value).collect::<Vec<_>>();
        rows.chunks_exact(parity.len().max(1)).flat_map(row).collect()
    }

    /// Writes normalised rows into rows of `stride` numbers.
    pub fn apply_to(&self, rows: &[f32], out: &mut [f32], stride: usize) {
        let cols = self.mean.len();
        for (row, out) in rows.chunks_exact(cols).zip(out.chunks_exact_mut(stride)) {
            for c in 0..cols {
                out[c] = (clamped(row[c], self.seen[c]) - self.mean[c]) * self.scale[c];
            }
        }
    }
}

/// Returns `v` clamped to its bounds. NaN is preserved and detected later.
fn clamped(v: f32, [low, high]: [f32; 2]) -> f32 {
    if v < low {
        low
    } else if v > high {
        high
    } else {
        v
    }
}
