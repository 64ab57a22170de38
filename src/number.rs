//! Formatting of numbers for readers.

/// Rounds a number to this many significant digits; a number that is not finite is unchanged.
pub fn rounded(v: f64, digits: usize) -> f64 {
    if v.is_finite() { format!("{v:.*e}", digits.max(1) - 1).parse().unwrap_or(v) } else { v }
}

/// Formats a number in a natural way: at most six significant digits, no trailing `.0`.
pub fn shown(v: f64) -> String {
    let six = rounded(v, 6);
    if six != 0.0 && six.is_finite() && !(1e-4..1e7).contains(&six.abs()) {
        return format!("{six:e}");
    }
    // The shortest text that reads as the same number has no more digits than were kept.
    format!("{six}")
}
