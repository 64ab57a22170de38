//! Data that all environments of a batch share.

use super::draw::{Draw, EpisodeKey, draw};
use super::identity::identity;
use super::reward::{Custom, StepInfo};
use crate::backend::choose;
use crate::error::{Error, Result};
use crate::grasp::poses_of;
use crate::gripper::GraspPose;
use crate::model::Model;
use crate::observe::{Sense, SensedHand};
use crate::scene::leaf::{Count, NonNegative, Positive};
use crate::scene::{Field, Loading, MaterialChoice, NamedScene, Record, Scene, Squeeze, Task};
use crate::world::Stepper;
use crate::world::environment::Environment;
use glam::DVec3;
use std::sync::{Arc, Mutex, PoisonError};

/// An object of the scene.
#[derive(Debug)]
pub struct ObjectKind {
    /// Name of the object.
    pub name: String,
    /// Scenes with this object, one per gel and friction.
    pub variants: Vec<Variant>,
    /// Allowed poses of the hand.
    pub poses: Vec<GraspPose>,
}

/// A gel and a friction.
#[derive(Debug)]
pub struct Variant {
    /// Scene with this gel and friction.
    pub model: Arc<Model>,
    /// Coefficient of friction that the grip is judged with: a backend that does not solve friction keeps its own.
    pub friction: f64,
}

/// Models, grasps, sensors, backend.
pub struct EnvShared {
    /// The task.
    pub task: Task,
    /// The objects.
    pub kinds: Vec<ObjectKind>,
    /// Identity, which differs between arenas of different scenes.
    pub identity: String,
    /// The backend.
    pub stepper: Box<dyn Stepper>,
    /// Senses that write the observations, one after the other.
    pub senses: Vec<Box<dyn Sense>>,
    /// Number of steps of an episode.
    pub steps: usize,
    /// The user's reward, if there is one.
    pub custom: Option<Box<Custom>>,
    /// Gravity in the object frame at the start, m/s2.
    gravity: DVec3,
    /// Worlds whose episode is over.
    idle: Mutex<Vec<Environment>>,
}

/// Largest number of idle worlds that are kept for reuse by a grasp of the same model.
const IDLE: usize = 16;

impl EnvShared {
    /// Builds everything that `objects` (None is all) of `set` need.
    ///
    /// # Errors
    /// Fails for a scene without a task, for an object that the scene does not have, and for models that cannot be built or that
    /// the backend refuses.
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
        let missing = || Error::Start("the scene has no `task: (...)`, which says what an agent does".into());
        let task = first.task.clone().ok_or_else(missing)?;
        set.iter().try_for_each(|named| named.scene.gripper.needs_alike("a task"))?;
        let stepper = choose(first)?;
        let kinds =
            set.iter().map(|named| ObjectKind::new(named, &task, stepper.as_ref())).collect::<Result<Vec<_>>>()?;
        let model = &kinds[0].variants[0].model;
        let hand = SensedHand { fingers: &model.fingers, stroke: model.stroke, force: task.force.at(1.0) };
        Ok(Self {
            identity: identity(first, &task, &kinds)?,
            senses: task.observe.iter().map(|o| o.sense(&hand)).collect(),
            stepper,
            steps: max_steps.unwrap_or(task.steps.get()).max(1),
            gravity: task.gravity.map_or(DVec3::ZERO, |g| g.dvec3()),
            custom: None,
            idle: Mutex::default(),
            kinds,
            task,
        })
    }

    /// Returns the `attempt`th draw of an episode.
    pub fn draw(&self, key: &EpisodeKey, attempt: u64) -> Draw {
        let choices: Vec<&[GraspPose]> = self.kinds.iter().map(|k| k.poses.as_slice()).collect();
        draw(&self.task, &choices, self.center(), &mut key.random(attempt))
    }

    /// Returns gel, friction and model of a draw.
    pub fn variant(&self, draw: &Draw) -> &Variant {
        &self.kinds[draw.object].variants[draw.variant]
    }

    /// Makes a world for a grasp of `model`.
    ///
    /// # Errors
    /// Fails as [`Environment::new`] does.
    pub fn environment(&self, model: &Arc<Model>, pose: GraspPose) -> Result<Environment> {
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

    /// Takes back a world that is no longer needed.
    pub fn retire(&self, environment: Environment) {
        let mut idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        idle.push(environment);
        let first = (idle.len() > IDLE).then(|| idle.remove(0));
        drop(idle);
        drop(first);
    }

    /// Returns the weight of the object of a draw with the hand at `pose`, N, hand frame.
    pub fn weight(&self, draw: &Draw, pose: &GraspPose) -> DVec3 {
        let model = &self.variant(draw).model;
        let mass = draw.density.map_or(model.mass, |d| d * model.object.mass.volume);
        pose.object_in_hand().rotation * self.gravity * mass
    }

    /// Returns the point midway between the pads, hand frame, m.
    pub fn center(&self) -> DVec3 {
        let fingers = &self.kinds[0].variants[0].model.fingers;
        fingers.iter().map(|f| f.placement.origin).sum::<DVec3>() / fingers.len() as f64
    }

    /// Returns the number of values that an agent observes.
    pub fn seen(&self) -> usize {
        self.senses.iter().map(|s| s.spec().size()).sum()
    }

    /// Returns the payment for a step.
    pub fn pay(&self, info: &StepInfo) -> f64 {
        match &self.custom {
            Some(custom) => custom(info),
            None => self.task.reward.iter().map(|r| r.term().pay(info)).sum(),
        }
    }
}

impl ObjectKind {
    fn new(named: &NamedScene, task: &Task, stepper: &dyn Stepper) -> Result<Self> {
        let random = &task.randomise;
        let count = random.variants.get();
        // Friction goes through its strata in another order than the modulus: (i * step) mod n with step and n coprime.
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
                // What a prediction costs in truth is for reports, not for agents.
                (model.needs.task, model.needs.shape) = (true, false);
                model.needs.observe(&task.observe);
                model.largest_drift = Some(LEASH * task.slip_limit.get());
                let share = 1.0 / model.fingers.len() as f64;
                model.levels = vec![task.force.at(0.0) * share, task.force.at(1.0) * share];
                // An agent has it free from the start.
                model.release = model.contact_force().min(model.levels[0]);
            }
            Ok(Variant { model, friction })
        };
        let variants = (0..count).map(variant).collect::<Result<Vec<_>>>()?;
        Ok(Self { name: named.name.as_str().into(), variants, poses: poses_of(&named.scene)? })
    }
}

/// Motion of the object in one step at which it counts as lost, over the way over the pads that ends an episode; the object may
/// roll, too.
const LEASH: f64 = 2.0;

/// Returns the scene as an environment uses it: loads come from the task, and only the fields that it looks at are recorded.
fn alone(scene: &Scene, task: &Task) -> Result<Scene> {
    let mut scene = scene.clone();
    scene.promise_nothing();
    let force = leaf(Positive::new(task.force.at(1.0)))?;
    scene.loading =
        Loading::Squeeze(Squeeze { force, from: None, release: None, frames: leaf(Count::new(1))?, push: None });
    let mut fields = vec![Field::ContactForce];
    fields.extend(task.reward.iter().any(|r| r.term().needs_stress()).then_some(Field::Stress));
    scene.record = Record { fields, pictures: false, arrays: None, vtu: false, tactile: Vec::new() };
    Ok(scene)
}

/// Returns the gel with Young's modulus times `factor`.
fn scaled(material: &MaterialChoice, factor: f64) -> Result<MaterialChoice> {
    let spec = material.spec();
    leaf(material.with(spec.young * factor, spec.poisson))
}

/// Turns the message of a value from the task into an error.
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
