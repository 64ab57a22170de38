//! Picture of the fits: forces against depth above, residuals below.

use super::FitReport;
use super::report::{format_2_digits, format_4_digits};
use base::error::Result;
use base::number::format_number;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use record::render::canvas::{AXIS_COLOR, Area, DrawChart, DrawResult, SECONDARY_COLOR, label, save_picture};
use std::path::Path;

/// Colours: one per parameter fitted alone, then of the best pair and of the fit of all.
const COLORS: [RGBColor; 6] = [
    RGBColor(31, 119, 180),
    RGBColor(214, 96, 20),
    RGBColor(44, 140, 60),
    RGBColor(150, 70, 160),
    RGBColor(190, 30, 45),
    RGBColor(20, 150, 160),
];
/// Height of the upper plot, pixels.
const UPPER: u32 = 270;

/// Writes `fit.png` and `fit.svg` into `dir`.
///
/// # Errors
/// Fails if a file cannot be written.
pub fn save_chart(report: &FitReport, dir: &Path) -> Result<()> {
    save_picture(report, dir, "fit")
}

/// Plotted curve: its residuals, colour and name.
struct Line<'a> {
    residuals: &'a [f64],
    color: RGBColor,
    name: String,
}

impl FitReport {
    /// Returns the curves of the unchanged scene, each parameter alone, the best pair, and all parameters.
    fn lines(&self) -> Vec<Line<'_>> {
        let given =
            Line { residuals: &self.given, color: SECONDARY_COLOR, name: name("values of the scene", self.given_rms) };
        let singles = self.fits.iter().filter(|f| f.free.len() == 1);
        let drawn = singles.chain([2, self.parameters.len()].into_iter().filter_map(|count| self.best(count)));
        let mut lines = vec![given];
        for (fit, color) in drawn.zip(COLORS) {
            lines.push(Line { residuals: &fit.residuals, color, name: name(&fit.name(), fit.rms) });
        }
        lines
    }

    /// Returns the depth of every point, mm.
    fn depths(&self) -> Vec<f64> {
        self.depths_m.iter().map(|d| 1e3 * d).collect()
    }
}

fn name(what: &str, rms: f64) -> String {
    format!("{what}: {:.1} % rms", 100.0 * rms)
}

impl DrawChart for FitReport {
    fn plot<B: DrawingBackend>(&self, area: &Area<B>) -> DrawResult<B> {
        let (upper, lower) = area.split_vertically(UPPER);
        let (depths, lines) = (self.depths(), self.lines());
        let deepest = 1.08 * depths.iter().copied().fold(0.0, f64::max);
        let force = |line: &Line, k: usize| self.forces_n[k] * (1.0 + line.residuals[k]);
        let most = lines.iter().flat_map(|l| (0..depths.len()).map(move |k| force(l, k))).fold(0.0, f64::max);
        let mut chart = axes(&upper, (deepest, 0.0, 1.08 * most), "force, N", "")?;
        for line in &lines {
            let points = depths.iter().enumerate().map(|(k, d)| (*d, force(line, k)));
            chart.draw_series(LineSeries::new(points, line.color.stroke_width(2)))?;
        }
        let measured = depths.iter().zip(&self.forces_n).map(|(d, f)| Circle::new((*d, *f), 5, AXIS_COLOR.filled()));
        chart.draw_series(measured)?;
        let percent = |r: &f64| 100.0 * r;
        let all = || lines.iter().flat_map(|l| l.residuals.iter().map(percent));
        let (low, high) = (all().fold(-1.0, f64::min), all().fold(1.0, f64::max));
        let room = 0.1 * (high - low);
        let mut chart =
            axes(&lower, (deepest, low - room, high + room), "simulated over measured - 1, %", "depth, mm")?;
        chart.draw_series(LineSeries::new([(0.0, 0.0), (deepest, 0.0)], AXIS_COLOR.stroke_width(1)))?;
        for line in &lines {
            let points: Vec<_> = depths.iter().zip(line.residuals).map(|(d, r)| (*d, percent(r))).collect();
            chart.draw_series(points.iter().map(|p| Circle::new(*p, 4, line.color.filled())))?;
            chart.draw_series(LineSeries::new(points, line.color.stroke_width(2)))?;
        }
        Ok(())
    }

    fn list(&self) -> Vec<(String, RGBColor)> {
        let mut list = vec![("dots above: measured".to_string(), AXIS_COLOR), ("lines: fitted".into(), AXIS_COLOR)];
        list.extend(self.lines().into_iter().map(|l| (l.name, l.color)));
        list.push((String::new(), AXIS_COLOR));
        list.extend(self.best(2).into_iter().flat_map(|pair| &pair.free).map(|e| {
            let (name, scale) = e.parameter.shown_as();
            let half = e.interval.map_or(String::new(), |half| format!(" +- {}", format_2_digits(scale * half)));
            (format!("best pair: {name} {}{half}", format_4_digits(scale * e.value)), COLORS[4])
        }));
        list
    }
}

type Plane<'a, B> = ChartContext<'a, B, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// Draws linear axes from zero to `deepest` and from `low` to `high`.
fn axes<'a, B: DrawingBackend>(
    area: &'a Area<B>,
    (deepest, low, high): (f64, f64, f64),
    y_name: &str,
    x_name: &str,
) -> std::result::Result<Plane<'a, B>, DrawingAreaErrorKind<B::ErrorType>> {
    let mut plane = ChartBuilder::on(area)
        .margin(14)
        .x_label_area_size(if x_name.is_empty() { 28 } else { 50 })
        .y_label_area_size(72)
        .build_cartesian_2d(0.0..deepest, low..high)?;
    label(&mut plane, [x_name, y_name], &|v| format_number(*v))?;
    Ok(plane)
}
