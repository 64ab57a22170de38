//! The gripper: two fingers (or one), each with a soft pad.

use super::defaults;
use super::leaf::{Finite, Length, NonNegative};
use super::material::MaterialChoice;
use super::pad::Pads;
use serde::{Deserialize, Serialize};

/// The gripper. Hand frame: origin at the hand base, +z the approach, fingers close along x, y the finger width.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Gripper {
    /// The soft pads: the same on both fingers.
    pub pads: Pads,
    /// What the pads are made of.
    pub material: MaterialChoice,
    /// Distance of the two sensing faces when open, m.
    pub opening: Length,
    /// Largest travel of each finger, m. May be less than half the opening: then the pads never meet.
    pub stroke: Length,
    /// Coulomb friction between pad and object; zero is frictionless.
    pub friction: NonNegative,
    /// Where the pads sit in the hand frame.
    pub placement: Placement,
    /// Which fingers carry a pad and move.
    pub fingers: Fingers,
}

impl Default for Gripper {
    fn default() -> Self {
        Self {
            pads: Pads::default(),
            material: MaterialChoice::default(),
            opening: defaults::OPENING,
            stroke: defaults::STROKE,
            friction: defaults::FRICTION,
            placement: Placement::default(),
            fingers: Fingers::default(),
        }
    }
}

/// Centre of the pads' sensing faces in the hand frame (x follows from the opening).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Placement {
    /// Along the finger width, m.
    pub y: Finite,
    /// Along the approach, m.
    pub z: Finite,
}

impl Default for Placement {
    fn default() -> Self {
        Self { y: defaults::PLACEMENT_Y, z: defaults::PLACEMENT_Z }
    }
}

/// Which fingers carry a pad and move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Fingers {
    /// Two pads, at -x and +x, closing on each other.
    #[default]
    Both,
    /// One pad only, at -x and moving along +x: press tests on a fixed object.
    One,
    /// No pad at all: a dynamic scene of the object alone.
    None,
}
