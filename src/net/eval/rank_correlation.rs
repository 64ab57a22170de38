//! Rank correlation.

/// Computes Kendall's tau-b (Kendall 1945) of two lists of equal length: 1 for the same order, -1 for the opposite, 0
/// if all values of a list are equal.
pub fn kendall(a: &[f64], b: &[f64]) -> f64 {
    let (mut agree, mut pairs_a, mut pairs_b) = (0.0, 0.0, 0.0);
    for i in 0..a.len() {
        for j in 0..i {
            let order = |v: &[f64]| v[i].partial_cmp(&v[j]).map_or(0.0, |o| f64::from(o as i8));
            let (x, y) = (order(a), order(b));
            agree += x * y;
            pairs_a += x.abs();
            pairs_b += y.abs();
        }
    }
    if pairs_a * pairs_b > 0.0 { agree / f64::sqrt(pairs_a * pairs_b) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::kendall;

    #[test]
    fn known_orders_have_known_correlations() {
        let a = [1.0, 2.0, 3.0, 4.0];
        assert_eq!(kendall(&a, &[10.0, 20.0, 30.0, 40.0]), 1.0);
        assert_eq!(kendall(&a, &[4.0, 3.0, 2.0, 1.0]), -1.0);
        // One discordant pair of six: (5 - 1) / 6.
        assert!((kendall(&a, &[2.0, 1.0, 3.0, 4.0]) - 4.0 / 6.0).abs() < 1e-12);
        assert_eq!(kendall(&a, &[1.0; 4]), 0.0);
    }
}
