//! Identity of the environments of a scene: a hash of everything that affects an episode, independent of file names.

use super::object_kind::ObjectKind;
use base::error::{Error, Result};
use glam::DVec3;
use net::network::card::WEIGHTS;
use net::network::shipped;
use scene::{Fem, Gnn, Pads, Scene, StepperChoice, Task};
use serde::Serialize;
use std::path::PathBuf;

/// Returns the BLAKE3 hash (hexadecimal) of task, backend and gripper of `scene`, and of the objects and grasps of
/// `kinds`.
pub(crate) fn identity(scene: &Scene, task: &Task, kinds: &[ObjectKind]) -> Result<String> {
    let mut hasher = blake3::Hasher::new();
    hasher.update(text(task)?.as_bytes());
    let mut gripper = scene.gripper.clone();
    // The nodes of the pads are hashed below.
    gripper.pads = Pads::default();
    hasher.update(text(&gripper)?.as_bytes());
    match &scene.stepper {
        StepperChoice::Fem(fem) => hasher.update(text(&Fem { threads: None, ..*fem })?.as_bytes()),
        // A network is identified by its weights, not by its path.
        StepperChoice::Gnn(gnn) => {
            hasher.update(text(&Gnn { model: PathBuf::new(), ..gnn.clone() })?.as_bytes());
            match (shipped::by_name(&gnn.model), std::fs::read(gnn.model.join(WEIGHTS))) {
                (Some(shipped), _) => hasher.update(shipped.weights),
                (None, Ok(weights)) => hasher.update(&weights),
                (None, Err(_)) => hasher.update(gnn.model.as_os_str().as_encoded_bytes()),
            }
        }
    };
    for kind in kinds {
        hasher.update(kind.name.as_bytes());
        for pose in &kind.poses {
            numbers(&mut hasher, pose.position.to_array().into_iter().chain(pose.rotation.to_array()));
        }
        for variant in &kind.variants {
            let model = &variant.model;
            numbers(&mut hasher, [variant.friction, model.mass, f64::from(u8::from(model.free))].into_iter());
            vectors(&mut hasher, &model.object.surface.vertices);
            model.fingers.iter().for_each(|finger| vectors(&mut hasher, &finger.body.rest));
        }
    }
    Ok(hasher.finalize().to_hex().to_string())
}

fn text(part: &impl Serialize) -> Result<String> {
    ron::to_string(part).map_err(|e| Error::Start(format!("the scene cannot be written as RON: {e}")))
}

fn vectors(hasher: &mut blake3::Hasher, all: &[DVec3]) {
    numbers(hasher, all.iter().flat_map(|v| v.to_array()));
}

fn numbers(hasher: &mut blake3::Hasher, all: impl Iterator<Item = f64>) {
    all.for_each(|x| {
        hasher.update(&x.to_le_bytes());
    });
}
