//! Data of the charts that the page draws.

use serde::Serialize;

/// Chart that shows one of its quantities at a time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Chart {
    /// Title of the chart.
    pub title: String,
    /// Abscissa of all quantities.
    pub over: Abscissa,
    /// Selectable quantities.
    pub quantities: Vec<ChartQuantity>,
}

/// Abscissa of a chart.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Abscissa {
    /// Category names, for a bar chart.
    Names(Vec<String>),
    /// Numeric axis, for a line chart.
    Axis {
        /// Label of the axis with its unit.
        label: String,
        /// Abscissae of the values.
        at: Vec<f64>,
    },
}

/// Quantity with its series; for category names these are median, 90th percentile and worst value.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChartQuantity {
    /// Name of the quantity.
    pub name: String,
    /// Unit of the quantity.
    pub unit: String,
    /// Series, at most three.
    pub series: Vec<Series>,
}

/// Series of a quantity, of the same length as the abscissa.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// Values; NaN if missing.
    pub values: Vec<f64>,
}

impl Series {
    /// Creates a series.
    pub fn new(name: &str, values: Vec<f64>) -> Self {
        Self { name: name.into(), values }
    }
}
