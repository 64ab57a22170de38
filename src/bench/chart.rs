//! Time against error, both logarithmic, as PNG and as SVG: points, the Pareto front, what is dominated.

use super::report::{Point, Report};
use crate::error::{Error, Result};
use crate::record::files::write_atomic;
use crate::render::{Pixmap, save};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};
use std::path::Path;

/// Width and height, pixels.
const SIZE: (u32, u32) = (1200, 640);
/// Width of the list of configurations, pixels.
const LIST: u32 = 400;
const FONT: &str = "sans-serif";
const INK: RGBColor = RGBColor(38, 42, 51);
const MUTED: RGBColor = RGBColor(106, 114, 128);
const SETTING: RGBColor = RGBColor(31, 119, 180);
const CONTENDER: RGBColor = RGBColor(214, 96, 20);

/// Writes `bench.png` and `bench.svg` into `dir`.
///
/// # Errors
/// Files that cannot be written; a contest without a single time and error.
pub fn save_chart(report: &Report, dir: &Path) -> Result<()> {
    let refuse = |message: String| Error::file(dir.join("bench.png"), message);
    register_font(FONT, FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT)
        .map_err(|_| refuse("the embedded font cannot be read".into()))?;
    let mut svg = String::new();
    draw(&SVGBackend::with_string(&mut svg, SIZE).into_drawing_area(), report).map_err(refuse)?;
    write_atomic(&dir.join("bench.svg"), svg.as_bytes())?;
    let mut rgb = vec![0; 3 * (SIZE.0 * SIZE.1) as usize];
    draw(&BitMapBackend::with_buffer(&mut rgb, SIZE).into_drawing_area(), report).map_err(refuse)?;
    let mut page = Pixmap::new(SIZE.0, SIZE.1).ok_or_else(|| refuse("no memory for the picture".into()))?;
    let opaque = rgb.as_chunks::<3>().0.iter().flat_map(|[r, g, b]| [*r, *g, *b, 255]);
    page.data_mut().iter_mut().zip(opaque).for_each(|(slot, value)| *slot = value);
    save(&page, &dir.join("bench.png"))
}

type Area<B> = DrawingArea<B, Shift>;

fn draw<B: DrawingBackend>(page: &Area<B>, report: &Report) -> std::result::Result<(), String> {
    page.fill(&RGBColor(252, 252, 250)).map_err(|e| e.to_string())?;
    let (plot, list) = page.split_horizontally(SIZE.0 - LIST);
    pareto(&plot, report).map_err(|e| e.to_string())?;
    names(&list, report).map_err(|e| e.to_string())?;
    page.present().map_err(|e| e.to_string())
}

/// Points that have a place, with their numbers in the list.
fn placed(report: &Report) -> Vec<(usize, &Point, (f64, f64))> {
    let all = report.points.iter().enumerate();
    all.filter_map(|(i, p)| p.place().map(|(time, error)| (i + 1, p, (time, 100.0 * error)))).collect()
}

fn color(point: &Point) -> RGBColor {
    if point.contender { CONTENDER } else { SETTING }
}

fn text_style(size: u32, color: &RGBColor) -> TextStyle<'static> {
    (FONT, size).into_font().color(color)
}

type Drawn<B> = std::result::Result<(), DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>>;

fn pareto<B: DrawingBackend>(area: &Area<B>, report: &Report) -> Drawn<B> {
    let placed = placed(report);
    let own = report.reference_error.map(|e| 100.0 * e).filter(|e| *e > 0.0);
    let range = |values: &mut dyn Iterator<Item = f64>| {
        let values: Vec<f64> = values.filter(|v| v.is_finite() && *v > 0.0).collect();
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(0.0, f64::max);
        if low <= high { (low / 1.6)..(high * 1.6) } else { 0.1..10.0 }
    };
    let times = range(&mut placed.iter().map(|p| p.2.0));
    let errors = range(&mut placed.iter().map(|p| p.2.1).chain(own));
    let mut chart = ChartBuilder::on(area)
        .margin(18)
        .x_label_area_size(52)
        .y_label_area_size(72)
        .build_cartesian_2d(times.clone().log_scale(), errors.log_scale())?;
    let number = |v: &f64| if *v < 0.01 { format!("{v:.0e}") } else { format!("{v}") };
    chart
        .configure_mesh()
        .bold_line_style(MUTED.mix(0.35))
        .light_line_style(TRANSPARENT)
        .axis_style(INK)
        .label_style(text_style(15, &INK))
        .axis_desc_style(text_style(17, &INK))
        .x_desc(format!("wall time of a grasp, s (threads: {})", report.threads))
        .y_desc("error of the displacement, % (median)")
        .x_label_formatter(&number)
        .y_label_formatter(&number)
        .draw()?;
    if let Some(own) = own {
        let line = [(times.start, own), (times.end, own)];
        chart.draw_series(DashedLineSeries::new(line, 6, 5, MUTED.into()))?;
        let name = Text::new("error of the reference itself", (times.start * 1.05, own * 1.06), text_style(14, &MUTED));
        chart.draw_series([name])?;
    }
    let mut front: Vec<(f64, f64)> = placed.iter().filter(|p| !p.1.dominated).map(|p| p.2).collect();
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    chart.draw_series(LineSeries::new(front, INK.stroke_width(2)))?;
    for (_, point, at) in &placed {
        let style = if point.dominated { color(point).stroke_width(2) } else { color(point).filled() };
        chart.draw_series([Circle::new(*at, 6, style)])?;
    }
    for (at, numbers) in labels(&placed) {
        let label = EmptyElement::at(at) + Text::new(numbers, (8, -18), text_style(16, &INK));
        chart.draw_series([label])?;
    }
    Ok(())
}

/// The number of every point; points that lie on each other share a label.
fn labels(placed: &[(usize, &Point, (f64, f64))]) -> Vec<((f64, f64), String)> {
    let near = |a: (f64, f64), b: (f64, f64)| (a.0 / b.0).ln().abs() < 0.1 && (a.1 / b.1).ln().abs() < 0.05;
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

/// What the numbers mean.
fn names<B: DrawingBackend>(area: &Area<B>, report: &Report) -> Drawn<B> {
    let mut y = 30;
    let mut line = |text: &str, color: RGBColor| {
        let drawn = area.draw(&Text::new(text.to_string(), (8, y), text_style(15, &color)));
        y += 22;
        drawn
    };
    for (number, point, _) in placed(report) {
        let beaten = if point.dominated { ", dominated" } else { "" };
        line(&format!("{number}  {}{beaten}", point.label), color(point))?;
    }
    line("", INK)?;
    line("line and full circles: the Pareto front", INK)?;
    line(&format!("errors against: {}", report.reference.label), INK)?;
    for point in report.points.iter().filter(|p| p.contender) {
        if let Some(ratio) = point.speedup_at_equal_error {
            line(&format!("speed-up at equal error: {ratio:.1} ({})", point.label), CONTENDER)?;
        }
    }
    Ok(())
}
