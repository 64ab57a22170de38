//! Readings of a converged contact. Only this module knows how the solver stores it.

use crate::mech::contact::{FeatureContact, PointContact};
use crate::mech::newton::Newton;
use crate::mech::potential::state::State;
use crate::mech::potential::term::Stencil;
use glam::DVec3;

/// Reading of one contact edge at the converged state.
#[derive(Debug, Clone, Copy)]
pub struct EdgeReading {
    /// Point at which the force acts, m, hand frame.
    pub point: DVec3,
    /// Gap, m; `+inf` if the edge is too far to matter.
    pub gap: f64,
    /// Outward normal of the object, hand frame.
    pub normal: DVec3,
    /// Force on the pad, friction included, N.
    pub force: DVec3,
    /// Tangential part of the force, N.
    pub friction: DVec3,
    /// True if Coulomb's limit is reached.
    pub slips: bool,
    /// Nodes that share the force in reports; the weights are non-negative and sum to one.
    pub report: Stencil,
}

impl EdgeReading {
    /// Returns true while the edge carries force.
    pub fn active(&self) -> bool {
        self.force != DVec3::ZERO
    }
}

/// Returns the contact term of body `i`.
pub fn contact(newton: &Newton, i: usize) -> Option<&PointContact> {
    newton.terms[i].iter().find_map(|t| t.as_any().downcast_ref::<PointContact>())
}

/// Returns the feature contact term of body `i`, if the object has features.
pub fn features(newton: &Newton, i: usize) -> Option<&FeatureContact> {
    newton.terms[i].iter().find_map(|t| t.as_any().downcast_ref::<FeatureContact>())
}

/// Returns the edges of body `i` that are not open, with their numbers: those of the pad's points, then those of the object's
/// features.
pub fn edges<'a>(newton: &'a Newton, state: &'a State, i: usize) -> impl Iterator<Item = (usize, EdgeReading)> + 'a {
    let carried = newton.rigid.closing[i] * state.travel[i];
    let points = contact(newton, i).into_iter().flat_map(move |c| {
        let surface = c.surface();
        c.edges().map(move |(k, e)| {
            let edge = EdgeReading {
                point: surface.points[k].position(&state.x[i]) + carried,
                gap: e.gap,
                normal: e.normal,
                force: c.force(k),
                friction: e.traction * surface.area[k],
                slips: e.slips,
                report: surface.report[k],
            };
            (k, edge)
        })
    });
    let first = contact(newton, i).map_or(0, |c| c.surface().points.len());
    let features = features(newton, i).into_iter().flat_map(move |c| {
        c.edges().map(move |(k, e)| {
            let f = c.readout(k);
            let edge = EdgeReading {
                point: f.now.position(&state.x[i]) + carried,
                gap: e.gap,
                normal: e.normal,
                force: f.normal + f.friction,
                friction: f.friction,
                slips: e.slips,
                report: f.report,
            };
            (first + k, edge)
        })
    });
    points.chain(features)
}

/// Returns the smallest gap over all bodies, m.
pub fn min_gap(newton: &Newton) -> f64 {
    let points = (0..newton.bodies()).filter_map(|i| contact(newton, i)).map(PointContact::min_gap);
    let features = (0..newton.bodies()).filter_map(|i| features(newton, i)).map(FeatureContact::min_gap);
    points.chain(features).fold(f64::INFINITY, f64::min)
}
