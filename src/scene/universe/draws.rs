//! Random draws from ranges, as numbers with a short decimal form.

use crate::span::Span;
use base::random::Random;

/// Random draws from ranges.
pub(super) struct Draws(pub Random);

impl Draws {
    /// Draws uniformly between two values.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.uniform()
    }

    /// Draws uniformly from a range.
    pub fn within(&mut self, span: &Span) -> f64 {
        self.between(span.0[0].get(), span.0[1].get())
    }

    /// Draws log-uniformly from a range.
    pub fn factor(&mut self, span: &Span) -> f64 {
        self.between(span.0[0].get().ln(), span.0[1].get().ln()).exp()
    }

    /// Returns true with probability `part`.
    pub fn is_in(&mut self, part: f64) -> bool {
        self.0.uniform() < part
    }
}

/// Returns the value rounded to six significant digits, so that its decimal form is short.
pub(super) fn round_for_text(value: f64) -> f64 {
    let unit = 10.0_f64.powf(value.abs().max(f64::MIN_POSITIVE).log10().floor() - 5.0);
    // Division by an integer power of ten gives the double nearest to the decimal number.
    if unit < 1.0 { (value / unit).round() / (1.0 / unit).round() } else { (value / unit).round() * unit }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drawn_numbers_are_those_that_a_file_holds() {
        for value in [0.0123456789, 12.345678, 1.23456789e-5, 123456789.0, 9.81] {
            let written = round_for_text(value);
            assert!((written / value - 1.0).abs() < 5e-6, "{written} for {value}");
            assert!(format!("{written}").len() <= 12, "{written}");
        }
    }
}
