//! Numbers of the charts that the page draws.

use serde::Serialize;

/// Chart; one of its quantities is shown at a time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Chart {
    /// Title of the chart.
    pub title: String,
    /// Abscissa of the numbers.
    pub over: Over,
    /// Quantities to choose from.
    pub quantities: Vec<Quantity>,
}

/// Abscissa of the numbers of a chart.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Over {
    /// Names, each with a bar.
    Names(Vec<String>),
    /// Numbers, over which lines are drawn.
    Axis {
        /// Name of the axis with its unit.
        label: String,
        /// Positions of the numbers on the axis.
        at: Vec<f64>,
    },
}

/// Quantity with its series; over names these are median, 90th percentile and worst value.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Quantity {
    /// Name of the quantity.
    pub name: String,
    /// Unit of the quantity.
    pub unit: String,
    /// Series, three at most.
    pub series: Vec<Series>,
}

/// Series of a quantity, as long as the abscissa.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Series {
    /// Name for the key of the chart.
    pub name: String,
    /// Values; NaN where there is none.
    pub values: Vec<f64>,
}

impl Series {
    /// Returns a series.
    pub fn new(name: &str, values: Vec<f64>) -> Self {
        Self { name: name.into(), values }
    }
}
