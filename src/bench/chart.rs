//! Chart of error against time, both logarithmic, as PNG and as SVG: points, the Pareto front, dominated points.

use super::report::{BenchReport, Point, SpeedUp};
use base::error::Result;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use record::render::canvas::{
    AXIS_COLOR, Area, DrawChart, DrawResult, SECONDARY_COLOR, SERIES_COLORS, axes, range, save_picture, text_style,
};
use std::ops::Range;
use std::path::Path;

/// Writes the chart of the median displacement error (%) against the wall time of a grasp (s), both on logarithmic
/// axes, as `bench.png` and `bench.svg` into the folder `dir`.
///
/// # Errors
/// Fails if a file cannot be written or no point has a time and an error.
pub fn save_chart(report: &BenchReport, dir: &Path) -> Result<()> {
    save_picture(report, dir, "bench")
}

impl DrawChart for BenchReport {
    fn plot<B: DrawingBackend>(&self, area: &Area<B>) -> DrawResult<B> {
        pareto(area, self)
    }

    fn list(&self) -> Vec<(String, RGBColor)> {
        names(self)
    }
}

/// Returns the points that have a time and an error, with their numbers in the legend.
fn placed(report: &BenchReport) -> Vec<(usize, &Point, (f64, f64))> {
    let all = report.points.iter().enumerate();
    all.filter_map(|(i, p)| p.time_and_error().map(|(time, error)| (i + 1, p, (time, 100.0 * error)))).collect()
}

fn color(point: &Point) -> RGBColor {
    SERIES_COLORS[usize::from(point.contender)]
}

fn pareto<B: DrawingBackend>(area: &Area<B>, report: &BenchReport) -> DrawResult<B> {
    let placed = placed(report);
    let own = report.reference_error.map(|e| 100.0 * e).filter(|e| *e > 0.0);
    let times = range(placed.iter().map(|p| p.2.0));
    let errors = range(placed.iter().map(|p| p.2.1).chain(own));
    let name = format!("wall time of a grasp, s (threads: {})", report.threads);
    let mut chart =
        axes(area, (times.clone(), name), (errors.clone(), "error of the displacement, % (median)".into()))?;
    if let Some(own) = own {
        let line = [(times.start, own), (times.end, own)];
        chart.draw_series(DashedLineSeries::new(line, 6, 5, SECONDARY_COLOR.into()))?;
        // At the right, where no points are expected: none is both slow and inaccurate.
        let style = text_style(14, &SECONDARY_COLOR).pos(Pos::new(HPos::Right, VPos::Bottom));
        let name = Text::new("error of the reference itself", (times.end / 1.05, own * 1.04), style);
        chart.draw_series([name])?;
    }
    let mut front: Vec<(f64, f64)> = placed.iter().filter(|p| !p.1.dominated).map(|p| p.2).collect();
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    chart.draw_series(LineSeries::new(front, AXIS_COLOR.stroke_width(2)))?;
    for (_, point, at) in &placed {
        let style = if point.dominated { color(point).stroke_width(2) } else { color(point).filled() };
        chart.draw_series([Circle::new(*at, 6, style)])?;
    }
    for (at, numbers) in labels(&placed, &times, &errors) {
        let label = EmptyElement::at(at) + Text::new(numbers, (8, -18), text_style(16, &AXIS_COLOR));
        chart.draw_series([label])?;
    }
    Ok(())
}

/// Returns labels with the numbers of the points; points whose labels would overlap share one.
fn labels(
    placed: &[(usize, &Point, (f64, f64))],
    times: &Range<f64>,
    errors: &Range<f64>,
) -> Vec<((f64, f64), String)> {
    // Distance as a fraction of the axis.
    let apart = |a: f64, b: f64, axis: &Range<f64>| (a / b).ln().abs() / (axis.end / axis.start).ln();
    let near = |a: (f64, f64), b: (f64, f64)| apart(a.0, b.0, times) < 0.08 && apart(a.1, b.1, errors) < 0.03;
    let mut labels: Vec<((f64, f64), String)> = Vec::new();
    for (number, _, at) in placed {
        match labels.iter_mut().find(|(known, _)| near(*known, *at)) {
            Some((known, numbers)) => {
                known.0 = known.0.max(at.0);
                *numbers += &format!(", {number}");
            }
            None => labels.push((*at, number.to_string())),
        }
    }
    labels
}

/// Returns the lines of the legend.
fn names(report: &BenchReport) -> Vec<(String, RGBColor)> {
    let point = |(number, point, _): (usize, &Point, _)| {
        let beaten = if point.dominated { ", dominated" } else { "" };
        (format!("{number}  {}{beaten}", point.label), color(point))
    };
    let mut lines: Vec<(String, RGBColor)> = placed(report).into_iter().map(point).collect();
    lines.push((String::new(), AXIS_COLOR));
    lines.push(("line and full circles: the Pareto front".into(), AXIS_COLOR));
    lines.push((format!("errors against: {}", report.reference.label), AXIS_COLOR));
    let faster = |point: &Point| {
        let SpeedUp { ratio, is_bound, .. } = point.speedup_at_equal_error.as_ref()?;
        let most = if *is_bound { "at most " } else { "" };
        Some((format!("{most}{ratio:.1}  {}", point.label), color(point)))
    };
    let faster: Vec<_> = report.points.iter().filter(|p| p.contender).filter_map(faster).collect();
    if !faster.is_empty() {
        lines.push((String::new(), AXIS_COLOR));
        lines.push(("speed-up at equal error".into(), AXIS_COLOR));
        lines.extend(faster);
    }
    lines
}
