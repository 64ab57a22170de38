//! Formatting of numbers for readers.

/// Rounds a number to `digits` significant digits; a number that is not finite is unchanged.
pub fn round_significant(v: f64, digits: usize) -> f64 {
    if v.is_finite() { format!("{v:.*e}", digits.max(1) - 1).parse().unwrap_or(v) } else { v }
}

/// Formats a number with at most six significant digits and no trailing `.0`; very small and large ones in scientific
/// notation.
pub fn format_number(v: f64) -> String {
    let six = round_significant(v, 6);
    if six != 0.0 && six.is_finite() && !(1e-4..1e7).contains(&six.abs()) {
        return format!("{six:e}");
    }
    // Rust prints the shortest text that parses to the same number: never more than the six digits.
    format!("{six}")
}

/// Formats a count with its noun in singular or plural: `1 grasp`, `3 grasps`, `2 vertices`.
pub fn format_count(count: usize, noun: &str) -> String {
    const IRREGULAR: [(&str, &str); 4] =
        [("tetrahedron", "tetrahedra"), ("vertex", "vertices"), ("entry", "entries"), ("try", "tries")];
    let several = || match IRREGULAR.iter().find_map(|(one, all)| Some((noun.strip_suffix(one)?, all))) {
        Some((before, all)) => format!("{before}{all}"),
        None => format!("{noun}s"),
    };
    format!("{count} {}", if count == 1 { noun.to_string() } else { several() })
}

#[cfg(test)]
mod tests {
    use super::format_count;

    #[test]
    fn nouns_follow_their_count() {
        let found = [(1, "object"), (0, "grasp"), (2, "repeated vertex"), (1, "tetrahedron"), (96, "tetrahedron")];
        let expected = ["1 object", "0 grasps", "2 repeated vertices", "1 tetrahedron", "96 tetrahedra"];
        assert_eq!(found.map(|(count, noun)| format_count(count, noun)), expected);
    }
}
