//! Network backend: a trained graph network predicts the state of each load level, with the phases and components of
//! the finite element backend.

use base::error::{Error, Result};
use base::saved_state::{StateReader, StateWriter};
use bevy_ecs::prelude::*;
use geometry::Wrench;
use glam::DVec3;
use model::{Model, Needs};
use net::infer::contact_correction::object_pose;
use net::infer::force_interpolation::ForceInterpolation;
use net::infer::friction_margin::slip_reason;
use net::infer::load_interpolation::LoadInterpolation;
use net::infer::predict::{EncodedGrasp, GraspState, PadState, Predictor};
use net::linear_response::GraspLoad;
use net::linear_response::canonical_pads::CanonicalPads;
use net::linear_response::first_contact::GeometricContact;
use rayon::prelude::*;
use record::ErrorBound;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use std::time::Instant;
use world::Stepper;
use world::components::*;
use world::schedule::{
    BalanceReport, ForceCommand, GraspPose, NextPhase, Phase, SharedModel, StepLoad, StepReport, StepSet, Timings,
    computes_frame, reached,
};
use world::systems::sense::close_to_contact;

/// Backend that predicts each load level of a grasp by a trained network, in place of solving for equilibrium.
#[derive(Debug)]
pub struct NetworkStepper {
    predictor: Arc<Predictor>,
    /// Folder or name of the model.
    model: PathBuf,
    /// Flag: scenes outside the training range are accepted.
    extrapolate: bool,
}

impl NetworkStepper {
    /// Opens the model in the folder `model`, or the bundled model of this name.
    ///
    /// # Errors
    /// Fails if there is no such model, and if its card or weights are damaged or do not match.
    pub fn open(model: &Path) -> Result<Self> {
        Ok(Self { predictor: Arc::new(Predictor::open(model)?), model: model.to_path_buf(), extrapolate: false })
    }

    /// Returns the backend with the flag `extrapolate` set: if true, scenes outside the training range are accepted;
    /// their error is unknown.
    pub fn extrapolating(self, extrapolate: bool) -> Self {
        Self { extrapolate, ..self }
    }

    /// Returns the reason why the force of a frame of `model` is outside the training range; None if all are inside, or
    /// if the backend extrapolates.
    pub fn reason_outside_range(&self, model: &Model) -> Option<String> {
        self.predictor.card.range.forces_outside(model).filter(|_| !self.extrapolate)
    }

    /// Predicts all load levels of the grasp of a prepared `world` in advance. Returns the largest 90 % error bound of
    /// the displacement over the levels (relative error that nine of ten predictions do not exceed); infinite if it is
    /// unknown.
    ///
    /// # Errors
    /// Fails if the world is not prepared for the network, the fingers do not reach the object, or a predicted number
    /// is not finite.
    pub fn predict_all_loads(&self, world: &mut World) -> Result<f64> {
        let missing = || Error::Start("the world was not prepared for the network".into());
        let pose = world.get_resource::<GraspPose>().ok_or_else(missing)?.0;
        let mut prediction = world.get_resource_mut::<Prediction>().ok_or_else(missing)?;
        let contact = prediction.canonical.first_contact(pose)?;
        prediction.encode(contact);
        Ok(prediction.predict_all_loads()?.map_or(f64::INFINITY, |error| error.displacement))
    }

    /// Removes the resources of the network from `world`, for a grasp that falls back to finite elements.
    pub fn remove_resources(&self, world: &mut World) {
        world.remove_resource::<Prediction>();
    }
}

impl Stepper for NetworkStepper {
    fn name(&self) -> &'static str {
        "gnn"
    }

    fn settings(&self) -> String {
        format!("{}, {} parameters", self.model.display(), self.predictor.card.parameters)
    }

    fn solves_friction(&self) -> bool {
        false
    }

    fn has_error_bound(&self) -> bool {
        self.predictor.card.interval().is_some()
    }

    fn notices(&self, model: &Model) -> Vec<String> {
        self.predictor.notices(model, self.extrapolate)
    }

    fn check_support(&self, model: &Arc<Model>) -> Result<()> {
        self.predictor.pads_if_in_range(model, self.extrapolate).map(drop)
    }

    fn prepare(&self, world: &mut World) -> Result<()> {
        let missing = || Error::Start("the world was not created for a grasp".into());
        let shared = world.get_resource::<SharedModel>().ok_or_else(missing)?.clone();
        let model = &shared.0;
        // An agent may command any force.
        let admit = if model.needs.task { Predictor::pads_if_in_range } else { Predictor::pads_if_some_force_in_range };
        let canonical = admit(&self.predictor, model, self.extrapolate)?;
        let (frames, loads) = self.predictor.answerable_loads(model, self.extrapolate).into_iter().unzip();
        world.insert_resource(Prediction {
            predictor: self.predictor.clone(),
            canonical,
            face: model.finger()?.topology.sensing_nodes(),
            frames,
            loads,
            grasp: None,
            state: None,
            ahead: None,
            interpolation: OnceLock::new(),
        });
        Ok(())
    }

    fn register(&self, schedule: &mut Schedule, _: &mut World, model: &Model) {
        register(schedule, &model.needs);
    }

    fn save_state(&self, world: &World, history: &mut StateWriter) {
        let prediction = world.get_resource::<Prediction>();
        let contact = prediction.and_then(|prediction| prediction.grasp.as_ref()).map(|(contact, _)| contact);
        history.write(&contact);
        history.write(&prediction.is_some_and(|prediction| prediction.ahead.is_some()));
    }

    fn restore_state(&self, world: &mut World, history: &mut StateReader) -> Result<()> {
        let missing = || Error::Start("the world was not prepared for the network".into());
        let mut prediction = world.get_resource_mut::<Prediction>().ok_or_else(missing)?;
        if let Some(contact) = history.read::<Option<GeometricContact>>()? {
            prediction.encode(contact);
        }
        let ahead: bool = history.read()?;
        if ahead && prediction.ahead.is_none() {
            prediction.predict_all_loads()?;
        }
        Ok(())
    }
}

/// Prediction of the network for the grasp of a world: encoding at first contact, and the states predicted so far.
#[derive(Resource)]
pub struct Prediction {
    predictor: Arc<Predictor>,
    canonical: CanonicalPads,
    /// Nodes of the sensing face on the mesh of the scene.
    face: Vec<u32>,
    /// Numbers of the frames that the network can predict, and their loads.
    frames: Vec<usize>,
    loads: Vec<GraspLoad>,
    /// First contact, and its encoding by the network.
    grasp: Option<(GeometricContact, EncodedGrasp)>,
    /// State at the load of this step.
    state: Option<GraspState>,
    /// States of the predictable frames, if their loads are known in advance.
    ahead: Option<LoadInterpolation>,
    /// States at any load, for an agent; None if one of the sampled loads cannot be predicted.
    interpolation: OnceLock<Option<ForceInterpolation>>,
}

impl Prediction {
    /// Encodes the grasp at first contact, unless this contact is encoded already.
    fn encode(&mut self, contact: GeometricContact) {
        if self.grasp.as_ref().is_some_and(|(known, _)| *known == contact) {
            return;
        }
        let seen = self.predictor.encode_first_contact(&self.canonical, &contact).with_needed_fields();
        self.grasp = Some((contact, seen));
        (self.ahead, self.interpolation) = (None, OnceLock::new());
    }

    /// Decodes the frames of an encoded grasp. Returns the largest of their errors; None if no grasp is encoded.
    fn predict_all_loads(&mut self) -> Result<Option<ErrorBound>> {
        let Some((_, seen)) = &self.grasp else { return Ok(None) };
        let ramp = LoadInterpolation::new(&self.predictor, seen, &self.loads)?;
        Ok(Some(self.ahead.insert(ramp).error()))
    }

    /// Returns the states of the pads at the load of this step; empty before the first.
    fn pads(&self) -> &[PadState] {
        self.state.as_ref().map_or(&[], |state| &state.pads)
    }

    fn pads_mut(&mut self) -> &mut [PadState] {
        self.state.as_mut().map_or(&mut [], |state| &mut state.pads)
    }
}

/// Adds the systems to their sets, except those for quantities that the scene does not need.
fn register(schedule: &mut Schedule, needs: &Needs) {
    schedule.add_systems(encode_grasp.run_if(computes_frame).after(close_to_contact).in_set(StepSet::Sense));
    schedule.add_systems((predict, write_state).chain().run_if(computes_frame).in_set(StepSet::Advance));
    if needs.task {
        schedule.add_systems(
            distribute_load.run_if(computes_frame).after(predict).before(write_state).in_set(StepSet::Advance),
        );
    }
    if needs.shape {
        schedule.add_systems(measure_shape.run_if(reached).in_set(StepSet::Measure));
    }
    if needs.stress {
        schedule.add_systems(write_stress.run_if(reached).in_set(StepSet::Measure));
    }
    if needs.contact_force {
        schedule.add_systems(write_contact.run_if(reached).in_set(StepSet::Measure));
    }
}

/// Encodes the grasp once, at first contact: travel and pose become those of the canonical pads.
fn encode_grasp(
    phase: Res<Phase>,
    grasp: Res<GraspPose>,
    mut prediction: ResMut<Prediction>,
    mut timings: ResMut<Timings>,
    mut next: ResMut<NextPhase>,
    mut fingers: Query<(&FingerIndex, &mut FingerTravel, &mut FirstContact)>,
    mut pose: Single<&mut ObjectPose>,
) {
    if *phase != (Phase::Ramp { frame: 0 }) {
        return;
    }
    let clock = Instant::now();
    let contact = match prediction.canonical.first_contact(grasp.0) {
        Ok(contact) => contact,
        Err(error) => return next.request(Phase::Infeasible { reason: error.to_string() }),
    };
    pose.0 = contact.object;
    for (finger, mut now, mut first) in &mut fingers {
        let travel = contact.travel[finger.0 as usize];
        (now.0, first.0) = (travel, travel);
    }
    prediction.encode(contact);
    timings.stages.insert("encode", clock.elapsed().as_secs_f64());
}

/// Predicts one load level. A failed prediction or slip of the object ends the grasp.
#[allow(clippy::too_many_arguments)]
fn predict(
    phase: Res<Phase>,
    shared: Res<SharedModel>,
    command: Option<Res<ForceCommand>>,
    mut prediction: ResMut<Prediction>,
    load: Res<StepLoad>,
    weight: Option<Single<&ObjectWeight>>,
    mut report: ResMut<StepReport>,
    mut balance: ResMut<BalanceReport>,
    mut next: ResMut<NextPhase>,
    mut timings: ResMut<Timings>,
) {
    let clock = Instant::now();
    if let (Phase::Ramp { frame }, None) = (&*phase, &command) {
        let after = prediction.frames.partition_point(|answered| answered < frame);
        match prediction.frames.get(after) {
            Some(answered) if answered == frame => {}
            Some(later) => return next.request(Phase::Ramp { frame: *later }),
            None => {
                let why = prediction.predictor.card.range.forces_outside(&shared.0).unwrap_or_default();
                return next
                    .request(Phase::Fault { reason: format!("the network was not trained for this load: {why}") });
            }
        }
        if after == 0 && prediction.ahead.is_none() {
            // If one of the loads cannot be predicted, the loads before it are predicted one by one below.
            let _ = prediction.predict_all_loads();
        }
    }
    let Prediction { predictor, grasp, ahead, interpolation, frames, .. } = &mut *prediction;
    let push = shared.0.push.as_ref().map(|push| push.fraction_of(load.push)).unwrap_or_default();
    let applied = GraspLoad { force: load.level, push };
    let asked = match grasp {
        Some((_, seen)) if command.is_none() => {
            let Phase::Ramp { frame } = *phase else { return };
            let known = ahead.as_ref().zip(frames.binary_search(&frame).ok()).and_then(|(ramp, load)| ramp.at(load));
            known.map_or_else(|| predictor.at(seen, applied), Ok)
        }
        Some((_, seen)) => {
            let push = weight.map(|weight| weight.0).filter(|_| predictor.supports_pushes()).unwrap_or_default();
            let known = interpolation
                .get_or_init(|| {
                    ForceInterpolation::new(predictor, seen, shared.0.levels[0], *shared.0.levels.last()?).ok()
                })
                .as_ref()
                .and_then(|interpolation| interpolation.at(load.level, push));
            let push = Wrench { force: push, ..Wrench::ZERO };
            known.map_or_else(|| predictor.at(seen, GraspLoad { force: load.level, push }), Ok)
        }
        None => Err(Error::Start("the load rises before first contact".into())),
    };
    match asked {
        Ok(state) => {
            // No slip check for an agent: its reward measures what it holds.
            let scene = grasp.as_ref().filter(|_| command.is_none());
            let margin = |touch| predictor.friction_margin(&shared.0, touch, &state, &applied);
            let slips = scene.and_then(|(touch, _)| slip_reason(&margin(touch)));
            if let Some(reason) = slips {
                next.request(Phase::Dropped { reason });
            } else {
                (report.reached, report.iterations, report.error) = (true, 1, Some(state.error));
                balance.object_fixed = state.held;
                prediction.state = Some(state);
                timings.iterations += 1;
            }
        }
        Err(error) => next.request(Phase::Fault { reason: error.to_string() }),
    }
    *timings.stages.entry("decode").or_insert(0.0) += clock.elapsed().as_secs_f64();
}

/// Distributes a load on the object evenly over the pads, and over the nodes of a pad in proportion to the pressure,
/// for a network trained without pushes.
fn distribute_load(mut prediction: ResMut<Prediction>, shared: Res<SharedModel>, weight: Single<&ObjectWeight>) {
    if prediction.predictor.supports_pushes() {
        return;
    }
    let model = &shared.0;
    let each = weight.0 / model.fingers.len() as f64;
    for (pad, finger) in prediction.pads_mut().iter_mut().zip(&model.fingers) {
        let own = finger.placement.rotation.transpose() * each;
        // Contact presses against the outward axis of the pad.
        let whole: f64 = pad.contact.iter().map(|f| -f.z).sum();
        pad.contact.iter_mut().for_each(|f| *f += own * (-f.z / whole));
    }
}

/// Copies the prediction to the columns: positions, travel, pose, wrench.
fn write_state(
    prediction: Res<Prediction>,
    shared: Res<SharedModel>,
    report: Res<StepReport>,
    mut nodes: Query<(&FingerIndex, &RestPosition, &mut Position)>,
    mut fingers: Query<(&FingerIndex, &FirstContact, &mut FingerTravel, &mut FingerWrench)>,
    mut pose: Single<&mut ObjectPose>,
) {
    let (Some((touch, _)), true) = (&prediction.grasp, report.reached) else { return };
    let (model, pads) = (&shared.0, prediction.pads());
    let axes = |finger: usize| model.fingers[finger].placement.rotation;
    for (finger, rest, mut position) in nodes.contiguous_iter_mut().expect(TABLES) {
        let position = position.bypass_change_detection();
        for (f, rows) in rows_by_pad(finger) {
            let moved = rest[rows.clone()].iter().zip(&pads[f].displacement);
            position[rows].iter_mut().zip(moved).for_each(|(x, (rest, u))| x.0 = rest.0 + axes(f) * *u);
        }
    }
    for (finger, first, mut travel, mut wrench) in &mut fingers {
        let (pad, rest) = (&pads[finger.0 as usize], &model.fingers[finger.0 as usize].topology.rest);
        travel.0 = first.0 + pad.travel;
        let force: DVec3 = pad.contact.iter().sum();
        let arms = rest.iter().zip(&pad.displacement).map(|(x, u)| *x + *u);
        let torque: DVec3 = arms.zip(&pad.contact).map(|(x, f)| x.cross(*f)).sum();
        wrench.0 = Wrench { force, torque }.rotated(|v| axes(finger.0 as usize) * v);
    }
    if model.free {
        pose.0 = object_pose(model, touch, pads);
    }
}

/// Lower bound of the search radius of the distance query, m. Once a node is inside, only nodes this close can have the
/// smallest gap.
const SMALLEST_SEARCH_RADIUS: f64 = 1e-9;

/// Measures the uncorrected prediction: the smallest det F, and the smallest gap of a face node, which may be negative.
fn measure_shape(
    prediction: Res<Prediction>,
    shared: Res<SharedModel>,
    mut report: ResMut<StepReport>,
    nodes: Query<(&FingerIndex, &Position)>,
    fingers: Query<(&FingerIndex, &ClosingDirection, &FingerTravel)>,
    object: Single<&ObjectPose>,
) {
    let model = &shared.0;
    let mut x: Vec<Vec<DVec3>> = vec![Vec::new(); model.fingers.len()];
    for (finger, position) in nodes.contiguous_iter().expect(TABLES) {
        rows_by_pad(finger).for_each(|(f, rows)| x[f] = position[rows].iter().map(|x| x.0).collect());
    }
    let inverse = object.0.rotation.inverse();
    let carried: Vec<(usize, DVec3)> = fingers.iter().map(|(f, c, t)| (f.0 as usize, c.0 * t.0)).collect();
    let worst = |(finger, carried): &(usize, DVec3)| {
        let own = &x[*finger];
        let gap = prediction.face.iter().fold(f64::INFINITY, |least, node| {
            let at = inverse * (own[*node as usize] + *carried - object.0.position);
            // Nodes farther away than the smallest gap so far need no distance.
            let closer = model.object.distance.closest(at, least.max(SMALLEST_SEARCH_RADIUS));
            closer.map_or(least, |c| least.min(c.distance))
        });
        (model.fingers[*finger].body.min_det_f(own), gap)
    };
    let least = |a: (f64, f64), b: (f64, f64)| (a.0.min(b.0), a.1.min(b.1));
    let least = carried.par_iter().map(worst).reduce(|| (f64::INFINITY, f64::INFINITY), least);
    (report.min_det_f, report.min_gap) = least;
}

/// Writes von Mises stress on nodes; that of a tetrahedron is the mean of its nodes.
fn write_stress(
    prediction: Res<Prediction>,
    shared: Res<SharedModel>,
    mut nodes: Query<(&FingerIndex, &mut NodalStress)>,
    mut tets: Query<(&FingerIndex, &mut TetStress)>,
) {
    for (finger, mut column) in nodes.contiguous_iter_mut().expect(TABLES) {
        let column = column.bypass_change_detection();
        for (f, rows) in rows_by_pad(finger) {
            column[rows].iter_mut().zip(&prediction.pads()[f].stress).for_each(|(stress, s)| stress.0 = *s);
        }
    }
    for (finger, mut column) in tets.contiguous_iter_mut().expect(TABLES) {
        let column = column.bypass_change_detection();
        for (f, rows) in rows_by_pad(finger) {
            let elements = &shared.0.fingers[f].topology.elements;
            let width = elements.width();
            for (stress, own) in column[rows].iter_mut().zip(elements.nodes().chunks_exact(width)) {
                let sum: f64 = own.iter().map(|n| prediction.pads()[f].stress[*n as usize]).sum();
                stress.0 = sum / width as f64;
            }
        }
    }
}

/// Writes contact forces on nodes, in the hand frame.
fn write_contact(
    prediction: Res<Prediction>,
    shared: Res<SharedModel>,
    mut nodes: Query<(&FingerIndex, &mut ContactForce)>,
) {
    for (finger, mut column) in nodes.contiguous_iter_mut().expect(TABLES) {
        let column = column.bypass_change_detection();
        for (f, rows) in rows_by_pad(finger) {
            let axes = shared.0.fingers[f].placement.rotation;
            column[rows].iter_mut().zip(&prediction.pads()[f].contact).for_each(|(force, c)| force.0 = axes * *c);
        }
    }
}
