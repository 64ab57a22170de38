//! Contact vertex of an object.

use glam::DVec3;

/// Contact vertex of the object: a surface point that is tested against the faces of a pad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeaturePoint {
    /// Position, m.
    pub position: DVec3,
    /// Unit outward pseudo-normal.
    pub normal: DVec3,
    /// True if a sharp convex edge or tip passes through the point.
    pub sharp: bool,
}
