//! Contact mechanics of pads with a linear response: what geometry, friction and equilibrium alone determine, before
//! any network.

pub mod balance;
pub mod canonical_pads;
pub mod compliance;
pub mod compliance_cache;
pub mod contact_point;
pub mod deviator;
pub mod edges;
pub mod first_contact;
pub mod limit_surface;
mod many_loads;
pub mod mortar;
pub mod object_motion;
pub mod pad_graph;
pub mod pad_graphs;
pub mod projected_gradient;
mod refined_pad;
pub mod rigid_equilibrium;

use geometry::Wrench;
use model::Model;

/// Load on a grasp.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GraspLoad {
    /// Force per finger, N.
    pub force: f64,
    /// Push on the object in addition to its weight, about its centre of mass, hand frame.
    pub push: Wrench,
}

impl From<f64> for GraspLoad {
    fn from(force: f64) -> Self {
        Self { force, ..Self::default() }
    }
}

impl GraspLoad {
    /// Returns the load in units of a force `unit` (N) and a length `thickness` (m).
    pub fn dimensionless(self, unit: f64, thickness: f64) -> Self {
        let Wrench { force, torque } = self.push;
        Self { force: self.force / unit, push: Wrench { force: force / unit, torque: torque / (unit * thickness) } }
    }
}

/// Returns the loads of a model's frames.
pub fn frame_loads(model: &Model) -> Vec<GraspLoad> {
    let push =
        |frame: usize| model.push.as_ref().map(|push| push.fraction_of(model.push_fraction(frame))).unwrap_or_default();
    model.levels.iter().enumerate().map(|(frame, force)| GraspLoad { force: *force, push: push(frame) }).collect()
}

/// Returns the two of `rungs` (ascending) that enclose `force`, and its relative position between the lower and the
/// higher one; None outside.
pub fn enclosing_pair<T>(rungs: &[(f64, T)], force: f64) -> Option<(&T, &T, f64)> {
    let above = rungs.partition_point(|(rung, _)| *rung < force);
    let (high, after) = rungs.get(above)?;
    let (low, before) = rungs.get(above.checked_sub(1)?)?;
    Some((before, after, (force - low) / (high - low)))
}
