//! What the object may rest on.

use super::defaults;
use super::leaf::{Finite, NonNegative};
use super::vector::Direction;
use serde::{Deserialize, Serialize};

/// A fixed, rigid support of the object; the pads do not feel it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Ground {
    /// A plane.
    Plane(Plane),
}

/// The half-space `normal . x <= height` in the world, which is the object frame at the start of the grasp.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Plane {
    /// Along the normal from the world's origin, m; None is right below the object.
    pub height: Option<Finite>,
    /// Out of the ground, any length.
    pub normal: Direction,
    /// Coulomb friction between ground and object; zero is frictionless.
    pub friction: NonNegative,
}

impl Default for Plane {
    fn default() -> Self {
        Self { height: None, normal: defaults::GROUND_NORMAL, friction: defaults::GROUND_FRICTION }
    }
}
