//! Text labels in the Ubuntu font embedded by `epaint_default_fonts`, rasterised by `ab_glyph`.

use super::draw::Rgb;
use ab_glyph::{Font, FontRef, PxScale, ScaleFont, point};
use base::error::{Error, Result};
use tiny_skia::{Pixmap, PremultipliedColorU8};

/// Horizontal alignment: position of the anchor point on the line of text.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Align {
    /// Start of the line.
    Left,
    /// Middle of the line.
    Center,
    /// End of the line.
    Right,
}

/// Loaded font.
pub struct Label {
    font: FontRef<'static>,
}

impl Label {
    /// Loads the embedded font.
    ///
    /// # Errors
    /// Fails if the font cannot be parsed.
    pub fn new() -> Result<Self> {
        let font = FontRef::try_from_slice(epaint_default_fonts::UBUNTU_LIGHT)
            .map_err(|e| Error::file("embedded font Ubuntu-Light", e.to_string()))?;
        Ok(Label { font })
    }

    /// Returns the width of `text` at `size`, pixels.
    pub fn width(&self, text: &str, size: f32) -> f32 {
        let font = self.font.as_scaled(PxScale::from(size));
        text.chars().map(|c| font.h_advance(font.glyph_id(c))).sum()
    }

    /// Returns `text`, truncated with an ellipsis if it is wider than `padded_bounds` pixels.
    pub fn fit(&self, text: &str, size: f32, room: f32) -> String {
        if self.width(text, size) <= room {
            return text.to_string();
        }
        let mut kept = text.to_string();
        while kept.pop().is_some() {
            let candidate = format!("{}…", kept.trim_end());
            if self.width(&candidate, size) <= room {
                return candidate;
            }
        }
        String::new()
    }

    /// Draws a line of text with its baseline at `y`.
    pub fn draw(&self, pixmap: &mut Pixmap, text: &str, at: (f32, f32), size: f32, rgb: Rgb, align: Align) {
        let width = self.width(text, size);
        let start = match align {
            Align::Left => at.0,
            Align::Center => at.0 - 0.5 * width,
            Align::Right => at.0 - width,
        };
        let scale = PxScale::from(size);
        let font = self.font.as_scaled(scale);
        let mut pen = start;
        for character in text.chars() {
            let id = font.glyph_id(character);
            if let Some(outline) = self.font.outline_glyph(id.with_scale_and_position(scale, point(pen, at.1))) {
                let (left, top) = (outline.px_bounds().min.x as i32, outline.px_bounds().min.y as i32);
                // The light font needs higher coverage to be readable at small sizes.
                outline
                    .draw(|x, y, c| blend(pixmap, left + x as i32, top + y as i32, rgb, c.clamp(0.0, 1.0).powf(0.65)));
            }
            pen += font.h_advance(id);
        }
    }
}

/// Blends `rgb` into an opaque pixel; does nothing outside the picture.
pub fn blend(pixmap: &mut Pixmap, x: i32, y: i32, rgb: Rgb, coverage: f32) {
    let (width, height) = (pixmap.width() as i32, pixmap.height() as i32);
    if x < 0 || y < 0 || x >= width || y >= height {
        return;
    }
    let pixel = &mut pixmap.pixels_mut()[(y * width + x) as usize];
    let mix = |old: u8, new: u8| (f32::from(old) + (f32::from(new) - f32::from(old)) * coverage).round() as u8;
    let mixed = [mix(pixel.red(), rgb[0]), mix(pixel.green(), rgb[1]), mix(pixel.blue(), rgb[2])];
    if let Some(color) = PremultipliedColorU8::from_rgba(mixed[0], mixed[1], mixed[2], 255) {
        *pixel = color;
    }
}
