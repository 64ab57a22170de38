//! Pads drawn at random.

use super::draws::{Draws, round_for_text};
use crate::defaults;
use crate::leaf::{Length, NonNegative};
use crate::pad::{BoxPad, DiscPad, GelShape, GelSightMini, Pads};
use crate::span::Span;
use crate::vector::Tuple;
use serde::{Deserialize, Serialize};

/// Ranges of pads. Pads that are neither round nor domed are boxes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PadSpans {
    /// Range of the length along the approach, m, uniform; limited to nine thicknesses. The diameter of a round pad is
    /// the geometric mean of length and width.
    pub length: Span,
    /// Range of the width, m, uniform; limited to nine thicknesses.
    pub width: Span,
    /// Range of the thickness, m, log-uniform.
    pub thickness: Span,
    /// Range of the number of cells of the sensing face, log-uniform; the cell width is limited to between 1/3 and 0.7
    /// of the pad thickness.
    pub cells: Span,
    /// Fraction of the objects with round pads.
    pub round: NonNegative,
    /// Fraction of the objects with the domed gel of a GelSight Mini.
    pub domed: NonNegative,
}

impl Default for PadSpans {
    fn default() -> Self {
        Self {
            length: defaults::UNIVERSE_PAD_LENGTH,
            width: defaults::UNIVERSE_PAD_WIDTH,
            thickness: defaults::UNIVERSE_PAD_THICKNESS,
            cells: defaults::UNIVERSE_PAD_CELLS,
            round: defaults::UNIVERSE_PAD_ROUND,
            domed: defaults::UNIVERSE_PAD_DOMED,
        }
    }
}

/// Largest number of layers of cells from the sensing face to the finger.
const LAYERS: f64 = 3.0;
/// Largest width of a cell over the thickness: a coarser mesh does not resolve the contact.
const MAX_CELL: f64 = 0.7;
/// Largest length and width of a pad over its thickness.
const MAX_ASPECT: f64 = 9.0;
/// Node spacing of a round pad over the cell width of a box: a disc is meshed with triangles.
const ROUND: f64 = 1.4;
/// Length, width and thickness of the gel of a GelSight Mini, m.
const GELSIGHT_MINI: [f64; 3] = [25.25e-3, 20.75e-3, 4e-3];

impl PadSpans {
    /// Draws a pad; returns it with its thickness, m.
    pub(super) fn draw(&self, draws: &mut Draws) -> (Pads, f64) {
        let (length, width) = (draws.within(&self.length), draws.within(&self.width));
        let thickness = round_for_text(draws.factor(&self.thickness));
        let [length, width] = [length, width].map(|size| round_for_text(size.min(MAX_ASPECT * thickness)));
        let cells = draws.factor(&self.cells);
        let kind = draws.between(0.0, 1.0);
        let spacing = |area: f64, thickness: f64| {
            let cell = (area / cells).sqrt().clamp(thickness / LAYERS, MAX_CELL * thickness);
            Some(Length::new_unchecked(round_for_text(cell)))
        };
        if kind < self.round.get() {
            let radius = round_for_text(0.5 * (length * width).sqrt());
            let disc = DiscPad {
                radius: Length::new_unchecked(radius),
                thickness: Length::new_unchecked(thickness),
                spacing: spacing(ROUND * ROUND * std::f64::consts::PI * radius * radius, thickness),
                accuracy: None,
                grading: defaults::PAD_GRADING,
                focus: defaults::PAD_FOCUS,
            };
            (Pads::Disc(disc), thickness)
        } else if kind < self.round.get() + self.domed.get() {
            let [length, width, thickness] = GELSIGHT_MINI;
            let shape = GelShape::Domed;
            let spacing = spacing(length * width, thickness);
            (Pads::GelSightMini(GelSightMini { shape, spacing, ..GelSightMini::default() }), thickness)
        } else {
            let size = Tuple([length, width, thickness].map(Length::new_unchecked));
            let spacing = spacing(length * width, thickness);
            let (grading, focus) = (defaults::PAD_GRADING, defaults::PAD_FOCUS);
            (Pads::Box(BoxPad { size, cells: None, spacing, accuracy: None, grading, focus }), thickness)
        }
    }
}
