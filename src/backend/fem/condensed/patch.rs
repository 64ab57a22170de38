//! Choice of the nodes of a pad that may carry contact.

use base::scales::{PATCH_MARGIN, SMALL_PATCH_MARGIN};
use geometry::shape::Shape;
use mech::potential::state::BodyView;
use mech::potential::stencil::Stencil;
use model::part::FingerModel;
use std::collections::BTreeSet;

/// Number of nodes up to which a patch has the margin `SMALL_PATCH_MARGIN`.
const SMALL_PATCH_NODES: usize = 64;

/// Returns the free nodes of the patch, ascending: those of the `touched` stencils, and those of the pad's vertices
/// that are within the contact `offset` (m) of the object, or would be if it came `nearer` (m), with a margin.
pub fn patch_nodes(
    finger: &FingerModel,
    view: &BodyView,
    object: &Shape,
    offset: f64,
    nearer: f64,
    touched: impl Iterator<Item = Stencil>,
) -> Vec<u32> {
    let (turn, reach) = (view.object.rotation.transpose(), nearer + offset);
    let mut near: Vec<(f64, Stencil)> = touched.map(|stencil| (f64::NEG_INFINITY, stencil)).collect();
    for stencil in &finger.surface.points[..finger.surface.vertices] {
        let q = turn * (stencil.position(view.x) + view.offset - view.object.position);
        near.extend(object.distance.closest(q, reach + SMALL_PATCH_MARGIN * offset).map(|c| (c.distance, *stencil)));
    }
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut patch = BTreeSet::new();
    for (distance, stencil) in near {
        if distance > reach + PATCH_MARGIN * offset && patch.len() >= SMALL_PATCH_NODES {
            break;
        }
        patch.extend(stencil.slices().0.iter().filter(|n| !finger.body.fixed[**n as usize]));
    }
    patch.into_iter().collect()
}
