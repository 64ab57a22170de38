//! Which nodes of a pad may carry contact.

use crate::fem::state::View;
use crate::model::FingerModel;
use crate::shape::Shape;

/// How far beyond the contact's own reach a point of the pad may be from the object and still be in the patch, m: more than the
/// fingers travel between two looks, less than would make the patch large.
pub const MARGIN: f64 = 4e-4;

/// The free nodes that the points of the pad within `reach` (m) of the object hang on, ascending.
pub fn choose(finger: &FingerModel, view: &View, object: &Shape, reach: f64) -> Vec<u32> {
    let (turn, fixed) = (view.rotation.transpose(), &finger.body.fixed);
    let mut near = vec![false; fixed.len()];
    for stencil in &finger.surface.points {
        let q = turn * (stencil.position(view.x) + view.offset - view.position);
        if object.distance.closest(q, reach).is_some() {
            stencil.slices().0.iter().for_each(|&n| near[n as usize] = !fixed[n as usize]);
        }
    }
    (0..near.len() as u32).filter(|&n| near[n as usize]).collect()
}
