//! Contact mechanics of pads that respond linearly: the results of geometry, friction and equilibrium alone, before any
//! network.

pub mod balance;
pub mod compliance;
pub mod compliance_cache;
pub mod deviator;
pub mod edges;
pub mod first_contact;
pub mod mortar;
pub mod pad_graph;
pub mod projected_gradient;
pub mod rigid_equilibrium;

use crate::model::Model;
use glam::DVec3;

/// Point amid the pads at zero travel, m, hand frame.
pub fn amid(model: &Model) -> DVec3 {
    model.fingers.iter().map(|f| f.placement.origin).sum::<DVec3>() / model.fingers.len() as f64
}

/// Returns the two of `rungs` (ascending) that `force` lies between, and its part of the way from the lower one to the higher;
/// None beyond.
pub fn around<T>(rungs: &[(f64, T)], force: f64) -> Option<(&T, &T, f64)> {
    let above = rungs.partition_point(|(rung, _)| *rung < force);
    let (high, after) = rungs.get(above)?;
    let (low, before) = rungs.get(above.checked_sub(1)?)?;
    Some((before, after, (force - low) / (high - low)))
}
