//! The pooled state of one contact edge.

use glam::DVec3;

/// One potential contact between a pad and the object. The pool is fixed; `pressure > 0` says which edges carry force.
#[derive(Debug, Clone, Copy, Default)]
pub struct ContactEdge {
    /// Gap, m; `+inf` where farther than anything that matters.
    pub gap: f64,
    /// Outward normal of the object at the contact, hand frame.
    pub normal: DVec3,
    /// Pressure, Pa.
    pub pressure: f64,
    /// Friction traction on the pad, Pa, hand frame.
    pub traction: DVec3,
    /// True while the friction limit is reached.
    pub slips: bool,
    /// Normal multiplier, Pa.
    pub lambda: f64,
    /// Tangential multiplier, Pa, object frame.
    pub lambda_t: DVec3,
    /// The same in the hand frame and in the tangent plane of the last assembly, Pa.
    pub lambda_hand: DVec3,
    /// Where the point sticks to the object, object frame, m.
    pub anchor: Option<DVec3>,
    /// Query point of the last exact distance, object frame, m.
    pub query: DVec3,
    /// Lower bound of the distance at `query`, m.
    pub bound: f64,
}
