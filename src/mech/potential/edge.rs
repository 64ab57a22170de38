//! State and reading of one contact edge: of a point of a pad with the object, or of a feature of the object with a pad.

use super::term::Stencil;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// One potential contact between a pad and the object; `pressure > 0` tells whether it carries force.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct EdgeState {
    /// Gap, m; `+inf` where farther than anything that matters.
    pub gap: f64,
    /// Outward normal of the object at the contact, hand frame.
    pub normal: DVec3,
    /// Pressure, Pa.
    pub pressure: f64,
    /// Normal of the plane that friction acts in, hand frame: lags like the limit.
    pub plane: DVec3,
    /// Friction limit of the current iteration, Pa: `mu pressure`, lagged while Newton swings.
    pub limit: f64,
    /// Friction traction on the pad, Pa, hand frame.
    pub traction: DVec3,
    /// Flag: the friction limit is reached.
    pub slips: bool,
    /// Sticking point: object frame for a point of the pad, hand axes relative to the finger for a feature. For a point that
    /// touches within the increment it is the position at the start of the increment.
    pub anchor: Option<DVec3>,
    /// Gap when the increment began, m, of a point that touches within it.
    pub clear: Option<f64>,
    /// Part of the motion since the anchor in which the point has been in contact: less than 1 if it touched within the
    /// increment.
    pub share: f64,
    /// Stiffness factor, raised where a pressure would otherwise use up the whole offset.
    pub scale: f64,
}

/// Reading of a contact edge at a state.
#[derive(Debug, Clone, Copy)]
pub struct EdgeReading {
    /// Number of the edge within its term, or within its body.
    pub number: usize,
    /// State of the edge.
    pub state: EdgeState,
    /// Point at which the force acts, m, hand frame.
    pub point: DVec3,
    /// Force on the pad, friction included, N.
    pub force: DVec3,
    /// Point of the pad that is touched.
    pub touched: Stencil,
    /// Nodes that share the force in reports; the weights are non-negative and sum to one.
    pub report: Stencil,
}

impl EdgeReading {
    /// Returns true while the edge carries force.
    pub fn active(&self) -> bool {
        self.force != DVec3::ZERO
    }
}
