//! Gripper: two fingers (or one), each with a soft pad.

use super::axis::HandAxis;
use super::defaults;
use super::leaf::{Finite, Length, NonNegative};
use super::material::MaterialChoice;
use super::pad::{FilePad, Pads};
use crate::robot::Mounted;
use base::error::Error;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Gripper. Hand frame: origin at the hand base, +z is the approach, the fingers close along x, y is the finger width.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Gripper {
    /// Soft pads, the same on both fingers unless `right` is given.
    pub pads: Pads,
    /// Material of the pads.
    pub material: MaterialChoice,
    /// Distance between the two sensing faces of the open gripper, m.
    pub opening: Length,
    /// Largest travel of each finger, m. If it is less than half the opening, the pads never meet.
    pub stroke: Length,
    /// Coefficient of Coulomb friction between pad and object; zero is frictionless.
    pub friction: NonNegative,
    /// Pad, material and friction of the right finger where they differ from the above, which then apply to the left
    /// finger.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub right: Option<RightFinger>,
    /// Position of the pads in the hand frame.
    pub placement: Placement,
    /// Fingers that carry a pad and move.
    pub fingers: Fingers,
    /// Robot description (URDF or MJCF) that replaces opening, stroke and placement, and pads and material if it has
    /// soft pads; a loaded scene holds the resulting values.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robot: Option<Robot>,
    /// Notice about deviations of the robot description from a parallel gripper that were neglected.
    #[serde(skip)]
    pub notice: RobotNotice,
}

impl Default for Gripper {
    fn default() -> Self {
        Self {
            pads: Pads::default(),
            material: MaterialChoice::default(),
            opening: defaults::OPENING,
            stroke: defaults::STROKE,
            friction: defaults::FRICTION,
            right: None,
            placement: Placement::default(),
            fingers: Fingers::default(),
            robot: None,
            notice: RobotNotice::default(),
        }
    }
}

/// Description of a robot with a parallel gripper, URDF or MJCF; its links and joints are read. Grasps are poses of its
/// hand: `grasps: File(path: "...", convention: (closing: Y, approach: Z))` reads poses in the axes of a Franka hand.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Robot {
    /// Path of the description.
    pub path: PathBuf,
    /// Name of the link that is the base of the hand.
    pub hand: String,
    /// Names of the links or sites whose origins are the centres of the two sensing faces, left first; `site:NAME` and
    /// `body:NAME` distinguish a site and a body with the same name.
    pub pads: (String, String),
    /// Axis of the hand link along which the hand approaches the object.
    #[serde(default = "defaults::approach")]
    pub approach: HandAxis,
}

/// Notice about the robot description. It is not part of the scene file, so that all notices compare equal.
#[derive(Debug, Clone, Default)]
pub struct RobotNotice(pub Option<String>);

impl PartialEq for RobotNotice {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Right finger of a gripper with two different pads; omitted fields are as on the left.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RightFinger {
    /// Soft pad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pads: Option<Pads>,
    /// Material of the pad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<MaterialChoice>,
    /// Coefficient of Coulomb friction between pad and object; zero is frictionless.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<NonNegative>,
}

impl Gripper {
    /// Returns the gripper with both fingers like finger `side` of this one (0 left, 1 right).
    pub fn with_equal_fingers(&self, side: usize) -> Self {
        let mut gripper = Self { right: None, ..self.clone() };
        if let (Some(right), 1) = (&self.right, side) {
            gripper.pads = right.pads.clone().unwrap_or(gripper.pads);
            gripper.material = right.material.unwrap_or(gripper.material);
            gripper.friction = right.friction.unwrap_or(gripper.friction);
        }
        gripper
    }

    /// Returns true if both fingers have the same pad, material and friction.
    pub fn has_equal_fingers(&self) -> bool {
        self.right.is_none() || self.with_equal_fingers(0) == self.with_equal_fingers(1)
    }

    /// Refuses fingers that differ, for `what` (a noun with its article), which supports only equal fingers.
    ///
    /// # Errors
    /// Fails if they differ.
    pub fn require_equal_fingers(&self, what: &str) -> Result<(), Error> {
        let refused = || Error::Start(format!("{what} needs two identical pads; leave `right` out"));
        if self.has_equal_fingers() { Ok(()) } else { Err(refused().with_field("gripper.right")) }
    }

    /// Takes opening, stroke and placement from the robot description, and its soft pads if it has any.
    ///
    /// # Errors
    /// Fails if a number is outside the range allowed in a scene.
    pub(super) fn apply_robot(&mut self, Mounted { mount, soft, notice }: Mounted) -> Result<(), String> {
        self.notice = RobotNotice(notice);
        (self.opening, self.stroke) = (Length::new(mount.opening)?, Length::new(mount.stroke)?);
        self.placement = Placement { y: Finite::new(mount.y)?, z: Finite::new(mount.z)? };
        self.robot = None;
        let Some([left, right]) = soft else { return Ok(()) };
        (self.pads, self.material) = (Pads::File(FilePad::of_robot(&left)?), MaterialChoice::of_robot(&left)?);
        self.right = Some(RightFinger {
            pads: Some(Pads::File(FilePad::of_robot(&right)?)),
            material: Some(MaterialChoice::of_robot(&right)?),
            friction: self.right.take().and_then(|right| right.friction),
        });
        if self.has_equal_fingers() {
            self.right = None;
        }
        Ok(())
    }
}

/// Centre of the sensing faces in the hand frame (x is half the opening).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Placement {
    /// Position along the finger width, m.
    pub y: Finite,
    /// Position along the approach, m.
    pub z: Finite,
}

impl Placement {
    /// Returns the point midway between the pads, hand frame, m.
    pub fn center(&self) -> DVec3 {
        DVec3::new(0.0, self.y.get(), self.z.get())
    }
}

impl Default for Placement {
    fn default() -> Self {
        Self { y: defaults::PLACEMENT_Y, z: defaults::PLACEMENT_Z }
    }
}

/// Fingers that carry a pad and move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Fingers {
    /// Two pads, at -x and +x, that close towards each other.
    #[default]
    Both,
    /// One pad, at -x, that moves along +x: press tests on a fixed object.
    One,
    /// No pad: a dynamic scene of the object alone.
    None,
}
