//! The pooled state of one contact edge.

use glam::DVec3;

/// One potential contact between a pad and the object. The pool is fixed; `pressure > 0` says which edges carry force.
#[derive(Debug, Clone, Copy)]
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
    /// Where the point sticks: object frame for a point of the pad, hand axes relative to the finger for a feature.
    pub anchor: Option<DVec3>,
    /// Stiffness factor, raised where a pressure would otherwise use up the whole offset.
    pub scale: f64,
    /// Query point of the last exact distance, object frame, m.
    pub query: DVec3,
    /// Lower bound of the distance at `query`, m.
    pub bound: f64,
}

impl Default for ContactEdge {
    fn default() -> Self {
        Self {
            gap: f64::INFINITY,
            normal: DVec3::ZERO,
            pressure: 0.0,
            traction: DVec3::ZERO,
            slips: false,
            anchor: None,
            scale: 1.0,
            query: DVec3::ZERO,
            bound: f64::NEG_INFINITY,
        }
    }
}
