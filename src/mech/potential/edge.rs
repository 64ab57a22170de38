//! State and reading of one contact edge: of a point of a pad with the object, or of a contact vertex of the object
//! with a pad.

use super::stencil::Stencil;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// One potential contact between a pad and the object; it carries force if `pressure > 0`.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct EdgeState {
    /// Gap, m; `+inf` out of reach.
    pub gap: f64,
    /// Outward normal of the object at the contact, hand frame.
    pub normal: DVec3,
    /// Pressure, Pa.
    pub pressure: f64,
    /// Normal of the friction plane, hand frame: lags like the limit.
    pub plane: DVec3,
    /// Friction limit of the current iteration, Pa: `mu pressure`, lagged while Newton's method oscillates.
    pub limit: f64,
    /// Friction traction on the pad, Pa, hand frame.
    pub traction: DVec3,
    /// Flag: the friction limit is reached.
    pub slips: bool,
    /// Sticking point: object frame for a point of the pad; for a contact vertex, its position relative to the sticking
    /// point on the pad, hand axes. For a point that makes contact within the increment, the position at the start of
    /// the increment.
    pub anchor: Option<DVec3>,
    /// Gap at the start of the increment, m, of a point that makes contact within it.
    pub initial_gap: Option<f64>,
    /// Active fraction: part of the motion since the anchor during which the point has been in contact; less than 1 if
    /// contact was made within the increment.
    pub active_fraction: f64,
    /// Stiffness factor, raised where the pressure would otherwise close the whole offset.
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
    /// Contact point on the pad.
    pub touched: Stencil,
    /// Nodes among which reports distribute the force; the weights are non-negative and sum to one.
    pub report: Stencil,
}

impl EdgeReading {
    /// Returns true if the edge carries force.
    pub fn active(&self) -> bool {
        self.force != DVec3::ZERO
    }
}
