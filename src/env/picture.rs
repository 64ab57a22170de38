//! Pictures of an environment, as `tactus run` draws a frame.

use crate::error::Result;
use crate::model::Model;
use crate::record::{Frame, PadTopology};
use crate::render::{Pixmap, Scalar, Style, render_pads};

/// Draws the pads of `frame`, coloured by stress where the task asks for it, by displacement elsewhere.
pub(crate) fn picture(model: &Model, frame: &Frame, title: String) -> Result<Pixmap> {
    let topologies: Vec<PadTopology> = model.fingers.iter().map(|f| PadTopology::clone(&f.topology)).collect();
    let scalar = if model.needs.stress { Scalar::Stress } else { Scalar::Displacement };
    render_pads(&topologies, frame, Some(&model.object.surface), &Style { scalar, title, ..Style::default() })
}
