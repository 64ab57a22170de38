//! Lines, boxes and arrows on a pixmap; coordinates in pixels from the top left.

use tiny_skia::{Color, FillRule, LineCap, Paint, Path, PathBuilder, Pixmap, Rect, Stroke, Transform};

/// Colour: red, green, blue in 0..=255.
pub type Rgb = [u8; 3];

/// Position: x right, y down, pixels.
type Point = (f32, f32);

/// Colour of text and axes.
pub const TEXT_COLOR: Rgb = [38, 42, 51];
/// Colour of secondary text.
pub const SECONDARY_COLOR: Rgb = [106, 114, 128];
/// Colour of grid lines and frames.
pub const GRID_COLOR: Rgb = [196, 201, 209];
/// Colour of the background of the page.
pub const BACKGROUND_COLOR: Rgb = [252, 252, 250];

/// Returns a paint of uniform colour; `alpha` in 0..=1.
pub fn paint(rgb: Rgb, alpha: f32) -> Paint<'static> {
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    paint.set_color_rgba8(rgb[0], rgb[1], rgb[2], (alpha.clamp(0.0, 1.0) * 255.0) as u8);
    paint
}

/// Fills the whole pixmap.
pub fn clear(pixmap: &mut Pixmap, rgb: Rgb) {
    pixmap.fill(Color::from_rgba8(rgb[0], rgb[1], rgb[2], 255));
}

/// Draws straight segments through `points`.
pub fn polyline(pixmap: &mut Pixmap, points: &[Point], width: f32, rgb: Rgb, alpha: f32) {
    let mut builder = PathBuilder::new();
    for (i, &(x, y)) in points.iter().enumerate() {
        if i == 0 { builder.move_to(x, y) } else { builder.line_to(x, y) }
    }
    if let Some(path) = builder.finish() {
        let stroke = Stroke { width, line_cap: LineCap::Round, ..Stroke::default() };
        pixmap.stroke_path(&path, &paint(rgb, alpha), &stroke, Transform::identity(), None);
    }
}

/// Draws an arrow from `from` to `to` with a filled head, `width` wide.
pub fn arrow(pixmap: &mut Pixmap, from: Point, to: Point, width: f32, rgb: Rgb) {
    if let Some((neck, head)) = arrow_shape(from, to, width) {
        polyline(pixmap, &[from, neck], width, rgb, 1.0);
        fill(pixmap, &head, rgb);
    }
}

/// Draws an arrow with a thin dark outline, readable on any colour.
pub fn outlined_arrow(pixmap: &mut Pixmap, from: Point, to: Point, width: f32, rgb: Rgb) {
    if let Some((neck, [a, b, c])) = arrow_shape(from, to, width) {
        polyline(pixmap, &[from, neck], width + 1.6, TEXT_COLOR, 0.75);
        polyline(pixmap, &[a, b, c, a], 1.6, TEXT_COLOR, 0.75);
        arrow(pixmap, from, to, width, rgb);
    }
}

/// Returns the end of the shaft and the corners of the head; `None` if the arrow is shorter than half a pixel.
fn arrow_shape(from: Point, to: Point, width: f32) -> Option<(Point, [Point; 3])> {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let length = dx.hypot(dy);
    if !(length.is_finite() && length > 0.5) {
        return None;
    }
    let (ux, uy) = (dx / length, dy / length);
    let head = (5.0 * width).min(0.6 * length);
    let neck = (to.0 - head * ux, to.1 - head * uy);
    let half = 0.45 * head;
    Some((neck, [to, (neck.0 - half * uy, neck.1 + half * ux), (neck.0 + half * uy, neck.1 - half * ux)]))
}

/// Draws a filled polygon.
pub fn fill(pixmap: &mut Pixmap, points: &[Point], rgb: Rgb) {
    if let Some(path) = closed(points) {
        pixmap.fill_path(&path, &paint(rgb, 1.0), FillRule::Winding, Transform::identity(), None);
    }
}

/// Draws the outline of a box.
pub fn frame(pixmap: &mut Pixmap, x: f32, y: f32, w: f32, h: f32, rgb: Rgb) {
    polyline(pixmap, &[(x, y), (x + w, y), (x + w, y + h), (x, y + h), (x, y)], 1.0, rgb, 1.0);
}

/// Draws a filled box.
pub fn rectangle(pixmap: &mut Pixmap, x: f32, y: f32, w: f32, h: f32, rgb: Rgb) {
    if let Some(rect) = Rect::from_xywh(x, y, w, h) {
        pixmap.fill_rect(rect, &paint(rgb, 1.0), Transform::identity(), None);
    }
}

fn closed(points: &[Point]) -> Option<Path> {
    let mut builder = PathBuilder::new();
    for (i, &(x, y)) in points.iter().enumerate() {
        if i == 0 { builder.move_to(x, y) } else { builder.line_to(x, y) }
    }
    builder.close();
    builder.finish()
}
