//! Gripper: two fingers (or one), each with a soft pad.

use super::convention::HandAxis;
use super::defaults;
use super::leaf::{Finite, Length, NonNegative};
use super::material::MaterialChoice;
use super::pad::Pads;
use crate::robot::Mount;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Gripper. Hand frame: origin at the hand base, +z is the approach, the fingers close along x, y is the finger width.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Gripper {
    /// Soft pads, the same on both fingers.
    pub pads: Pads,
    /// Material of the pads.
    pub material: MaterialChoice,
    /// Distance between the two sensing faces when open, m.
    pub opening: Length,
    /// Largest travel of each finger, m. It may be less than half the opening; the pads then never meet.
    pub stroke: Length,
    /// Coefficient of Coulomb friction between pad and object; zero is frictionless.
    pub friction: NonNegative,
    /// Position of the pads in the hand frame.
    pub placement: Placement,
    /// Choice of the fingers that carry a pad and move.
    pub fingers: Fingers,
    /// Description of the robot that the pads are mounted on, in place of opening, stroke and placement; a scene that is loaded has its numbers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robot: Option<Robot>,
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
            robot: None,
        }
    }
}

/// Description of a robot with a parallel gripper: URDF (`.urdf`) or MJCF (`.xml`), of which links and their joints are read. Grasps are those of its
/// hand: `grasps: File(path: "...", convention: (closing: Y, approach: Z))` reads poses in the axes of a Franka hand.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Robot {
    /// Path of the description.
    pub path: PathBuf,
    /// Name of the link that is the base of the hand.
    pub hand: String,
    /// Names of the links, or of the sites, whose origins are the centres of the two sensing faces, left first.
    pub pads: (String, String),
    /// Axis of the hand's link along which the hand approaches the object.
    #[serde(default = "defaults::approach")]
    pub approach: HandAxis,
}

impl Gripper {
    /// Takes opening, stroke and placement of the pads from the description of its robot.
    ///
    /// # Errors
    /// Fails if a number is none that the scene could give.
    pub(super) fn take_over(&mut self, mount: &Mount) -> Result<(), String> {
        (self.opening, self.stroke) = (Length::new(mount.opening)?, Length::new(mount.stroke)?);
        self.placement = Placement { y: Finite::new(mount.y)?, z: Finite::new(mount.z)? };
        self.robot = None;
        Ok(())
    }
}

/// Centre of the pads' sensing faces in the hand frame (x follows from the opening).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Placement {
    /// Position along the finger width, m.
    pub y: Finite,
    /// Position along the approach, m.
    pub z: Finite,
}

impl Default for Placement {
    fn default() -> Self {
        Self { y: defaults::PLACEMENT_Y, z: defaults::PLACEMENT_Z }
    }
}

/// Choice of the fingers that carry a pad and move.
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
