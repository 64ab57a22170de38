//! How values are spread: never the mean alone.

use serde::{Deserialize, Serialize};

/// Median, 90th percentile and largest of some values (nearest rank).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Half of the values are at most this.
    pub median: f64,
    /// Nine tenths of the values are at most this.
    pub p90: f64,
    /// Largest.
    pub worst: f64,
}

impl Spread {
    /// Of `values`; None without any.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut values: Vec<f64> = values.into_iter().collect();
        values.sort_by(f64::total_cmp);
        let last = values.len().checked_sub(1)?;
        let at = |part: f64| values[(last as f64 * part).round() as usize];
        Some(Self { median: at(0.5), p90: at(0.9), worst: at(1.0) })
    }
}

/// Median of `values`; NaN without any.
pub fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    Spread::of(values).map_or(f64::NAN, |s| s.median)
}
