//! Objects of a scene, each with its models and grasps.

use super::reward::term;
use base::error::{Error, Result};
use geometry::Pose;
use model::Model;
use model::grasp::grasp_poses;
use scene::leaf::{Count, NonNegative, Positive};
use scene::{Field, Loading, MaterialChoice, NamedScene, Record, Scene, Squeeze, Task};
use std::sync::Arc;
use world::Stepper;

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

impl ObjectKind {
    pub(super) fn new(named: &NamedScene, task: &Task, stepper: &dyn Stepper) -> Result<Self> {
        let random = &task.randomise;
        let count = random.variants.get();
        // Stratified sampling: friction permutes its strata relative to the modulus, (i * step) mod n with step and n
        // coprime.
        let step = (count / 2 + 1..).find(|s| coprime(*s, count)).unwrap_or(1);
        let part = |k: usize| (k as f64 + 0.5) / count as f64;
        let variant = |k: usize| {
            let mut scene = adapted_scene(&named.scene, task)?;
            if let Some(young) = random.young {
                scene.gripper.material = scale_stiffness(&scene.gripper.material, young.interpolate(part(k)))?;
            }
            let nominal = scene.gripper.friction.get();
            let friction = random.friction.map_or(nominal, |span| span.interpolate(part(k * step % count)));
            if stepper.solves_friction() {
                scene.gripper.friction = checked_value(NonNegative::new(friction))?;
            }
            let mut model = Model::build(&scene)?;
            if let Some(model) = Arc::get_mut(&mut model) {
                // `shape` (smallest det F and gap of a prediction) and the interior of the pads are needed for reports only.
                (model.needs.task, model.needs.shape, model.needs.interior) = (true, false, false);
                model.needs.observe(&task.observe);
                model.max_drift = Some(DRIFT_FACTOR * task.slip_limit.get());
                let share = 1.0 / model.fingers.len() as f64;
                model.levels = vec![task.force.interpolate(0.0) * share, task.force.interpolate(1.0) * share];
                // The object is free from the first force level.
                model.release = model.contact_force().min(model.levels[0]);
            }
            Ok(Variant { model, friction })
        };
        let variants = (0..count).map(variant).collect::<Result<Vec<_>>>()?;
        Ok(Self { name: named.name.as_str().into(), variants, poses: grasp_poses(&named.scene)? })
    }
}

/// Motion of the object in one step at which it counts as dropped, relative to the accumulated slip that ends an
/// episode; above 1, because the object may also roll.
const DRIFT_FACTOR: f64 = 2.0;

/// Returns the scene adapted to an environment: the task defines the loads, and only the fields it uses are recorded.
fn adapted_scene(scene: &Scene, task: &Task) -> Result<Scene> {
    let mut scene = scene.clone();
    scene.clear_expectations();
    let force = checked_value(Positive::new(task.force.interpolate(1.0)))?;
    scene.loading = Loading::Squeeze(Squeeze {
        force,
        from: None,
        release: None,
        frames: checked_value(Count::new(1))?,
        push: None,
    });
    let mut fields = vec![Field::ContactForce];
    fields.extend(task.reward.iter().any(|r| term(r).needs_stress()).then_some(Field::Stress));
    scene.record = Record { fields, pictures: false, arrays: None, vtu: false, tactile: Vec::new() };
    Ok(scene)
}

/// Returns the material with Young's modulus multiplied by `factor`.
fn scale_stiffness(material: &MaterialChoice, factor: f64) -> Result<MaterialChoice> {
    let spec = material.spec();
    checked_value(material.with(spec.young * factor, spec.poisson))
}

/// Converts the message about an invalid value of the task into an error.
fn checked_value<T>(value: std::result::Result<T, String>) -> Result<T> {
    value.map_err(|message| Error::Start(format!("task: {message}")))
}

fn coprime(a: usize, b: usize) -> bool {
    let (mut a, mut b) = (a, b);
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a == 1
}
