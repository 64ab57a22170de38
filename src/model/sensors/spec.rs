//! Specification of an array of observations or actions.

/// Name, shape, unit and bounds of an array of one environment.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ArraySpec {
    /// Name of the array.
    pub name: String,
    /// Shape of the array, row-major.
    pub shape: Vec<usize>,
    /// Unit of the values.
    pub unit: String,
    /// Lower bound of all values.
    pub low: f32,
    /// Upper bound of all values.
    pub high: f32,
}

impl ArraySpec {
    /// Creates the specification of an array with bounds `low` to `high`.
    pub fn new(name: &str, shape: &[usize], unit: &str, [low, high]: [f64; 2]) -> Self {
        Self { name: name.into(), shape: shape.to_vec(), unit: unit.into(), low: low as f32, high: high as f32 }
    }

    /// Returns the name of the array in files, ending in the unit if there is a single unit.
    pub fn file_name(&self) -> String {
        let ending = match self.unit.as_str() {
            "m" => "_m",
            "m2" => "_m2",
            "N" => "_n",
            "Pa" => "_pa",
            _ => "",
        };
        format!("{}{ending}", self.name)
    }

    /// Returns the number of values.
    pub fn size(&self) -> usize {
        self.shape.iter().product()
    }
}
