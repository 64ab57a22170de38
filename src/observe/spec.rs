//! Description of an array of observations or actions.

/// Name, shape, unit and bounds of an array of one environment.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct ArraySpec {
    /// Name of the array.
    pub name: String,
    /// Shape of the array, row-major.
    pub shape: Vec<usize>,
    /// Unit of its numbers.
    pub unit: String,
    /// Lower bound of all numbers.
    pub low: f32,
    /// Upper bound of all numbers.
    pub high: f32,
}

impl ArraySpec {
    /// Describes an array with bounds `low` to `high`.
    pub fn new(name: &str, shape: &[usize], unit: &str, [low, high]: [f64; 2]) -> Self {
        Self { name: name.into(), shape: shape.to_vec(), unit: unit.into(), low: low as f32, high: high as f32 }
    }

    /// Returns the name of the array in files, which ends in its unit if there is a single one.
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

    /// Returns the number of its values.
    pub fn size(&self) -> usize {
        self.shape.iter().product()
    }
}
