//! Perceptually uniform colour map: dark violet through green to yellow, with monotonically increasing luminance.

/// Coefficients of t^0 .. t^6 for red, green and blue: a least-squares fit to ten samples of viridis, within 4 of 255.
const FIT: [[f64; 7]; 3] = [
    [0.2668, 0.2573, -1.2199, -2.2138, 3.1572, 6.5065, -5.7621],
    [0.0039, 1.4306, -0.2832, -3.4314, 9.4720, -9.4631, 3.1770],
    [0.3294, 1.5209, -1.2714, -13.9227, 47.1078, -57.6498, 24.0308],
];

/// Returns the colour at `t`, clamped to 0..=1 (NaN counts as 0), each channel in 0..=255.
pub fn color(t: f64) -> [f32; 3] {
    let t = if t.is_nan() { 0.0 } else { t.clamp(0.0, 1.0) };
    FIT.map(|fit| (255.0 * fit.iter().rev().fold(0.0, |sum, c| sum * t + c)).clamp(0.0, 255.0) as f32)
}

/// Returns the relative position of `value` in `range`, 0 at its lower and 1 at its upper end (not clamped).
pub fn fraction(value: f64, range: (f64, f64)) -> f64 {
    let span = range.1 - range.0;
    if span > 0.0 { (value - range.0) / span } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brightness_rises_and_the_ends_are_violet_and_yellow() {
        let luma = |t: f64| color(t).iter().zip([0.2126, 0.7152, 0.0722]).map(|(c, w)| c * w).sum::<f32>();
        assert!((0..100).all(|i| luma(f64::from(i + 1) / 100.0) > luma(f64::from(i) / 100.0)));
        let close = |got: [f32; 3], want: [f32; 3]| got.iter().zip(want).all(|(g, w)| (g - w).abs() < 6.0);
        assert!(close(color(0.0), [68.0, 1.0, 84.0]));
        assert!(close(color(1.0), [253.0, 231.0, 37.0]));
        assert_eq!(color(f64::NAN), color(0.0));
    }
}
