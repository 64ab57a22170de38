//! Rigid support of the object.

use super::defaults;
use super::leaf::{Finite, NonNegative};
use super::vector::Direction;
use serde::{Deserialize, Serialize};

/// Fixed, rigid support of the object; the pads have no contact with it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Ground {
    /// Plane.
    Plane(Plane),
}

/// Half-space `normal . x <= height` in the world, which is the object frame at the start of the grasp.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Plane {
    /// Height along the normal above the origin of the world, m; None places the plane directly below the object.
    pub height: Option<Finite>,
    /// Outward normal of the ground; any nonzero length.
    pub normal: Direction,
    /// Coefficient of Coulomb friction between ground and object; zero is frictionless.
    pub friction: NonNegative,
}

impl Default for Plane {
    fn default() -> Self {
        Self { height: None, normal: defaults::GROUND_NORMAL, friction: defaults::GROUND_FRICTION }
    }
}
