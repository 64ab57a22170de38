//! The scene: everything a scene file can say.

use super::expect::Expectation;
use super::grasps::Grasps;
use super::gripper::Gripper;
use super::ground::Ground;
use super::loading::Loading;
use super::object::Object;
use super::objects::{Entry, Name, NamedScene, Split};
use super::output::Record;
use super::stepper::StepperChoice;
use super::task::Task;
use super::vector::Vec3;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

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
    pub stepper: StepperChoice,
    /// Gravity in the world, which is the object frame at the start of each grasp, m/s2; None is none.
    pub gravity: Option<Vec3>,
    /// What the object may rest on in a dynamic scene; None is nothing.
    pub ground: Option<Ground>,
    /// What a run writes.
    pub record: Record,
    /// What the scene promises about its own outcome.
    pub expect: Vec<Expectation>,
    /// What it promises where a network advances it; None is what of `expect` a network keeps by its making, see
    /// [`Expectation::by_network`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expect_network: Option<Vec<Expectation>>,
    /// What an agent does in it, see [`crate::env`]; a run takes no notice.
    pub task: Option<Task>,
}

impl Scene {
    /// The promises that a run is held to: those of its backend.
    pub fn promises(&self) -> Cow<'_, [Expectation]> {
        match (&self.stepper, &self.expect_network) {
            (StepperChoice::Fem(_), _) => Cow::Borrowed(&self.expect),
            (StepperChoice::Gnn(_), Some(own)) => Cow::Borrowed(own),
            (StepperChoice::Gnn(_), None) => self.expect.iter().filter(|e| e.by_network()).cloned().collect(),
        }
    }

    /// The field that [`Scene::promises`] are from, in words.
    pub fn promised_in(&self) -> &'static str {
        match (&self.stepper, &self.expect_network) {
            (StepperChoice::Fem(_), _) => "expect",
            (StepperChoice::Gnn(_), Some(_)) => "expect_network",
            (StepperChoice::Gnn(_), None) => "expect, what a network keeps by its making",
        }
    }

    /// Both lists with the names of their fields.
    pub(super) fn promise_lists(&self) -> [(&'static str, &[Expectation]); 2] {
        [("expect", &self.expect), ("expect_network", self.expect_network.as_deref().unwrap_or_default())]
    }

    /// Takes all promises away.
    pub fn promise_nothing(&mut self) {
        self.expect.clear();
        self.expect_network = None;
    }
}

/// Declares [`ScenePart`] and all that is done field by field, so that a new field is added in one place.
macro_rules! part {
    ($($field:ident: $type:ty,)*) => {
        /// One scene file as written: any field may be missing, an include or the default gives it.
        #[derive(Debug, Clone, Default, Deserialize)]
        #[serde(rename = "Scene", default, deny_unknown_fields)]
        pub(super) struct ScenePart {
            pub include: Vec<String>,
            $(pub $field: Option<$type>,)*
        }

        impl ScenePart {
            /// Takes over every field that `other` gives.
            pub fn take_over(&mut self, other: ScenePart) {
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
    objects: Vec<Entry>,
    split: Split,
    gripper: Gripper,
    grasps: Grasps,
    loading: Loading,
    stepper: StepperChoice,
    gravity: Vec3,
    ground: Ground,
    record: Record,
    expect: Vec<Expectation>,
    expect_network: Vec<Expectation>,
    task: Task,
}

impl ScenePart {
    /// One complete scene per object, or the name of the field that is missing. An object without a name gets `name`.
    pub fn complete(self, name: &Name) -> Result<Vec<NamedScene>, &'static str> {
        let entries = match (self.object, self.objects) {
            (Some(object), _) => vec![Entry { name: name.clone(), object, grasps: None }],
            (None, Some(objects)) => objects,
            (None, None) => return Err("object"),
        };
        let loading = self.loading.ok_or("loading")?;
        let scene = |entry: &Entry| Scene {
            about: self.about.clone().unwrap_or_default(),
            object: entry.object.clone(),
            gripper: self.gripper.clone().unwrap_or_default(),
            grasps: entry.grasps.clone().or_else(|| self.grasps.clone()).unwrap_or_default(),
            loading: loading.clone(),
            stepper: self.stepper.clone().unwrap_or_default(),
            gravity: self.gravity,
            ground: self.ground,
            record: self.record.clone().unwrap_or_default(),
            expect: self.expect.clone().unwrap_or_default(),
            expect_network: self.expect_network.clone(),
            task: self.task.clone(),
        };
        Ok(entries.iter().map(|e| NamedScene { name: e.name.clone(), scene: scene(e) }).collect())
    }
}
