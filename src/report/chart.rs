//! Charts that the page draws: their numbers.

use serde::Serialize;

/// A chart; one of its quantities is shown at a time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Chart {
    /// What it shows.
    pub title: String,
    /// What the numbers go by.
    pub over: Over,
    /// What can be chosen.
    pub quantities: Vec<Quantity>,
}

/// What the numbers of a chart go by.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Over {
    /// A bar for each name.
    Names(Vec<String>),
    /// A line over these numbers.
    Axis {
        /// Name of the axis with its unit.
        label: String,
        /// Where the numbers are.
        at: Vec<f64>,
    },
}

/// One quantity: median, 90th percentile and worst, as long as what they go by.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Quantity {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Half of the values are at most this.
    pub median: Vec<f64>,
    /// Nine tenths of the values are at most this.
    pub p90: Vec<f64>,
    /// Largest.
    pub worst: Vec<f64>,
}
