//! Inputs of the face network for grasps of a scene, and their derivatives with respect to force, friction and pose of
//! the hand.

use super::inputs::{Array, PadInputs, grasp_inputs, pad_inputs};
use super::predict::Predictor;
use crate::features::GraspFeatures;
use crate::linear_response::canonical_pads::CanonicalPads;
use crate::linear_response::first_contact::GeometricContact;
use crate::linear_response::{GraspLoad, frame_loads};
use crate::network::card::{Card, StoredModel};
use crate::network::spec::NetworkSpec;
use base::error::{Error, Result};
use base::interrupt;
use geometry::Pose;
use glam::{DQuat, DVec3};
use model::Model;
use model::part::FingerModel;
use rayon::prelude::*;
use scene::{Loading, Scene};
use std::path::Path;
use std::sync::Arc;

/// Direction of differentiation of a grasp.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DerivativeDirection {
    /// Proportional change of all forces.
    Force,
    /// Change of the coefficient of friction.
    Friction,
    /// Change of the hand's position along an axis of the object frame.
    Position(usize),
    /// Rotation of the hand about its origin and an axis of the object frame.
    Rotation(usize),
}

impl DerivativeDirection {
    /// All changes.
    pub const ALL: [Self; 8] = [
        Self::Force,
        Self::Friction,
        Self::Position(0),
        Self::Position(1),
        Self::Position(2),
        Self::Rotation(0),
        Self::Rotation(1),
        Self::Rotation(2),
    ];
}

/// Grasp whose inputs are computed.
#[derive(Debug, Clone, PartialEq)]
pub struct GraspParameters {
    /// Pose of the hand.
    pub pose: Pose,
    /// Force under each load, N: the sum over the fingers.
    pub force: Vec<f64>,
    /// Coulomb's coefficient of friction.
    pub friction: f64,
}

impl GraspParameters {
    fn changed(&self, change: DerivativeDirection, by: f64) -> Self {
        let mut grip = self.clone();
        match change {
            DerivativeDirection::Force => grip.force.iter_mut().for_each(|force| *force *= 1.0 + by),
            DerivativeDirection::Friction => grip.friction += by,
            DerivativeDirection::Position(axis) => grip.pose.position += DVec3::AXES[axis] * by,
            DerivativeDirection::Rotation(axis) => {
                grip.pose.rotation = DQuat::from_scaled_axis(DVec3::AXES[axis] * by) * grip.pose.rotation;
            }
        }
        grip
    }
}

/// Inputs of a grasp, and their derivatives; the latter have an additional first axis over the changes.
pub type InputDerivatives = [Vec<Array<f32>>; 2];

/// Scene prepared for the face network.
#[derive(Debug)]
pub struct SceneInputs {
    predictor: Predictor,
    pads: CanonicalPads,
    loading: Loading,
    extrapolate: bool,
}

impl SceneInputs {
    /// Builds the scene for the network in the folder `model`, or the shipped one of this name.
    ///
    /// # Errors
    /// Fails if scene or model cannot be read, for a network of another kind, and for a scene outside the trained
    /// range.
    pub fn new(scene: &Scene, model: &Path, extrapolate: bool) -> Result<Self> {
        let predictor = Predictor::open(model)?;
        require_face_network(&predictor.card, model)?;
        let extrapolate = extrapolate || scene.stepper.extrapolates();
        let model = Model::build(&scene.without_finer_mesh())?;
        let pads = predictor.pads_if_in_range(&model, extrapolate)?;
        Ok(Self { predictor, pads, loading: scene.loading.clone(), extrapolate })
    }

    /// Returns the force under each load of the scene, N, the sum over the fingers, and its coefficient of friction.
    pub fn scene_forces_and_friction(&self) -> (Vec<f64>, f64) {
        let fingers = self.pads.model.fingers.len() as f64;
        (frame_loads(&self.pads.model).iter().map(|load| load.force * fingers).collect(), self.pads.model.friction)
    }

    /// Returns the inputs shared by all grasps.
    pub fn pad(&self) -> PadInputs {
        let young = self.pads.model.material.moduli().young;
        pad_inputs(&self.pads.graph, young, &self.predictor.card.normalisers).with_scene(&self.pads)
    }

    /// Returns for each of `grips` its inputs, and their derivatives along `changes`: with respect to the logarithm of
    /// the force, the coefficient of friction, m and rad. A grasp that cannot start, or is outside the trained range,
    /// has its own error.
    ///
    /// # Errors
    /// Fails if it is interrupted.
    pub fn grasps(
        &self,
        grips: &[GraspParameters],
        changes: &[DerivativeDirection],
    ) -> Result<Vec<Result<InputDerivatives>>> {
        let grasp = |grip: &GraspParameters| {
            interrupt::check()?;
            Ok(self.input_derivatives(grip, changes))
        };
        grips.par_iter().map(grasp).collect()
    }

    fn input_derivatives(&self, grip: &GraspParameters, changes: &[DerivativeDirection]) -> Result<InputDerivatives> {
        let model = self.checked_model(grip)?;
        let touches = |pose| self.pads.first_contact(pose);
        let touch = touches(grip.pose)?;
        let inputs = self.inputs_at_contact(&touch, &model, grip);
        let mut slopes: Vec<Array<f32>> = inputs.iter().map(|array| array.stack(changes.len())).collect();
        for change in changes {
            let step = self.step(grip, *change)?;
            let beside = |by: f64| -> Result<_> {
                let changed = grip.changed(*change, by);
                // Neither force nor friction changes the first contact.
                Ok(match changed.pose == grip.pose {
                    true => self.inputs_at_contact(&touch, &model, &changed),
                    false => self.inputs_at_contact(&touches(changed.pose)?, &model, &changed),
                })
            };
            let (before, after) = (beside(-step)?, beside(step)?);
            for (slopes, (before, after)) in slopes.iter_mut().zip(before.iter().zip(&after)) {
                let pairs = before.numbers.iter().zip(&after.numbers);
                slopes.numbers.extend(pairs.map(|(a, b)| ((f64::from(*b) - f64::from(*a)) / (2.0 * step)) as f32));
            }
        }
        Ok([inputs, slopes])
    }

    /// Returns the model under the forces and the friction of `grip`.
    fn checked_model(&self, grip: &GraspParameters) -> Result<Model> {
        let (loads, given, fingers) =
            (self.pads.model.levels.len(), grip.force.len(), self.pads.model.fingers.len() as f64);
        let refused = |what: String| Err(Error::Start(what));
        if let Some(bad) = grip.force.iter().find(|force| !(force.is_finite() && **force > 0.0)) {
            return refused(format!("a force of {bad} N; numbers above 0 are needed"));
        }
        if self.pads.model.push.is_some() && given != loads {
            return refused(format!(
                "{given} forces for a scene whose push has {loads} loads; give one force for each"
            ));
        }
        if !(grip.friction.is_finite() && grip.friction >= 0.0) {
            return refused(format!("a friction of {}; a number of 0 or above is needed", grip.friction));
        }
        let levels = grip.force.iter().map(|force| force / fingers).collect();
        let model = self.pads.model.with_loading(&self.loading, levels, grip.friction);
        self.predictor.card.range.check_model(&model, self.extrapolate)?;
        Ok(model)
    }

    /// Returns the inputs of `grip` with first contact `touch`. The path of its equilibrium always ends at the largest
    /// force of `model`, even if that of `grip` differs.
    fn inputs_at_contact(&self, touch: &GeometricContact, model: &Model, grip: &GraspParameters) -> Vec<Array<f32>> {
        let own = Arc::new(model.with_loading(&self.loading, model.levels.clone(), grip.friction));
        let features = GraspFeatures::new(&own, &self.pads.graph, touch);
        let (fingers, usual) = (own.fingers.len() as f64, frame_loads(&own));
        let squeezed = usual.into_iter().zip(&grip.force);
        let loads: Vec<_> = squeezed.map(|(load, force)| GraspLoad { force: force / fingers, ..load }).collect();
        grasp_inputs(&features, &features.loads(&loads), &self.predictor.card.normalisers)
    }

    /// Returns the step of a central difference: the square root of the machine precision of the inputs (f32), times a
    /// scale. Rounding causes an error of `eps / h`; kinks, such as a node coming into contact, cause one proportional
    /// to `h`; the square root minimises their sum. The scale of the position is the thickness of a pad; that of the
    /// rotation is the angle which moves the farthest face node by this thickness.
    ///
    /// # Errors
    /// Fails for the derivative with respect to friction of a frictionless grasp.
    fn step(&self, grip: &GraspParameters, change: DerivativeDirection) -> Result<f64> {
        let farthest = |finger: &FingerModel| {
            self.pads.graph.rest.iter().map(|x| finger.placement.place(*x).length()).fold(0.0, f64::max)
        };
        let scale = match change {
            DerivativeDirection::Force => 1.0,
            DerivativeDirection::Friction if grip.friction > 0.0 => grip.friction,
            DerivativeDirection::Friction => {
                return Err(Error::Start(
                    "there is no derivative with respect to friction at a friction of 0; give a positive friction"
                        .into(),
                ));
            }
            DerivativeDirection::Position(_) => self.pads.graph.thickness,
            DerivativeDirection::Rotation(_) => {
                self.pads.graph.thickness
                    / self.pads.model.fingers.iter().map(farthest).fold(f64::MIN_POSITIVE, f64::max)
            }
        };
        Ok(f64::from(f32::EPSILON).sqrt() * scale)
    }
}

/// Returns the weights of the face network in the folder `model`, or of the shipped one of this name: safetensors.
///
/// # Errors
/// Fails if the model cannot be read, and for a network of another kind.
pub fn weights(model: &Path) -> Result<Vec<u8>> {
    let trained = StoredModel::read(model)?;
    require_face_network(&trained.card, model)?;
    Ok(trained.weights.into_owned())
}

fn require_face_network(card: &Card, model: &Path) -> Result<()> {
    match card.spec.network {
        NetworkSpec::Face(_) => Ok(()),
        NetworkSpec::Paper(_) => {
            let what = "contains the paper's network; only a `Face` network runs in PyTorch: train one, or use the \
                built-in one";
            Err(Error::file(model, what))
        }
    }
}
