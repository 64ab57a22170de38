//! Pictures of an environment, like those of `tactus run`.

use base::error::Result;
use model::Model;
use record::render::{Pixmap, Scalar, Style, render_pads};
use record::{Frame, PadTopology};

/// Renders the pads of `frame`, coloured by stress if the task computes it, otherwise by displacement.
pub(crate) fn picture(model: &Model, frame: &Frame, title: String) -> Result<Pixmap> {
    let topologies: Vec<PadTopology> = model.fingers.iter().map(|f| PadTopology::clone(&f.topology)).collect();
    let scalar = if model.needs.stress { Scalar::Stress } else { Scalar::Displacement };
    render_pads(&topologies, frame, Some(&model.object.surface), &Style { scalar, title, ..Style::default() })
}
