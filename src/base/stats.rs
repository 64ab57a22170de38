//! Order statistics of samples: median, 90th percentile and maximum.

use serde::{Deserialize, Serialize};

/// Median, 90th percentile and largest of some values (nearest rank).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Quantiles {
    /// Median: half of the values are at most this.
    pub median: f64,
    /// 90th percentile: nine tenths of the values are at most this.
    pub p90: f64,
    /// Largest value.
    pub worst: f64,
}

impl Quantiles {
    /// Computes the spread of `values`; returns None if there are none.
    pub fn from_values(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut values: Vec<f64> = values.into_iter().collect();
        values.sort_by(f64::total_cmp);
        let last = values.len().checked_sub(1)?;
        let at = |part: f64| values[(last as f64 * part).round() as usize];
        Some(Self { median: at(0.5), p90: at(0.9), worst: at(1.0) })
    }
}

/// Computes the median of `values`; returns NaN if there are none.
pub fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    Quantiles::from_values(values).map_or(f64::NAN, |s| s.median)
}
