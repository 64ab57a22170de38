//! Curves over epochs, with a logarithmic axis.

use super::draw::{BACKGROUND_COLOR, GRID_COLOR, Rgb, SECONDARY_COLOR, TEXT_COLOR, clear, frame, polyline};
use super::text::{Align, Label};
use base::error::{Error, Result};
use tiny_skia::Pixmap;

/// Width and height, pixels.
const SIZE: (u32, u32) = (900, 560);
/// Left, top, right, bottom of the plot, pixels.
const BOX: (f32, f32, f32, f32) = (90.0, 40.0, 870.0, 500.0);
/// Colours of the curves, used cyclically.
const COLORS: [Rgb; 3] = [[31, 119, 180], [214, 96, 20], [44, 140, 60]];

/// Draws named curves of positive values, one value per epoch.
///
/// # Errors
/// Fails if the picture cannot be allocated or the font cannot be loaded.
pub fn render_curves(curves: &[(&str, Vec<f64>)]) -> Result<Pixmap> {
    let no_memory = || Error::file("picture", "no memory for the picture");
    let mut page = Pixmap::new(SIZE.0, SIZE.1).ok_or_else(no_memory)?;
    let label = Label::new()?;
    clear(&mut page, BACKGROUND_COLOR);
    let (left, top, right, bottom) = BOX;
    let drawn = |v: f64| v.is_finite() && v > 0.0;
    let values = || curves.iter().flat_map(|c| c.1.iter().copied()).filter(|v| drawn(*v)).map(f64::log10);
    let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
    // A degenerate range is centred on its value.
    let middle = if low.is_finite() { low } else { 0.0 };
    let (low, high) = if low < high { (low, high) } else { (middle - 0.5, middle + 0.5) };
    let rim = 0.04 * (high - low);
    let (low, high) = (low - rim, high + rim);
    let y = |v: f64| bottom - (bottom - top) * ((v.log10() - low) / (high - low)) as f32;
    for value in marks(10_f64.powf(low), 10_f64.powf(high)) {
        let at = y(value);
        polyline(&mut page, &[(left, at), (right, at)], 1.0, GRID_COLOR, 1.0);
        label.draw(&mut page, &short(value), (left - 8.0, at + 5.0), 15.0, SECONDARY_COLOR, Align::Right);
    }
    frame(&mut page, left, top, right - left, bottom - top, GRID_COLOR);
    let longest = curves.iter().map(|c| c.1.len()).max().unwrap_or(0).max(2);
    let x = |i: usize| left + (right - left) * i as f32 / (longest - 1) as f32;
    for (k, (name, values)) in curves.iter().enumerate() {
        let color = COLORS[k % COLORS.len()];
        let points: Vec<_> =
            values.iter().enumerate().filter(|(_, v)| drawn(**v)).map(|(i, v)| (x(i), y(*v))).collect();
        polyline(&mut page, &points, 2.0, color, 1.0);
        label.draw(&mut page, name, (right - 12.0, top + 26.0 + 22.0 * k as f32), 17.0, color, Align::Right);
    }
    let step = step(longest as f64 / 8.0).max(1.0) as usize;
    for epoch in std::iter::once(1).chain((step..=longest).step_by(step).filter(|epoch| *epoch > 1)) {
        let at = x(epoch - 1);
        polyline(&mut page, &[(at, bottom), (at, bottom + 5.0)], 1.0, SECONDARY_COLOR, 1.0);
        label.draw(&mut page, &epoch.to_string(), (at, bottom + 22.0), 15.0, SECONDARY_COLOR, Align::Center);
    }
    label.draw(&mut page, "epoch", (right, bottom + 44.0), 16.0, TEXT_COLOR, Align::Right);
    label.draw(&mut page, "loss", (left, top - 12.0), 16.0, TEXT_COLOR, Align::Left);
    Ok(page)
}

/// Returns the smallest of 1, 2, 5 or 10 times a power of ten that is at least `size`.
fn step(size: f64) -> f64 {
    let power = 10_f64.powf(size.log10().floor());
    [1.0, 2.0, 5.0, 10.0].map(|f| f * power).into_iter().find(|s| *s >= size * (1.0 - 1e-9)).unwrap_or(size)
}

/// Returns round tick values between `low` and `high`: 1 or 1, 2, 5 times powers of ten above one decade, otherwise
/// equally spaced.
fn marks(low: f64, high: f64) -> Vec<f64> {
    if high > 10.0 * low {
        let decades = low.log10().ceil() as i32..=high.log10().floor() as i32;
        let each: &[f64] = if high > 1e3 * low { &[1.0] } else { &[1.0, 2.0, 5.0] };
        let all =
            decades.clone().chain([decades.start() - 1]).flat_map(|d| each.iter().map(move |f| f * 10_f64.powi(d)));
        return all.filter(|v| (low..=high).contains(v)).collect();
    }
    let step = step((high - low) / 6.0);
    ((low / step).ceil() as i64..=(high / step).floor() as i64).map(|k| k as f64 * step).collect()
}

/// Formats a tick value without trailing zeros.
fn short(value: f64) -> String {
    if (1e-3..1e4).contains(&value) { format!("{}", (value * 1e6).round() / 1e6) } else { format!("{value:.0e}") }
}
