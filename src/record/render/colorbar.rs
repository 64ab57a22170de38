//! Round tick values, and the colour bar.

use super::colormap::{color, fraction};
use super::draw::{TEXT_COLOR, frame, polyline, rectangle};
use super::text::{Align, Label};
use tiny_skia::Pixmap;

/// Returns about `count` tick values inside `range`, spaced by 1, 2 or 5 times a power of ten, with their labels.
pub fn ticks(range: (f64, f64), count: usize) -> Vec<(f64, String)> {
    let span = range.1 - range.0;
    if !(span.is_finite() && span > 0.0) {
        return Vec::new();
    }
    let rough = span / count.max(1) as f64;
    let power = rough.log10().floor();
    let unit = 10f64.powf(power);
    let Some(step) = [1.0, 2.0, 5.0, 10.0].map(|f| f * unit).into_iter().find(|&s| s >= rough * 0.999) else {
        return Vec::new();
    };
    let decimals = (-step.log10().floor()).max(0.0) as usize;
    let first = (range.0 / step - 1e-9).ceil();
    (0..=count + 1)
        .map(|i| (first + i as f64) * step)
        .take_while(|&v| v <= range.1 + 1e-9 * span)
        .map(|v| {
            // Adding zero turns -0 into 0.
            let v = if v.abs() < 1e-9 * span { 0.0 } else { v };
            (v, if decimals > 5 || step >= 1e6 { format!("{v:.1e}") } else { format!("{v:.decimals$}") })
        })
        .collect()
}

/// Draws a vertical colour bar of `size` (width, height) with its top left corner at `at` and the title above it.
pub fn draw(page: &mut Pixmap, label: &Label, at: (f32, f32), size: (f32, f32), range: (f64, f64), title: &str) {
    let rows = size.1.max(1.0) as usize;
    for row in 0..rows {
        let t = 1.0 - (row as f64 + 0.5) / rows as f64;
        let rgb = color(t).map(|c| c.round() as u8);
        rectangle(page, at.0, at.1 + row as f32, size.0, 1.0, rgb);
    }
    frame(page, at.0, at.1, size.0, size.1, TEXT_COLOR);
    for (value, text) in ticks(range, 8) {
        let y = at.1 + size.1 * (1.0 - fraction(value, range) as f32);
        polyline(page, &[(at.0 + size.0, y), (at.0 + size.0 + 5.0, y)], 1.0, TEXT_COLOR, 1.0);
        label.draw(page, &text, (at.0 + size.0 + 10.0, y + 5.0), 16.0, TEXT_COLOR, Align::Left);
    }
    label.draw(page, title, (at.0, at.1 - 14.0), 17.0, TEXT_COLOR, Align::Left);
}

#[cfg(test)]
mod tests {
    use super::ticks;

    #[test]
    fn ticks_are_round_and_inside() {
        let labels = |range| ticks(range, 5).into_iter().map(|(_, text)| text).collect::<Vec<_>>();
        assert_eq!(labels((0.0, 10.0)), ["0", "2", "4", "6", "8", "10"]);
        assert_eq!(labels((-0.3, 0.3)), ["-0.2", "0.0", "0.2"]);
        assert_eq!(labels((0.0, 0.0123)), ["0.000", "0.005", "0.010"]);
        assert!(labels((1.0, 1.0)).is_empty());
        assert!(labels((0.0, f64::INFINITY)).is_empty());
    }
}
