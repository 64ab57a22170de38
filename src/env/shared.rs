//! Data shared by all environments of a batch.

use super::draw::{Draw, EpisodeKey, draw};
use super::identity::identity;
use super::reward::{Custom, StepInfo, term};
use backend::choose;
use base::error::{Error, Result};
use geometry::Pose;
use glam::DVec3;
use model::Model;
use model::grasp::poses_of;
use model::sensors::{Sense, SensorSetup, sense};
use scene::leaf::{Count, NonNegative, Positive};
use scene::{Field, Loading, MaterialChoice, NamedScene, Record, Scene, Squeeze, Task};
use std::sync::{Arc, Mutex, PoisonError};
use world::Stepper;
use world::environment::Environment;

/// Object of the scene.
#[derive(Debug)]
pub struct ObjectKind {
    /// Name of the object.
    pub name: String,
    /// Models with this object, one per combination of gel and friction.
    pub variants: Vec<Variant>,
    /// Candidate grasp poses.
    pub poses: Vec<Pose>,
}

/// Combination of gel stiffness and friction coefficient.
#[derive(Debug)]
pub struct Variant {
    /// Model with this gel and friction.
    pub model: Arc<Model>,
    /// Friction coefficient used to evaluate the grip; the model of a backend that does not solve friction keeps the
    /// nominal one.
    pub friction: f64,
}

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
    pub senses: Vec<Box<dyn Sense>>,
    /// Number of steps of an episode.
    pub steps: usize,
    /// User-defined reward, if any.
    pub custom: Option<Box<Custom>>,
    /// Gravity in the object frame at the start, m/s2.
    gravity: DVec3,
    /// Worlds of finished episodes, for reuse.
    idle: Mutex<Vec<Environment>>,
}

/// Maximum number of idle worlds kept for reuse by grasps of the same model.
const IDLE: usize = 16;

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
        set.iter().try_for_each(|named| named.scene.gripper.needs_alike("a task"))?;
        let stepper = choose(first)?;
        let kinds =
            set.iter().map(|named| ObjectKind::new(named, &task, stepper.as_ref())).collect::<Result<Vec<_>>>()?;
        let model = &kinds[0].variants[0].model;
        let hand = SensorSetup { fingers: &model.fingers, stroke: model.stroke, force: task.force.at(1.0) };
        Ok(Self {
            identity: identity(first, &task, &kinds)?,
            senses: task.observe.iter().map(|o| sense(o, &hand)).collect(),
            stepper,
            steps: max_steps.unwrap_or(task.steps.get()).max(1),
            gravity: task.gravity.map_or(DVec3::ZERO, |g| g.dvec3()),
            custom: None,
            idle: Mutex::default(),
            kinds,
            task,
        })
    }

    /// Draws the parameters of an episode; `attempt` counts infeasible starts.
    pub fn draw(&self, key: &EpisodeKey, attempt: u64) -> Draw {
        let choices: Vec<&[Pose]> = self.kinds.iter().map(|k| k.poses.as_slice()).collect();
        draw(&self.task, &choices, self.center(), &mut key.random(attempt))
    }

    /// Returns the variant of a draw.
    pub fn variant(&self, draw: &Draw) -> &Variant {
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
    pub fn retire(&self, environment: Environment) {
        let mut idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        idle.push(environment);
        let first = (idle.len() > IDLE).then(|| idle.remove(0));
        drop(idle);
        drop(first);
    }

    /// Returns the weight of the object with the hand at `pose`, N, hand frame.
    pub fn weight(&self, draw: &Draw, pose: &Pose) -> DVec3 {
        let model = &self.variant(draw).model;
        let mass = draw.density.map_or(model.mass, |d| d * model.object.mass.volume);
        pose.inverse().rotation * self.gravity * mass
    }

    /// Returns the point midway between the pads, hand frame, m.
    pub fn center(&self) -> DVec3 {
        let fingers = &self.kinds[0].variants[0].model.fingers;
        fingers.iter().map(|f| f.placement.origin).sum::<DVec3>() / fingers.len() as f64
    }

    /// Returns the total number of observed values.
    pub fn seen(&self) -> usize {
        self.senses.iter().map(|s| s.spec().size()).sum()
    }

    /// Returns the reward of a step.
    pub fn pay(&self, info: &StepInfo) -> f64 {
        match &self.custom {
            Some(custom) => custom(info),
            None => self.task.reward.iter().map(|r| term(r).pay(info)).sum(),
        }
    }
}

impl ObjectKind {
    fn new(named: &NamedScene, task: &Task, stepper: &dyn Stepper) -> Result<Self> {
        let random = &task.randomise;
        let count = random.variants.get();
        // Stratified sampling: friction permutes its strata relative to the modulus, (i * step) mod n with step and n
        // coprime.
        let step = (count / 2 + 1..).find(|s| coprime(*s, count)).unwrap_or(1);
        let part = |k: usize| (k as f64 + 0.5) / count as f64;
        let variant = |k: usize| {
            let mut scene = alone(&named.scene, task)?;
            if let Some(young) = random.young {
                scene.gripper.material = scaled(&scene.gripper.material, young.at(part(k)))?;
            }
            let nominal = scene.gripper.friction.get();
            let friction = random.friction.map_or(nominal, |span| span.at(part(k * step % count)));
            if stepper.solves_friction() {
                scene.gripper.friction = leaf(NonNegative::new(friction))?;
            }
            let mut model = Model::build(&scene)?;
            if let Some(model) = Arc::get_mut(&mut model) {
                // `shape` (smallest det F and gap of a prediction) is needed for reports only.
                (model.needs.task, model.needs.shape) = (true, false);
                model.needs.observe(&task.observe);
                model.largest_drift = Some(DRIFT_FACTOR * task.slip_limit.get());
                let share = 1.0 / model.fingers.len() as f64;
                model.levels = vec![task.force.at(0.0) * share, task.force.at(1.0) * share];
                // The object is free from the first force level.
                model.release = model.contact_force().min(model.levels[0]);
            }
            Ok(Variant { model, friction })
        };
        let variants = (0..count).map(variant).collect::<Result<Vec<_>>>()?;
        Ok(Self { name: named.name.as_str().into(), variants, poses: poses_of(&named.scene)? })
    }
}

/// Motion of the object in one step at which it counts as dropped, relative to the accumulated slip that ends an
/// episode; above 1, because the object may also roll.
const DRIFT_FACTOR: f64 = 2.0;

/// Returns the scene adapted to an environment: the task defines the loads, and only the fields it uses are recorded.
fn alone(scene: &Scene, task: &Task) -> Result<Scene> {
    let mut scene = scene.clone();
    scene.promise_nothing();
    let force = leaf(Positive::new(task.force.at(1.0)))?;
    scene.loading =
        Loading::Squeeze(Squeeze { force, from: None, release: None, frames: leaf(Count::new(1))?, push: None });
    let mut fields = vec![Field::ContactForce];
    fields.extend(task.reward.iter().any(|r| term(r).needs_stress()).then_some(Field::Stress));
    scene.record = Record { fields, pictures: false, arrays: None, vtu: false, tactile: Vec::new() };
    Ok(scene)
}

/// Returns the material with Young's modulus multiplied by `factor`.
fn scaled(material: &MaterialChoice, factor: f64) -> Result<MaterialChoice> {
    let spec = material.spec();
    leaf(material.with(spec.young * factor, spec.poisson))
}

/// Converts the message about an invalid value of the task into an error.
fn leaf<T>(value: std::result::Result<T, String>) -> Result<T> {
    value.map_err(|message| Error::Start(format!("task: {message}")))
}

fn coprime(a: usize, b: usize) -> bool {
    let (mut a, mut b) = (a, b);
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a == 1
}
