//! Simulation of one grasp as an entity-component world and the schedule of its steps. Environments share only the
//! [`Model`], so any number may run in parallel.

use crate::Stepper;
use crate::schedule::{FallbackReason, GraspPose, Phase, RecordedFrame, SharedModel, StepSet, Timings};
use crate::spawn::{reset, spawn};
use crate::systems::audit::AuditFindings;
use crate::systems::schedule;
use base::error::{Error, Result};
use bevy_ecs::prelude::*;
use geometry::Pose;
use model::Model;
use model::evaluation::Findings;
use record::Frame;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Simulation of one grasp: the state (a `bevy_ecs` world) and the systems that advance it.
pub struct Environment {
    world: World,
    schedule: Schedule,
}

impl Environment {
    /// Creates the grasp of `model` at `pose`, the pose of the hand in the object frame, advanced by the backend
    /// `stepper`. The first step places the object in the open hand.
    ///
    /// # Errors
    /// Fails if the stepper rejects the scene, or if systems access the same data in an undefined order.
    pub fn new(model: &Arc<Model>, stepper: &dyn Stepper, pose: Pose) -> Result<Self> {
        let mut world = spawn(model, pose);
        let mut schedule = schedule(&model.needs);
        stepper.prepare(&mut world)?;
        stepper.register(&mut schedule, &mut world, model);
        schedule.initialize(&mut world).map_err(|e| {
            Error::Start(format!("the schedule of a step is invalid: {}", e.to_string(schedule.graph(), &world)))
        })?;
        Ok(Self { world, schedule })
    }

    /// Restarts with another grasp of the same model, at `pose` (the pose of the hand in the object frame). `stepper`
    /// is the backend that the environment was created with. The result equals that of a new environment.
    ///
    /// # Errors
    /// Fails in the cases of [`Environment::new`].
    pub fn restart(&mut self, stepper: &dyn Stepper, pose: Pose) -> Result<()> {
        let model = self.model().clone();
        if stepper.systems_depend_on_grasp() {
            *self = Self::new(&model, stepper, pose)?;
            return Ok(());
        }
        reset(&mut self.world, &model, pose);
        stepper.prepare(&mut self.world)
    }

    /// Returns the model of the scene: object, pads, gripper and loads, shared by all grasps.
    pub fn model(&self) -> &Arc<Model> {
        &self.world.resource::<SharedModel>().0
    }

    /// Returns the pose of the hand in the object frame.
    pub fn pose(&self) -> Pose {
        self.world.resource::<GraspPose>().0
    }

    /// Runs one step: places the object, closes the hand to first contact, or advances to the next load level. Does
    /// nothing in a final phase ([`Phase::is_final`]). Returns the phase of the next step.
    pub fn step(&mut self) -> Phase {
        if !self.phase().is_final() {
            self.world.resource_mut::<RecordedFrame>().0 = None;
            self.schedule.run(&mut self.world);
        }
        self.phase()
    }

    /// Returns the phase of the next step.
    pub fn phase(&self) -> Phase {
        self.world.resource::<Phase>().clone()
    }

    /// Returns the frame that the last step recorded; None if it recorded none.
    pub fn frame(&self) -> Option<&Frame> {
        self.world.resource::<RecordedFrame>().0.as_ref()
    }

    /// Removes the frame that the last step recorded from the world and returns it; None if there is none.
    pub fn take_frame(&mut self) -> Option<Frame> {
        self.world.resource_mut::<RecordedFrame>().0.take()
    }

    /// Returns the findings of the independent audit of the frame that the last step recorded; None if it recorded
    /// none, or if no expectation of the scene requires an audit.
    pub fn findings(&self) -> Option<Findings> {
        self.frame().and(self.world.get_resource::<AuditFindings>()?.0)
    }

    /// Returns the reason why this grasp fell back from the network to finite elements; None if it did not.
    pub fn fallback_reason(&self) -> Option<&str> {
        self.world.get_resource::<FallbackReason>().map(|reason| reason.0.as_str())
    }

    /// Returns the wall time by stage, s, and the number of iterations that the stepper has spent since the start of
    /// the grasp.
    pub fn timings(&self) -> &Timings {
        self.world.resource::<Timings>()
    }

    /// Returns the world that holds the state, read-only.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Returns the world that holds the state, for queries and changes between steps; the next step starts from the
    /// changed components.
    pub fn world_mut(&mut self) -> &mut World {
        &mut self.world
    }

    /// Returns the names of the systems of a step, by set; sets and systems are in the order in which they run.
    pub fn systems(&self) -> Vec<(StepSet, Vec<String>)> {
        let mut sets = Vec::new();
        for set in StepSet::ALL {
            let keys = self.schedule.graph().systems_in_set(set.intern());
            let named = self.schedule.systems().into_iter().flatten().filter_map(|(key, system)| {
                let inside = keys.as_ref().is_ok_and(|keys| keys.contains(&key));
                inside.then(|| system.name().to_string().trim_start_matches("tactus_").to_string())
            });
            sets.push((set, named.collect()));
        }
        sets
    }

    /// Returns the number of entities with each component of [`crate::components`].
    pub fn components(&self) -> BTreeMap<String, usize> {
        let mut counts = BTreeMap::new();
        for archetype in self.world.archetypes().iter().filter(|a| !a.is_empty()) {
            for &id in archetype.components() {
                let name = self.world.components().get_name(id).map(|n| n.to_string()).unwrap_or_default();
                if let Some(name) = name.strip_prefix("tactus_world::components::") {
                    *counts.entry(name.to_string()).or_insert(0) += archetype.len() as usize;
                }
            }
        }
        counts
    }
}
