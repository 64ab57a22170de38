//! Schema of a scene: all fields of a scene file.

use super::expect::Expectation;
use super::grasps::Grasps;
use super::gripper::Gripper;
use super::ground::Ground;
use super::loading::Loading;
use super::object::Object;
use super::objects::{Entry, Name, Split};
use super::output::Record;
use super::stepper::{FinerMesh, StepperChoice};
use super::task::Task;
use super::universe::Universe;
use super::vector::Vec3;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Complete scene: includes merged, defaults filled in, paths resolved.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scene {
    /// Description of the scene, free text.
    pub about: String,
    /// Rigid object.
    pub object: Object,
    /// Gripper and its pads.
    pub gripper: Gripper,
    /// Grasps: poses of the hand.
    pub grasps: Grasps,
    /// Loading of the grasp.
    pub loading: Loading,
    /// Backend that computes the grasps.
    pub stepper: StepperChoice,
    /// Gravity in the world frame (the object frame at the start of each grasp), m/s2; None is no gravity.
    pub gravity: Option<Vec3>,
    /// Rigid ground under the object in a dynamic scene; None is no ground.
    pub ground: Option<Ground>,
    /// Recorded output of a run.
    pub record: Record,
    /// Expected results, checked after each grasp.
    pub expect: Vec<Expectation>,
    /// Expected results if a network computes the grasps; None takes those entries of `expect` that a network meets by
    /// construction, see [`Expectation::holds_by_construction`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expect_network: Option<Vec<Expectation>>,
    /// Reinforcement learning task in the scene, see [`env`]; a run ignores it.
    pub task: Option<Task>,
}

impl Scene {
    /// Returns the expected results against which a run with the scene's backend is checked.
    pub fn expectations(&self) -> Cow<'_, [Expectation]> {
        match (&self.stepper, &self.expect_network) {
            (StepperChoice::Fem(_), _) => Cow::Borrowed(&self.expect),
            (StepperChoice::Gnn(_), Some(own)) => Cow::Borrowed(own),
            (StepperChoice::Gnn(_), None) => {
                self.expect.iter().filter(|e| e.holds_by_construction()).cloned().collect()
            }
        }
    }

    /// Returns the name of the field from which [`Scene::expectations`] are taken, in words.
    pub fn expectations_source(&self) -> &'static str {
        match (&self.stepper, &self.expect_network) {
            (StepperChoice::Fem(_), _) => "expect",
            (StepperChoice::Gnn(_), Some(_)) => "expect_network",
            (StepperChoice::Gnn(_), None) => "expect, without those that a network satisfies by construction",
        }
    }

    /// Returns both lists with the names of their fields.
    pub(super) fn expectation_lists(&self) -> [(&'static str, &[Expectation]); 2] {
        [("expect", &self.expect), ("expect_network", self.expect_network.as_deref().unwrap_or_default())]
    }

    /// Returns the finer mesh that the finite elements use instead of the mesh of the pads.
    pub fn finer_mesh(&self) -> Option<FinerMesh> {
        match &self.stepper {
            StepperChoice::Fem(fem) => fem.mesh,
            StepperChoice::Gnn(_) => None,
        }
    }

    /// Returns the scene without the finer mesh of the finite elements.
    pub fn without_finer_mesh(&self) -> Cow<'_, Self> {
        if self.finer_mesh().is_none() {
            return Cow::Borrowed(self);
        }
        let mut scene = self.clone();
        if let StepperChoice::Fem(fem) = &mut scene.stepper {
            fem.mesh = None;
        }
        Cow::Owned(scene)
    }

    /// Removes all expected results.
    pub fn clear_expectations(&mut self) {
        self.expect.clear();
        self.expect_network = None;
    }
}

/// Scene of one object, with the object's name.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedScene {
    /// Name of the object.
    pub name: Name,
    /// Scene with this object only.
    pub scene: Scene,
}

/// Declares [`ScenePart`] and all code that handles it field by field, so that a new field is added in one place.
macro_rules! part {
    ($($field:ident: $type:ty,)*) => {
        /// Scene file as written: any field may be missing; its value then comes from an include or the default.
        #[derive(Debug, Clone, Default, Deserialize)]
        #[serde(rename = "Scene", default, deny_unknown_fields)]
        pub(super) struct ScenePart {
            pub include: Vec<String>,
            $(pub $field: Option<$type>,)*
        }

        impl ScenePart {
            /// Replaces every field that `other` gives.
            pub fn merge(&mut self, other: ScenePart) {
                $(if other.$field.is_some() {
                    self.$field = other.$field;
                })*
            }

            /// Returns the names of the fields that this file gives.
            pub fn given_fields(&self) -> Vec<&'static str> {
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
    universe: Universe,
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
    /// Returns one complete scene per object. An object without a name is named `name`.
    ///
    /// # Errors
    /// Returns the name of the first missing field.
    pub fn complete(self, name: &Name) -> Result<Vec<NamedScene>, &'static str> {
        let loading = self.loading.ok_or("loading")?;
        let alone =
            |object| Entry { name: name.clone(), object, grasps: None, gripper: None, loading: None, gravity: None };
        let entries = match (self.object, self.objects, &self.universe, &loading) {
            (Some(object), ..) => vec![alone(object)],
            (None, Some(objects), ..) => objects,
            (None, None, Some(universe), Loading::Squeeze(squeeze)) => {
                universe.entries(&self.gripper.clone().unwrap_or_default(), squeeze)
            }
            (None, None, Some(_), _) => return Err("loading: Squeeze"),
            (None, None, None, _) => return Err("object"),
        };
        let scene = |entry: &Entry| Scene {
            about: self.about.clone().unwrap_or_default(),
            object: entry.object.clone(),
            gripper: entry.gripper.clone().or_else(|| self.gripper.clone()).unwrap_or_default(),
            grasps: entry.grasps.clone().or_else(|| self.grasps.clone()).unwrap_or_default(),
            loading: entry.loading.clone().unwrap_or_else(|| loading.clone()),
            stepper: self.stepper.clone().unwrap_or_default(),
            gravity: entry.gravity.or(self.gravity),
            ground: self.ground,
            record: self.record.clone().unwrap_or_default(),
            expect: self.expect.clone().unwrap_or_default(),
            expect_network: self.expect_network.clone(),
            task: self.task.clone(),
        };
        Ok(entries.iter().map(|e| NamedScene { name: e.name.clone(), scene: scene(e) }).collect())
    }
}
