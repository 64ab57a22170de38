//! Drawing backend for `plotters` on a pixmap, with text drawn by [`Label`], because `plotters` spaces letters too
//! closely.

use super::draw::clear;
use super::text::{Align, Label, blend};
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{BackendColor, BackendCoord, BackendTextStyle, DrawingBackend, DrawingErrorKind};
use std::convert::Infallible;
use tiny_skia::Pixmap;

/// Distance of the baseline from the top of the text box, relative to the font size.
const BASE: f32 = 0.75;

/// Backend that implements single pixels and text; `plotters` rasterises lines and areas.
pub struct PixmapBackend<'a> {
    pixmap: &'a mut Pixmap,
    label: &'a Label,
}

impl<'a> PixmapBackend<'a> {
    /// Creates a backend that draws on `pixmap`.
    pub fn new(pixmap: &'a mut Pixmap, label: &'a Label) -> Self {
        Self { pixmap, label }
    }

    /// Returns the width and the height of a line of text, pixels.
    fn size(&self, text: &str, size: f64) -> (u32, u32) {
        (self.label.width(text, size as f32).ceil() as u32, (size / 1.24) as u32)
    }
}

type Drawn = Result<(), DrawingErrorKind<Infallible>>;

impl DrawingBackend for PixmapBackend<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        (self.pixmap.width(), self.pixmap.height())
    }

    fn ensure_prepared(&mut self) -> Drawn {
        Ok(())
    }

    fn present(&mut self) -> Drawn {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, color: BackendColor) -> Drawn {
        let (r, g, b) = color.rgb;
        blend(self.pixmap, x, y, [r, g, b], color.alpha as f32);
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, at: BackendCoord) -> Drawn {
        let (width, height) = self.size(text, style.size());
        let size = style.size() as f32;
        // The text is drawn on a separate pixmap and then rotated into place; the margin holds glyphs that exceed the
        // text box.
        let rim = size.ceil() as i32;
        let room = (width + 2 * rim as u32, height + 2 * rim as u32);
        let Some(mut apart) = Pixmap::new(room.0, room.1) else { return Ok(()) };
        clear(&mut apart, [255; 3]);
        let base = (rim as f32, rim as f32 + BASE * size);
        self.label.draw(&mut apart, text, base, size, [0; 3], Align::Left);
        let dx = match style.anchor().h_pos {
            HPos::Left => 0,
            HPos::Center => width as i32 / -2,
            HPos::Right => -(width as i32),
        };
        let dy = match style.anchor().v_pos {
            VPos::Top => 0,
            VPos::Center => height as i32 / -2,
            VPos::Bottom => -(height as i32),
        };
        let turn = style.transform();
        for (i, pixel) in apart.pixels().iter().enumerate().filter(|(_, pixel)| pixel.red() < 255) {
            let (x, y) = ((i as u32 % room.0) as i32 - rim, (i as u32 / room.0) as i32 - rim);
            let (x, y) = turn.transform(x + dx, y + dy);
            let covered = style.color().mix(1.0 - f64::from(pixel.red()) / 255.0);
            self.draw_pixel((at.0 + x, at.1 + y), covered)?;
        }
        Ok(())
    }

    fn estimate_text_size<S: BackendTextStyle>(
        &self,
        text: &str,
        style: &S,
    ) -> Result<(u32, u32), DrawingErrorKind<Infallible>> {
        Ok(self.size(text, style.size()))
    }
}
