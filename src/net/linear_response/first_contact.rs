//! Grasp at geometric first contact: the input of the network.
//!
//! Training and inference obtain it in the same way: with the phases `Place` and `Close` of the schedule, in which no
//! stepper takes part. It does not depend on any finite element result.

use base::error::{Error, Result};
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::Schedule;
use geometry::Pose;
use glam::DVec3;
use model::Model;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use world::Stepper;
use world::components::{FingerIndex, FingerTravel, ObjectPose};
use world::environment::Environment;
use world::schedule::Phase;

/// State of a grasp when the pads first touch the object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GeometricContact {
    /// Pose of the object.
    pub object: Pose,
    /// Travel of each finger, m.
    pub travel: Vec<f64>,
    /// Weight of the object, N, hand frame; zero without gravity or for a fixed object.
    pub weight: DVec3,
}

/// Stepper without systems.
#[derive(Debug)]
struct NoStepper;

impl Stepper for NoStepper {
    fn name(&self) -> &'static str {
        "still"
    }
    fn settings(&self) -> String {
        String::new()
    }
    fn prepare(&self, _: &mut World) -> Result<()> {
        Ok(())
    }
    fn register(&self, _: &mut Schedule, _: &mut World, _: &Model) {}
}

impl GeometricContact {
    /// Closes the fingers of a grasp at `pose`.
    ///
    /// # Errors
    /// Fails for a grasp that cannot start; the error states the reason.
    pub fn find(model: &Arc<Model>, pose: Pose) -> Result<Self> {
        Self::find_in(&mut None, model, pose)
    }

    /// Closes the fingers of a grasp at `pose` in the environment `kept` of `model`, which the first call creates and
    /// later calls reuse.
    ///
    /// # Errors
    /// Fails for a grasp that cannot start; the error states the reason.
    pub fn find_in(kept: &mut Option<Environment>, model: &Arc<Model>, pose: Pose) -> Result<Self> {
        let environment = match kept {
            Some(environment) => {
                environment.restart(&NoStepper, pose)?;
                environment
            }
            None => kept.insert(Environment::new(model, &NoStepper, pose)?),
        };
        loop {
            match environment.step() {
                Phase::Ramp { .. } => break,
                Phase::Infeasible { reason } | Phase::Dropped { reason } | Phase::Fault { reason } => {
                    return Err(Error::Start(reason));
                }
                Phase::Done => return Err(Error::Start("the grasp ended before its first step".into())),
                Phase::Place | Phase::Close => {}
            }
        }
        let world = environment.world_mut();
        let object = world.query::<&ObjectPose>().single(world).map_err(|e| Error::Start(e.to_string()))?.0;
        let fingers =
            world.query::<(&FingerIndex, &FingerTravel)>().iter(world).map(|(f, t)| (f.0, t.0)).collect::<Vec<_>>();
        Ok(Self::new(model, object, &fingers))
    }

    /// Creates the contact from the columns of a world whose fingers have just closed: finger numbers with their
    /// travel.
    pub fn new(model: &Model, object: Pose, fingers: &[(u32, f64)]) -> Self {
        let mut travel = vec![0.0; fingers.len()];
        fingers.iter().for_each(|(finger, t)| travel[*finger as usize] = *t);
        // First contact translates the object, but does not rotate it.
        let weight = match (model.gravity, model.free) {
            (Some(gravity), true) => object.rotation * gravity * model.mass,
            _ => DVec3::ZERO,
        };
        Self { object, travel, weight }
    }
}
