//! Error message for an inverted element.

use glam::DVec3;
use model::Model;
use record::pad_name;

/// Describes the most inverted element of the pads and its reference position; `x`: node positions of each pad, m.
pub fn inversion_message(model: &Model, x: &[&[DVec3]]) -> String {
    let pads = model.fingers.iter().zip(x).enumerate();
    let smallest = pads.map(|(i, (f, x))| (i, f.body.min_det_f(x))).min_by(|a, b| a.1.total_cmp(&b.1));
    let found = smallest.and_then(|(i, det)| Some((i, det, model.fingers[i].body.most_inverted(x[i])?)));
    let Some((i, det, e)) = found else { return "an element is inverted".into() };
    let pad = &model.fingers[i].topology;
    let corners = &pad.elements.nodes()[e * pad.elements.width()..][..4];
    let at = corners.iter().map(|n| pad.rest[*n as usize]).sum::<DVec3>() * (1e3 / 4.0);
    format!(
        "element {e} of the {} pad is inverted (det F {det:.3}); its undeformed position in the pad frame is ({:.2}, \
         {:.2}, {:.2}) mm; the deformation is too large for this mesh: use a smaller load, a stiffer gel or a finer \
         pad",
        pad_name(i),
        at.x,
        at.y,
        at.z
    )
}
