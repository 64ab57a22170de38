//! Pictures of truth above prediction, with the same colour and arrow scales.

use base::error::{Error, Result};
use dataset::ObjectFile;
use record::Frame;
use record::render::{Pixmap, Scalar, Style, WIDTH, longest_arrow, render_pads};
use tiny_skia::{PixmapPaint, Transform};

/// Draws a frame of grasp `number` above its prediction.
///
/// # Errors
/// Fails if the frame cannot be drawn.
pub fn draw(file: &ObjectFile, number: usize, truth: &Frame, predicted: &Frame) -> Result<Pixmap> {
    let range = |scalar: Scalar| {
        let largest = truth.pads.iter().flat_map(|p| scalar.values(p)).fold(0.0, f64::max);
        (largest > 0.0).then_some((0.0, largest))
    };
    let longest = Some(longest_arrow(&file.pads, truth)).filter(|longest| *longest > 0.0);
    let picture = |what: &str, frame: &Frame| {
        let title = format!("{}, grasp {number:03}: {what}", file.name);
        let plain = Style::default();
        let style = Style { title, range: range(plain.scalar), face_range: range(plain.face), longest, ..plain };
        render_pads(&file.pads, frame, Some(&file.object), &style)
    };
    let (above, below) = (picture("finite elements", truth)?, picture("network", predicted)?);
    let no_memory = || Error::file("picture", "no memory for the picture");
    let mut page = Pixmap::new(WIDTH, above.height() + below.height()).ok_or_else(no_memory)?;
    let mut paste = |picture: &Pixmap, y: u32| {
        page.draw_pixmap(0, y as i32, picture.as_ref(), &PixmapPaint::default(), Transform::identity(), None);
    };
    paste(&above, 0);
    paste(&below, above.height());
    Ok(page)
}
