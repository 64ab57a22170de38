//! Which nodes of a pad may carry contact.

use crate::fem::state::View;
use crate::fem::term::Stencil;
use crate::model::FingerModel;
use crate::shape::Shape;
use std::collections::BTreeSet;

/// How far beyond the contact's own reach a point of the pad may be from the object and still be in the patch, m: more than the
/// fingers travel between two frames, less than would make the patch large.
const MARGIN: f64 = 1.5e-4;
/// The same for a patch that is small: few nodes cost nothing, and a tip that sinks in soon needs more.
const WIDE: f64 = 2e-3;
/// Nodes of a small patch.
const SMALL: usize = 64;

/// The free nodes that the points of the pad near the object hang on, whose contact is felt from `reach` (m), and those that
/// are `touched`; ascending.
pub fn choose(
    finger: &FingerModel,
    view: &View,
    object: &Shape,
    reach: f64,
    touched: impl Iterator<Item = Stencil>,
) -> Vec<u32> {
    let turn = view.rotation.transpose();
    let mut near: Vec<(f64, Stencil)> = touched.map(|stencil| (f64::NEG_INFINITY, stencil)).collect();
    for stencil in &finger.surface.points[..finger.surface.vertices] {
        let q = turn * (stencil.position(view.x) + view.offset - view.position);
        near.extend(object.distance.closest(q, reach + WIDE).map(|c| (c.distance, *stencil)));
    }
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut patch = BTreeSet::new();
    for (distance, stencil) in near {
        if distance > reach + MARGIN && patch.len() >= SMALL {
            break;
        }
        patch.extend(stencil.slices().0.iter().filter(|n| !finger.body.fixed[**n as usize]));
    }
    patch.into_iter().collect()
}
