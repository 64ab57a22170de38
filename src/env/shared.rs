//! Data shared by all environments of a batch.

use super::draw::{EpisodeKey, EpisodeParameters, draw};
use super::identity::identity;
pub use super::object_kind::{ObjectKind, Variant};
use super::reward::{RewardFunction, StepInfo, term};
use backend::choose;
use base::error::{Error, Result};
use geometry::Pose;
use glam::DVec3;
use model::Model;
use model::sensors::{SensorModel, SensorSetup, sensor_model};
use scene::{NamedScene, Task};
use std::sync::{Arc, Mutex, PoisonError};
use world::Stepper;
use world::environment::Environment;

/// Shared models, grasps, sensors and backend.
pub struct EnvShared {
    /// Task of the agent.
    pub task: Task,
    /// Objects.
    pub kinds: Vec<ObjectKind>,
    /// Identity hash, which differs between environments of different scenes.
    pub identity: String,
    /// Backend.
    pub stepper: Box<dyn Stepper>,
    /// Sensors that write the observations, in order.
    pub sensors: Vec<Box<dyn SensorModel>>,
    /// Number of steps of an episode.
    pub steps: usize,
    /// User-defined reward, if any.
    pub reward_function: Option<Box<RewardFunction>>,
    /// Gravity in the object frame at the start, m/s2.
    gravity: DVec3,
    /// Worlds of finished episodes, for reuse.
    idle: Mutex<Vec<Environment>>,
}

/// Maximum number of idle worlds kept for reuse by grasps of the same model.
const MAX_IDLE: usize = 16;

impl EnvShared {
    /// Builds the shared data for `objects` (None is all) of `set`.
    ///
    /// # Errors
    /// Fails for a scene without a task, for an object that the scene does not contain, and for models that cannot be
    /// built or that the backend rejects.
    pub fn new(set: &[NamedScene], objects: Option<&[String]>, max_steps: Option<usize>) -> Result<Self> {
        let names = || set.iter().map(|s| s.name.as_str()).collect::<Vec<_>>().join(", ");
        let has = |name: &String| set.iter().any(|s| s.name.as_str() == name);
        if let Some(name) = objects.into_iter().flatten().find(|name| !has(name)) {
            return Err(Error::Start(format!("objects: the scene has no {name:?}; it has: {}", names())));
        }
        let wanted = |s: &&NamedScene| objects.is_none_or(|o| o.iter().any(|name| name == s.name.as_str()));
        let set: Vec<&NamedScene> = set.iter().filter(wanted).collect();
        let none = || Error::Start("objects: give at least one".into());
        let first = &set.first().ok_or_else(none)?.scene;
        let missing = || Error::Start("the scene has no `task: (...)`, which defines the task of an agent".into());
        let task = first.task.clone().ok_or_else(missing)?;
        set.iter().try_for_each(|named| named.scene.gripper.require_equal_fingers("a task"))?;
        let stepper = choose(first)?;
        let kinds =
            set.iter().map(|named| ObjectKind::new(named, &task, stepper.as_ref())).collect::<Result<Vec<_>>>()?;
        let model = &kinds[0].variants[0].model;
        let hand = SensorSetup { fingers: &model.fingers, stroke: model.stroke, force: task.force.interpolate(1.0) };
        Ok(Self {
            identity: identity(first, &task, &kinds)?,
            sensors: task.observe.iter().map(|o| sensor_model(o, &hand)).collect(),
            stepper,
            steps: max_steps.unwrap_or(task.steps.get()).max(1),
            gravity: task.gravity.map_or(DVec3::ZERO, |g| g.dvec3()),
            reward_function: None,
            idle: Mutex::default(),
            kinds,
            task,
        })
    }

    /// Draws the parameters of an episode; `attempt` counts infeasible starts.
    pub fn draw(&self, key: &EpisodeKey, attempt: u64) -> EpisodeParameters {
        let choices: Vec<&[Pose]> = self.kinds.iter().map(|k| k.poses.as_slice()).collect();
        draw(&self.task, &choices, self.center(), &mut key.random(attempt))
    }

    /// Returns the variant of a draw.
    pub fn variant(&self, draw: &EpisodeParameters) -> &Variant {
        &self.kinds[draw.object].variants[draw.variant]
    }

    /// Returns a world for a grasp of `model`: an idle one restarted, or a new one.
    ///
    /// # Errors
    /// Fails as [`Environment::new`] does.
    pub fn environment(&self, model: &Arc<Model>, pose: Pose) -> Result<Environment> {
        let stepper = self.stepper.as_ref();
        let known = {
            let mut idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner);
            let known = idle.iter().position(|e| Arc::ptr_eq(e.model(), model));
            known.map(|at| idle.swap_remove(at))
        };
        let Some(mut environment) = known else { return Environment::new(model, stepper, pose) };
        environment.restart(stepper, pose)?;
        Ok(environment)
    }

    /// Keeps a world that is no longer needed for reuse; drops the oldest if there are too many.
    pub fn recycle(&self, environment: Environment) {
        let mut idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        idle.push(environment);
        let first = (idle.len() > MAX_IDLE).then(|| idle.remove(0));
        drop(idle);
        drop(first);
    }

    /// Returns the weight of the object with the hand at `pose`, N, hand frame.
    pub fn weight(&self, draw: &EpisodeParameters, pose: &Pose) -> DVec3 {
        let model = &self.variant(draw).model;
        let mass = draw.density.map_or(model.mass, |d| d * model.object.mass.volume);
        pose.inverse().rotation * self.gravity * mass
    }

    /// Returns the point midway between the pads, hand frame, m.
    pub fn center(&self) -> DVec3 {
        self.kinds[0].variants[0].model.midpoint_between_pads()
    }

    /// Returns the total number of observed values.
    pub fn observation_size(&self) -> usize {
        self.sensors.iter().map(|s| s.spec().size()).sum()
    }

    /// Returns the reward of a step.
    pub fn reward(&self, info: &StepInfo) -> f64 {
        match &self.reward_function {
            Some(custom) => custom(info),
            None => self.task.reward.iter().map(|r| term(r).reward(info)).sum(),
        }
    }
}
