//! Curves over epochs, with a logarithmic axis.

use super::draw::{INK, LINE, MUTED, PAPER, Rgb, clear, frame, polyline};
use super::text::{Align, Label};
use crate::error::{Error, Result};
use tiny_skia::Pixmap;

/// Width and height, pixels.
const SIZE: (u32, u32) = (900, 560);
/// Left, top, right, bottom of the plot, pixels.
const BOX: (f32, f32, f32, f32) = (90.0, 40.0, 870.0, 500.0);
/// Colours of the curves, in turn.
const COLORS: [Rgb; 3] = [[31, 119, 180], [214, 96, 20], [44, 140, 60]];

/// Draws named curves of positive values, one value per epoch.
///
/// # Errors
/// Fails if there is no memory for the picture or the font cannot be loaded.
pub fn render_curves(curves: &[(&str, Vec<f64>)]) -> Result<Pixmap> {
    let no_memory = || Error::file("picture", "no memory for the picture");
    let mut page = Pixmap::new(SIZE.0, SIZE.1).ok_or_else(no_memory)?;
    let label = Label::new()?;
    clear(&mut page, PAPER);
    let (left, top, right, bottom) = BOX;
    let drawn = |v: f64| v.is_finite() && v > 0.0;
    let values = || curves.iter().flat_map(|c| c.1.iter().copied()).filter(|v| drawn(*v)).map(f64::log10);
    let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
    let (low, high) = if low < high { (low.floor(), high.ceil()) } else { (-1.0, 1.0) };
    let y = |v: f64| bottom - (bottom - top) * ((v.log10() - low) / (high - low)) as f32;
    for decade in low as i32..=high as i32 {
        let at = y(10_f64.powi(decade));
        polyline(&mut page, &[(left, at), (right, at)], 1.0, LINE, 1.0);
        label.draw(&mut page, &format!("1e{decade}"), (left - 8.0, at + 5.0), 15.0, MUTED, Align::Right);
    }
    frame(&mut page, left, top, right - left, bottom - top, LINE);
    let longest = curves.iter().map(|c| c.1.len()).max().unwrap_or(0).max(2);
    let x = |i: usize| left + (right - left) * i as f32 / (longest - 1) as f32;
    for (k, (name, values)) in curves.iter().enumerate() {
        let color = COLORS[k % COLORS.len()];
        let points: Vec<_> =
            values.iter().enumerate().filter(|(_, v)| drawn(**v)).map(|(i, v)| (x(i), y(*v))).collect();
        polyline(&mut page, &points, 2.0, color, 1.0);
        label.draw(&mut page, name, (right - 12.0, top + 26.0 + 22.0 * k as f32), 17.0, color, Align::Right);
    }
    label.draw(
        &mut page,
        &format!("epoch, 1 to {longest}"),
        (0.5 * (left + right), bottom + 34.0),
        16.0,
        INK,
        Align::Center,
    );
    label.draw(&mut page, "loss", (left, top - 12.0), 16.0, INK, Align::Left);
    Ok(page)
}
