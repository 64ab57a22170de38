//! The scene: everything a scene file can say.

use super::expect::Expectation;
use super::grasps::Grasps;
use super::gripper::Gripper;
use super::ground::Ground;
use super::loading::Loading;
use super::object::Object;
use super::output::Record;
use super::stepper::Stepper;
use super::vector::Vec3;
use serde::{Deserialize, Serialize};

/// A complete scene: includes merged, defaults filled in, paths resolved.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scene {
    /// What the scene shows, for humans.
    pub about: String,
    /// The rigid object.
    pub object: Object,
    /// The gripper and its pads.
    pub gripper: Gripper,
    /// Where the hand is.
    pub grasps: Grasps,
    /// How the grasp is loaded.
    pub loading: Loading,
    /// What advances the scene.
    pub stepper: Stepper,
    /// Gravity in the world, which is the object frame at the start of each grasp, m/s2; None is none.
    pub gravity: Option<Vec3>,
    /// What the object may rest on in a dynamic scene; None is nothing.
    pub ground: Option<Ground>,
    /// What a run writes.
    pub record: Record,
    /// What the scene promises about its own outcome.
    pub expect: Vec<Expectation>,
}

/// Declares [`Part`] and all that is done field by field, so that a new field is added in one place.
macro_rules! part {
    ($($field:ident: $type:ty,)*) => {
        /// One scene file as written: any field may be missing, an include or the default gives it.
        #[derive(Debug, Clone, Default, Deserialize)]
        #[serde(rename = "Scene", default, deny_unknown_fields)]
        pub(super) struct Part {
            pub include: Vec<String>,
            $(pub $field: Option<$type>,)*
        }

        impl Part {
            /// Takes over every field that `other` gives.
            pub fn take_over(&mut self, other: Part) {
                $(if other.$field.is_some() {
                    self.$field = other.$field;
                })*
            }

            /// Names of the fields that this file gives.
            pub fn given(&self) -> Vec<&'static str> {
                let mut names = Vec::new();
                $(if self.$field.is_some() {
                    names.push(stringify!($field));
                })*
                names
            }
        }
    };
}

part! {
    about: String,
    object: Object,
    gripper: Gripper,
    grasps: Grasps,
    loading: Loading,
    stepper: Stepper,
    gravity: Vec3,
    ground: Ground,
    record: Record,
    expect: Vec<Expectation>,
}

impl Part {
    /// The complete scene, or the name of the field that is missing.
    pub fn complete(self) -> Result<Scene, &'static str> {
        Ok(Scene {
            about: self.about.unwrap_or_default(),
            object: self.object.ok_or("object")?,
            gripper: self.gripper.unwrap_or_default(),
            grasps: self.grasps.unwrap_or_default(),
            loading: self.loading.ok_or("loading")?,
            stepper: self.stepper.unwrap_or_default(),
            gravity: self.gravity,
            ground: self.ground,
            record: self.record.unwrap_or_default(),
            expect: self.expect.unwrap_or_default(),
        })
    }
}
