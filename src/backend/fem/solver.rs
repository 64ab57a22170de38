//! Solver of one grasp: one potential, minimised at every load level.

use super::condensed::Condensation;
use base::error::{Error, Result};
use base::saved_state::{StateReader, StateWriter};
use bevy_ecs::prelude::*;
use geometry::Pose;
use glam::DVec3;
use mech::contact::{PointContact, VertexContact};
use mech::newton::effort::Effort;
use mech::newton::{Failure, Newton, NewtonTolerance};
use mech::path::{Path, PathControl};
use mech::potential::edge::EdgeReading;
use mech::potential::inversion_barrier::inversion_barrier;
use mech::potential::point_load::PointLoad;
use mech::potential::state::{RigidUnknowns, State};
use mech::potential::term::{BodyTerm, ElasticEnergy, NodalLoads};
use model::Model;
use model::part::FingerModel;
use record::pad_name;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use world::systems::sense::{center_object, travel_to_contact};

/// Finite element solver of one grasp: accepted state, Newton's method, and condensed pads if selected.
#[derive(Resource)]
pub struct GraspSolver {
    /// Loading path: Newton solver, accepted state, and history for the extrapolation of the next state.
    pub path: Path,
    /// Condensed pads; None for full pads.
    pub(crate) condensed: Option<Condensation>,
    settings: scene::Fem,
    /// Number of load levels so far.
    pub(crate) steps: usize,
    /// Progress that checkpoints and snapshots store.
    pub(crate) progress: GraspProgress,
}

/// Progress of a grasp, stored in checkpoints and snapshots in addition to its path.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(crate) struct GraspProgress {
    /// Flag: the pads have made contact with the object.
    pub started: bool,
    /// Flag: the squeeze is complete, and the push rises.
    pub pushing: bool,
    /// Pose at first contact.
    pub start: Pose,
}

impl GraspSolver {
    /// Creates the solver in the state of undeformed pads in the open hand, with the object at `pose` (object frame in
    /// the hand frame).
    ///
    /// # Errors
    /// Fails if the symbolic factorisation of the stiffness of a pad fails.
    pub fn new(model: &Model, pose: Pose, settings: &scene::Fem) -> Result<Self> {
        let mut bodies: Vec<_> = model.fingers.iter().map(|f| f.body.clone()).collect();
        let loads: Vec<_> = (0..bodies.len()).map(|i| gel_weight_per_node(model, i, pose)).collect();
        let terms = model.fingers.iter().map(|finger| contact_terms(model, finger)).collect();
        let mut gels = Vec::new();
        let mut condensed = None;
        match settings.solver {
            scene::Solver::Full => {
                gels = loads.into_iter().map(full_pad_terms).collect();
            }
            scene::Solver::Condensed(c) => {
                gels.resize_with(bodies.len(), Vec::new);
                bodies = bodies.iter().map(|b| Arc::new(b.condensed(&[]))).collect();
                condensed = Some(Condensation::new(model, loads, c.error.get()));
            }
        }
        let closing: Vec<DVec3> = model.fingers.iter().map(|f| f.placement.closing).collect();
        let layout = if model.has_coupled_fingers() { RigidUnknowns::geared } else { RigidUnknowns::new };
        let rigid = layout(closing, model.force_driven, model.free, model.object.bounding_radius);
        // A condensed body has the nodes of the full one.
        let state = State {
            x: bodies.iter().map(|b| b.rest.clone()).collect(),
            travel: vec![0.0; bodies.len()],
            position: pose.position,
            rotation: pose.rotation,
        };
        let mut newton = Newton::new(bodies, terms, rigid)?;
        newton.gel = gels;
        newton.object.weight = weight_load(model, pose);
        newton.object.push = push_loads(model, pose);
        newton.effort = Effort::within(settings.max_time.map(|seconds| seconds.get()));
        let mut path = Path::new(newton, state, NewtonTolerance::new(model.offset));
        path.control = path_control(model);
        let progress = GraspProgress { started: false, pushing: false, start: pose };
        Ok(Self { path, condensed, settings: *settings, steps: 0, progress })
    }

    /// Writes everything that the next step depends on.
    pub(super) fn save_state(&self, history: &mut StateWriter) {
        history.write(&(self.progress, self.steps, self.condensed.is_some()));
        self.condensed.iter().for_each(|pads| pads.save_state(history));
        self.path.save_state(history);
    }

    /// Reads the history of a solver of the same scene.
    pub(super) fn restore_state(&mut self, model: &Model, history: &mut StateReader) -> Result<()> {
        let condensed: bool;
        (self.progress, self.steps, condensed) = history.read()?;
        match &mut self.condensed {
            Some(pads) if condensed => pads.restore_state(&mut self.path, history)?,
            Some(_) => self.fall_back_to_full_pads(model).map_err(Error::Start)?,
            None => {}
        }
        self.path.restore_state(history)
    }

    /// Returns the finite element settings of the scene.
    pub fn settings(&self) -> &scene::Fem {
        &self.settings
    }

    /// Sets the force at the centre of mass of a free object, N, hand frame, which replaces its weight. Has no effect
    /// if the model has no weight term.
    pub fn set_weight(&mut self, force: DVec3) {
        self.path.newton.object.weight.iter_mut().for_each(|weight| weight.force = force);
    }

    /// Applies the `fraction` of the object's weight to the fingers; its support carries the rest.
    pub(crate) fn apply_weight_fraction(&mut self, fraction: f64) {
        self.path.newton.object.weight.iter_mut().for_each(|weight| weight.fraction = fraction);
    }

    /// Returns the convergence criteria of Newton's method at the load `level` (force per finger, N, or travel of a
    /// press, m); they are looser for condensed pads, according to their accepted error.
    pub(crate) fn tolerance(&self, model: &Model, level: f64) -> NewtonTolerance {
        // The force of a press is not known in advance; modulus x depth x thickness of the softer pad is its order of
        // magnitude.
        let pads = model.fingers.iter().map(|f| f.body.material.moduli().young * level * f.topology.thickness());
        let press = pads.reduce(f64::min).unwrap_or(0.0);
        let force = if model.force_driven { level } else { press };
        let given = self.settings.tolerance;
        // No tighter than the accepted error of condensed pads.
        let loose = match self.settings.solver {
            scene::Solver::Condensed(c) if self.condensed.is_some() => {
                (CONDENSED_TOLERANCE * c.error.get() / given.force.get()).max(1.0)
            }
            _ => 1.0,
        };
        let relative = loose * given.force.get();
        let usual = NewtonTolerance::new(model.offset);
        NewtonTolerance {
            relative,
            // Without contact there is no contact force to compare with.
            force: 1e-2 * relative * force,
            length: loose * given.displacement.map_or(usual.length, |length| length.get()),
            iterations: self.settings.max_iterations.get() as u32,
            ..usual
        }
    }

    /// Moves the fingers to a clearance of half the contact offset from the object, with a free object centred between
    /// them.
    ///
    /// # Errors
    /// Fails with the reason if a pad overlaps the object in the open hand, or a finger does not meet the object.
    pub(crate) fn approach_object(&mut self, model: &Model) -> std::result::Result<(), String> {
        let pose = self.path.state.pose();
        let clearance = 0.5 * model.offset;
        let state = &mut self.path.state;
        for i in 0..model.fingers.len() {
            state.travel[i] = travel_to_contact(model, i, &pose, clearance)?;
        }
        state.position += center_object(model, &mut state.travel);
        Ok(())
    }

    /// Returns the reason why the accepted state, although in equilibrium, is no grasp: a finger has exceeded its
    /// stroke or lost contact. None if it is a grasp.
    pub(crate) fn lost_contact_reason(&self, model: &Model) -> Option<String> {
        let (newton, state) = (&self.path.newton, &self.path.state);
        for i in 0..model.fingers.len() {
            let name = pad_name(i);
            if state.travel[i] > model.stroke {
                let stroke = model.stroke * 1e3;
                return Some(format!(
                    "the {name} finger exceeded its stroke of {stroke:.1} mm: {}",
                    self.describe_lost_contact(model)
                ));
            }
            if !newton.edge_readings(state, i).iter().any(EdgeReading::active) {
                return Some(format!("the {name} finger lost contact: {}", self.describe_lost_contact(model)));
            }
        }
        None
    }

    /// Describes how the fingers lost contact.
    fn describe_lost_contact(&self, model: &Model) -> String {
        match model.free {
            true => format!("the object was squeezed out (it {})", self.describe_motion()),
            false => "it no longer touches the object".into(),
        }
    }

    /// Describes the motion of the object since first contact.
    fn describe_motion(&self) -> String {
        let state = &self.path.state;
        let moved = state.position.distance(self.progress.start.position) * 1e3;
        let turned = (state.rotation * self.progress.start.rotation.inverse()).to_scaled_axis().length().to_degrees();
        format!("moved by {moved:.1} mm and rotated by {turned:.1} degrees")
    }

    /// Returns the message for a solve that failed: where (`at`), the cause, the last accepted load level, and the
    /// motion of a free object if it is large.
    pub(crate) fn failure_message(&self, model: &Model, at: &str, failure: Failure) -> String {
        let state = &self.path.state;
        let moved = state.position.distance(self.progress.start.position);
        let far = match model.free && moved > REPORTED_MOTION * model.object.bounding_radius {
            true if failure.leaves_the_grasp() => format!("; {}", self.describe_lost_contact(model)),
            // Whether it would have reached equilibrium is unknown.
            true => format!("; the object {} before that", self.describe_motion()),
            false => String::new(),
        };
        format!("{at}: {failure}; last accepted level {:.4e}{far}", self.path.level)
    }
}

/// Fraction of the allowed path error that one increment may have: the errors of all increments add up.
const INCREMENT_ERROR: f64 = 0.5;
/// Travel of the first increment of a press, over the thickness of the pad.
const FIRST_TRAVEL_INCREMENT: f64 = 0.01;

/// Returns the control of the increments; None if the path error is not controlled.
fn path_control(model: &Model) -> Option<PathControl> {
    let first_load =
        if model.force_driven { model.contact_force() } else { FIRST_TRAVEL_INCREMENT * model.thickness() };
    model.path_error.map(|error| PathControl { max_path_error: INCREMENT_ERROR * error, first_load })
}

/// Relative force tolerance of condensed pads, over their accepted error.
const CONDENSED_TOLERANCE: f64 = 0.05;
/// Motion of a free object, over its radius, above which the message of a failed solve mentions it.
const REPORTED_MOTION: f64 = 0.1;

/// Returns the terms of the potential of a full pad: elastic energy, inversion barrier, and the dead loads `loads` (N
/// per node, hand frame; empty for none).
pub(crate) fn full_pad_terms(loads: Vec<DVec3>) -> Vec<Box<dyn BodyTerm>> {
    let (nodes, centers) = inversion_barrier();
    let mut terms: Vec<Box<dyn BodyTerm>> = vec![Box::new(ElasticEnergy), Box::new(nodes), Box::new(centers)];
    terms.extend((!loads.is_empty()).then(|| Box::new(NodalLoads(loads)) as Box<dyn BodyTerm>));
    terms
}

/// Returns the weight of the gel of finger `i`, distributed to its nodes, N, hand frame, for an object at `pose`. Empty
/// without gravity, and in a dynamic scene, where the inertia terms include gravity.
pub(crate) fn gel_weight_per_node(model: &Model, i: usize, pose: Pose) -> Vec<DVec3> {
    let (Some(gravity), None) = (model.gravity, &model.dynamics) else { return Vec::new() };
    let g = pose.rotation * gravity;
    let finger = &model.fingers[i];
    finger.body.nodal_volume().iter().map(|v| g * (v * finger.gel_density)).collect()
}

/// Returns the terms of contact between the pad of `finger` and the object.
fn contact_terms(model: &Model, finger: &FingerModel) -> Vec<Box<dyn BodyTerm>> {
    let points = PointContact::new(finger.law, finger.surface.clone(), model.object.distance.clone());
    let mut terms: Vec<Box<dyn BodyTerm>> = vec![Box::new(points)];
    if !model.features.is_empty() {
        terms.push(Box::new(VertexContact::new(finger.law, finger.surface.clone(), model.features.clone())));
    }
    terms
}

/// Returns the weight of a free object at `pose`, if the scene has one. In a dynamic scene the inertia term includes
/// gravity; in the world of an agent the load is set at every step.
fn weight_load(model: &Model, pose: Pose) -> Option<PointLoad> {
    let pulled = model.free && model.dynamics.is_none() && (model.needs.task || model.gravity.is_some());
    let center = model.object.mass.center;
    let start = pose.position + pose.rotation * center;
    let force = pose.rotation * model.gravity.unwrap_or_default() * model.mass;
    pulled.then(|| PointLoad::new(force, center, start))
}

/// Returns the forces of the push on an object that is at `pose` at first contact; all are inactive at first.
fn push_loads(model: &Model, pose: Pose) -> Vec<PointLoad> {
    let Some(push) = &model.push else { return Vec::new() };
    let center = model.object.mass.center;
    let at = |(arm, force): (DVec3, DVec3)| {
        let point = center + pose.rotation.inverse() * arm;
        PointLoad { fraction: 0.0, ..PointLoad::new(force, point, pose.position + pose.rotation * point) }
    };
    let all = std::iter::once((DVec3::ZERO, push.force)).chain(push.couple(model.object.bounding_radius));
    all.filter(|(_, force)| *force != DVec3::ZERO).map(at).collect()
}
