//! Charts as PNG and SVG, drawn by the same code.

use super::draw::{BACKGROUND_COLOR, clear};
use super::sheet::PixmapBackend;
use super::text::Label;
use crate::render::{Pixmap, save};
use base::error::{Error, Result};
use base::files::atomic::write_atomic;
use plotters::coord::Shift;
use plotters::coord::combinators::LogCoord;
use plotters::coord::ranged1d::ValueFormatter;
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};
use std::ops::Range;
use std::path::Path;

/// Width and height, pixels.
pub const CHART_SIZE: (u32, u32) = (1200, 640);
/// Width of the text list next to the plot, pixels.
pub const LIST_WIDTH: u32 = 400;
const FONT: &str = "sans-serif";
/// Colour of axes and labels.
pub const AXIS_COLOR: RGBColor = RGBColor(38, 42, 51);
/// Colour of secondary content.
pub const SECONDARY_COLOR: RGBColor = RGBColor(106, 114, 128);
/// Colours of the two kinds of lines and points.
pub const SERIES_COLORS: [RGBColor; 2] = [RGBColor(31, 119, 180), RGBColor(214, 96, 20)];

/// Area on which a chart is drawn.
pub type Area<B> = DrawingArea<B, Shift>;
/// Result of drawing.
pub type DrawResult<B> = std::result::Result<(), DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>>;

/// Chart that can be drawn on any backend.
pub trait DrawChart {
    /// Draws the plot.
    ///
    /// # Errors
    /// Fails if the backend of the file fails.
    fn plot<B: DrawingBackend>(&self, area: &Area<B>) -> DrawResult<B>;

    /// Returns the lines of text next to the plot, with their colours.
    fn list(&self) -> Vec<(String, RGBColor)>;
}

/// Writes `name.png` and `name.svg` into `dir`.
///
/// # Errors
/// Fails if the font cannot be loaded, the drawing fails or a file cannot be written.
pub fn save_picture(picture: &impl DrawChart, dir: &Path, name: &str) -> Result<()> {
    let png = dir.join(name).with_extension("png");
    let refuse = |message: String| Error::file(&png, message);
    register_font(FONT, FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT)
        .map_err(|_| refuse("the embedded font cannot be read".into()))?;
    let mut svg = String::new();
    draw(&SVGBackend::with_string(&mut svg, CHART_SIZE).into_drawing_area(), picture).map_err(refuse)?;
    write_atomic(&png.with_extension("svg"), svg.as_bytes())?;
    let mut page = Pixmap::new(CHART_SIZE.0, CHART_SIZE.1).ok_or_else(|| refuse("no memory for the picture".into()))?;
    clear(&mut page, BACKGROUND_COLOR);
    draw(&PixmapBackend::new(&mut page, &Label::new()?).into_drawing_area(), picture).map_err(refuse)?;
    save(&page, &png)
}

fn draw<B: DrawingBackend>(page: &Area<B>, picture: &impl DrawChart) -> std::result::Result<(), String> {
    page.fill(&RGBColor(BACKGROUND_COLOR[0], BACKGROUND_COLOR[1], BACKGROUND_COLOR[2])).map_err(|e| e.to_string())?;
    let (plot, list) = page.split_horizontally(CHART_SIZE.0 - LIST_WIDTH);
    picture.plot(&plot).map_err(|e| e.to_string())?;
    for ((text, color), y) in picture.list().into_iter().zip((30..).step_by(22)) {
        list.draw(&Text::new(text, (8, y), text_style(15, &color))).map_err(|e| e.to_string())?;
    }
    page.present().map_err(|e| e.to_string())
}

/// Returns the text style of `size` pixels.
pub fn text_style(size: u32, color: &RGBColor) -> TextStyle<'static> {
    (FONT, size).into_font().color(color)
}

/// Plane with two logarithmic axes.
type Plane<'a, B> = ChartContext<'a, B, Cartesian2d<LogCoord<f64>, LogCoord<f64>>>;

/// Draws logarithmic axes and grid, given the range and the name of each axis.
///
/// # Errors
/// Fails if the backend of the file fails.
pub fn axes<'a, B: DrawingBackend>(
    area: &'a Area<B>,
    (x, x_name): (Range<f64>, String),
    (y, y_name): (Range<f64>, String),
) -> std::result::Result<Plane<'a, B>, DrawingAreaErrorKind<B::ErrorType>> {
    let mut plane = ChartBuilder::on(area)
        .margin(18)
        .x_label_area_size(52)
        .y_label_area_size(72)
        .build_cartesian_2d(x.log_scale(), y.log_scale())?;
    label(&mut plane, [&x_name, &y_name], &number)?;
    Ok(plane)
}

/// Draws the grid and the axes of a plane with their names and tick labels.
///
/// # Errors
/// Fails if the backend of the file fails.
pub fn label<B: DrawingBackend, X, Y>(
    plane: &mut ChartContext<B, Cartesian2d<X, Y>>,
    [x_name, y_name]: [&str; 2],
    number: &dyn Fn(&f64) -> String,
) -> DrawResult<B>
where
    X: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    plane
        .configure_mesh()
        .bold_line_style(SECONDARY_COLOR.mix(0.35))
        .light_line_style(TRANSPARENT)
        .axis_style(AXIS_COLOR)
        .label_style(text_style(15, &AXIS_COLOR))
        .axis_desc_style(text_style(17, &AXIS_COLOR))
        .x_desc(x_name)
        .y_desc(y_name)
        .x_label_formatter(number)
        .y_label_formatter(number)
        .draw()
}

/// Returns the range of a logarithmic axis that contains all positive `values` with a margin.
pub fn range(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = values
        .filter(|v| v.is_finite() && *v > 0.0)
        .fold((f64::INFINITY, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
    if low <= high { (low / 1.6)..(high * 1.6) } else { 0.1..10.0 }
}

/// Formats a tick label.
fn number(v: &f64) -> String {
    if *v < 0.01 { format!("{v:.0e}") } else { format!("{v}") }
}
