//! Mounting of the pads on a parallel gripper.

use super::soft::SoftPad;

/// Pad positions and travel of a parallel gripper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mount {
    /// Largest distance between the two sensing faces, m.
    pub opening: f64,
    /// Travel of each finger, m.
    pub stroke: f64,
    /// Centre of the sensing faces along the finger width, m, hand frame.
    pub y: f64,
    /// Centre of the sensing faces along the approach, m, hand frame.
    pub z: f64,
}

/// Gripper read from a description.
#[derive(Debug, Clone, PartialEq)]
pub struct Mounted {
    /// Pad positions and travel.
    pub mount: Mount,
    /// Soft pads, left first; None if the description has none.
    pub soft: Option<[SoftPad; 2]>,
    /// Notice about accepted residuals from an exact parallel gripper: angles, positions, unequal travels.
    pub notice: Option<String>,
}
