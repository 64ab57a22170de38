//! Range of values.

use super::leaf::Positive;
use super::vector::Tuple;

/// Range from the smallest to the largest value.
pub type Span = Tuple<Positive, 2>;

impl Tuple<Positive, 2> {
    /// Returns the linear interpolation at `part` (0..1) of the range.
    pub fn interpolate(self, part: f64) -> f64 {
        let [low, high] = self.0.map(Positive::get);
        low + part * (high - low)
    }
}
