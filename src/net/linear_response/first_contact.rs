//! Grasp at geometric first contact: the input of the network.
//!
//! Training and inference obtain it in the same way, from undeformed pads. It does not depend on any finite element
//! result.

use base::error::{Error, Result};
use geometry::Pose;
use glam::DVec3;
use model::Model;
use serde::{Deserialize, Serialize};
use world::systems::control::excessive_weight;
use world::systems::sense::first_contact;

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

impl GeometricContact {
    /// Closes the fingers of a grasp with this pose of the hand in the object frame.
    ///
    /// # Errors
    /// Fails for a grasp that cannot start; the error states the reason.
    pub fn find(model: &Model, pose: Pose) -> Result<Self> {
        let mut object = pose.inverse();
        // First contact translates the object, but does not rotate it.
        let weight = match (model.gravity, model.free) {
            (Some(gravity), true) => object.rotation * gravity * model.mass,
            _ => DVec3::ZERO,
        };
        if let Some(reason) = excessive_weight(model, weight) {
            return Err(Error::Start(reason));
        }
        let travel = first_contact(model, &mut object).map_err(Error::Start)?;
        Ok(Self { object, travel, weight })
    }
}
