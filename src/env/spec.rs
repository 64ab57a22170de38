//! What an array of observations or actions holds.

/// Name, shape, unit and bounds of an array; of one environment.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ArraySpec {
    /// Its name.
    pub name: String,
    /// Its shape, row-major.
    pub shape: Vec<usize>,
    /// Unit of its numbers.
    pub unit: String,
    /// No number is below.
    pub low: f32,
    /// No number is above.
    pub high: f32,
}

impl ArraySpec {
    /// With bounds `low` to `high`.
    pub fn new(name: &str, shape: &[usize], unit: &str, [low, high]: [f64; 2]) -> Self {
        Self { name: name.into(), shape: shape.to_vec(), unit: unit.into(), low: low as f32, high: high as f32 }
    }

    /// Numbers in it.
    pub fn size(&self) -> usize {
        self.shape.iter().product()
    }
}
