//! Single environment: a world, its episode and its last output.

use super::action::{self, Action};
use super::draw::{EpisodeKey, EpisodeParameters};
use super::load::EpisodeLoads;
use super::picture::picture;
use super::reward::StepInfo;
use super::shared::EnvShared;
use super::slip;
use super::snapshot::Snapshot;
use base::error::{self, Error};
use base::saved_state::{StateReader, StateWriter};
use geometry::Pose;
use glam::DVec3;
use model::Model;
use model::sensors::SensorInput;
use record::Frame;
use record::render::Pixmap;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use world::components::ObjectWeight;
use world::environment::Environment;
use world::schedule::{EarlyTermination, ForceCommand, Phase};

/// Maximum number of attempts to find a feasible start of an episode.
const MAX_ATTEMPTS: u64 = 8;

/// Last output of an environment.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct StepOutput {
    /// All observations, concatenated.
    pub obs: Vec<f32>,
    /// Final observations of an episode that ended in a step that also started the next one; otherwise empty.
    pub last: Vec<f32>,
    pub reward: f32,
    pub terminated: bool,
    pub truncated: bool,
    pub fault: Option<String>,
    pub info: StepInfo,
}

/// Environment of a batch.
pub struct Env {
    pub key: EpisodeKey,
    pub output: StepOutput,
    /// True if the environment requires a reset.
    pub ended: bool,
    run: Option<RunningEpisode>,
}

/// Running episode: the world with the grasped object.
struct RunningEpisode {
    environment: Environment,
    frame: Frame,
    draw: EpisodeParameters,
    loads: EpisodeLoads,
    force: f64,
    twist: f64,
    step: usize,
    slipped: f64,
}

impl Env {
    /// Creates an environment before its first episode.
    pub fn new(key: EpisodeKey) -> Self {
        Self { key, output: StepOutput::default(), ended: true, run: None }
    }

    /// Returns the world of the running episode, if any.
    pub fn environment(&mut self) -> Option<&mut Environment> {
        self.run.as_mut().map(|run| &mut run.environment)
    }

    /// Returns the drawn parameters of the running episode, if any.
    pub fn draw(&self) -> Option<&EpisodeParameters> {
        self.run.as_ref().map(|run| &run.draw)
    }

    /// Saves the state of the episode.
    ///
    /// # Errors
    /// Fails if the state cannot be serialised.
    pub fn save(&self, shared: &EnvShared) -> error::Result<Snapshot> {
        let mut history = StateWriter::default();
        history.write(&(self.ended, &self.output, self.run.is_some()));
        self.run.iter().for_each(|run| run.save_state(shared, &mut history));
        Ok(Snapshot::new(&shared.identity, self.key, history.finish()?))
    }

    /// Discards the episode; the next reset starts it again.
    pub fn discard_episode(&mut self) {
        *self = Self::new(self.key);
    }

    /// Renders the running episode.
    ///
    /// # Errors
    /// Fails if no episode is running, or if its state cannot be drawn.
    pub fn picture(&self, shared: &EnvShared) -> base::error::Result<Pixmap> {
        let none = || Error::Start("there is no episode to draw; reset the environment".into());
        let run = self.run.as_ref().ok_or_else(none)?;
        let title = format!("{}, step {}", shared.kinds[run.draw.object].name, run.step);
        picture(run.model(shared), &run.frame, title)
    }

    /// Restores the state of a snapshot, which must have passed [`Snapshot::check`] for this scene.
    ///
    /// # Errors
    /// Fails if the state cannot be read; the environment is then unchanged.
    pub fn restore(&mut self, shared: &EnvShared, snapshot: &Snapshot) -> error::Result<()> {
        let mut history = StateReader(&snapshot.state);
        let (ended, output, running) = history.read()?;
        let run = if running { Some(RunningEpisode::restore_state(shared, &mut history)?) } else { None };
        let before = std::mem::replace(self, Self { key: snapshot.key, output, ended, run });
        before.run.into_iter().for_each(|run| shared.recycle(run.environment));
        Ok(())
    }

    /// Starts the episode `key`; if no attempt is feasible, the output contains the fault.
    pub fn begin(&mut self, shared: &EnvShared, key: EpisodeKey) {
        (self.key, self.ended) = (key, false);
        if let Some(run) = self.run.take() {
            shared.recycle(run.environment);
        }
        self.output = StepOutput { obs: vec![0.0; shared.observation_size()], ..StepOutput::default() };
        for attempt in 0..MAX_ATTEMPTS {
            match RunningEpisode::new(shared, shared.draw(&key, attempt)) {
                Ok(run) => {
                    self.output.fault = None;
                    observe(shared, run.model(shared), &run.frame, &mut self.output.obs);
                    self.run = Some(run);
                    return;
                }
                Err(stop) => self.output.fault = Some(format!("no feasible start: {}", stop.reason)),
            }
        }
    }

    /// Starts the next episode if this one has ended, keeping its last observation, reward and flags in the output.
    pub fn autoreset(&mut self, shared: &EnvShared) {
        if !self.ended {
            return;
        }
        let done = std::mem::take(&mut self.output);
        self.begin(shared, self.key.next());
        let fault = done.fault.clone().or_else(|| self.output.fault.take());
        self.output = StepOutput { obs: std::mem::take(&mut self.output.obs), last: done.obs.clone(), fault, ..done };
    }

    /// Takes one step of the episode.
    pub fn advance(&mut self, shared: &EnvShared, numbers: &[f32]) {
        let Some(run) = &mut self.run else {
            // The fault of the reset states the reason.
            let info = StepInfo { max_force: shared.task.force.interpolate(1.0), ..StepInfo::default() };
            (self.ended, self.output.terminated, self.output.info) = (true, true, info);
            self.output.reward = shared.reward(&info) as f32;
            return;
        };
        let output = &mut self.output;
        output.last.clear();
        output.fault = None;
        let done = run.advance(shared, numbers);
        let mut info = done.unwrap_or_else(|stop| {
            // Dropping the object is an outcome, not a fault.
            output.fault = (!stop.dropped).then_some(stop.reason);
            StepInfo::default()
        });
        let mut seen = vec![0.0; output.obs.len()];
        observe(shared, run.model(shared), &run.frame, &mut seen);
        if seen.iter().all(|v| v.is_finite()) {
            output.obs = seen;
        } else {
            output.fault = Some("the state is not finite".into());
            info = StepInfo::default();
        }
        (info.force, info.max_force) = (run.force, shared.task.force.interpolate(1.0));
        output.reward = shared.reward(&info) as f32;
        // A task with regrasping continues after a failed grasp.
        output.terminated = !info.held && shared.task.regrasp.is_none();
        output.truncated = !output.terminated && run.step >= shared.steps;
        output.info = info;
        self.ended = output.terminated || output.truncated;
    }
}

impl RunningEpisode {
    /// Closes the hand on the object of the draw, which rests on its support.
    fn new(shared: &EnvShared, draw: EpisodeParameters) -> Result<Self, EarlyTermination> {
        let force = shared.task.start.get();
        let (environment, frame) = start_grasp(shared, &shared.variant(&draw).model, draw.pose, force)?;
        let weight = shared.weight(&draw, &draw.pose);
        let loads = EpisodeLoads { weight, lift: shared.task.lift.get(), pushes: draw.pushes.clone() };
        Ok(Self { environment, frame, draw, loads, force, twist: 0.0, step: 0, slipped: 0.0 })
    }

    fn save_state(&self, shared: &EnvShared, history: &mut StateWriter) {
        history.write(&(&self.draw, &self.loads, &self.frame));
        history.write(&(self.force, self.twist, self.step, self.slipped));
        history.write(&self.environment.pose());
        self.environment.save_state(shared.stepper.as_ref(), history);
    }

    fn restore_state(shared: &EnvShared, history: &mut StateReader) -> error::Result<Self> {
        let (draw, loads, frame): (EpisodeParameters, EpisodeLoads, Frame) = history.read()?;
        let (force, twist, step, slipped) = history.read()?;
        let mut environment = shared.environment(&shared.variant(&draw).model, history.read()?)?;
        environment.restore_state(shared.stepper.as_ref(), history)?;
        Ok(Self { environment, frame, draw, loads, force, twist, step, slipped })
    }

    fn model<'a>(&self, shared: &'a EnvShared) -> &'a Arc<Model> {
        &shared.variant(&self.draw).model
    }

    /// Takes one step; on failure, `frame` remains that of the last accepted state.
    fn advance(&mut self, shared: &EnvShared, numbers: &[f32]) -> Result<StepInfo, EarlyTermination> {
        self.step += 1;
        let Action { force, twist, regrasp } = action::decode(&shared.task, numbers, self.force, self.twist);
        (self.force, self.twist) = (force, twist);
        let model = self.model(shared).clone();
        if let Some(other) = regrasp {
            let pose = action::regrasp_pose(&self.draw.pose, shared.center(), other);
            self.loads.weight = shared.weight(&self.draw, &pose);
            let (environment, frame) = start_grasp(shared, &model, pose, force)?;
            shared.recycle(std::mem::replace(&mut self.environment, environment));
            self.frame = frame;
            self.slipped = 0.0;
        }
        // A new grasp carries the full weight immediately.
        let step = if regrasp.is_some() { self.step.max(self.loads.lift) } else { self.step };
        let load = self.loads.at(step, twist);
        let frame = advance_world(&mut self.environment, &model, force, load)?;
        let slip = slip::slip(&model, &self.frame, &frame);
        self.slipped += slip;
        let margin = slip::margin(&model, shared.variant(&self.draw).friction, &frame, load);
        let carried = shared.stepper.solves_friction() || margin >= 0.0;
        let stress = frame.pads.iter().flat_map(|p| &p.von_mises_node).copied().fold(0.0, f64::max);
        self.frame = frame;
        Ok(StepInfo {
            held: carried && self.slipped <= shared.task.slip_limit.get(),
            slip,
            accumulated_slip: self.slipped,
            margin,
            stress,
            force,
            load: load.length(),
            ..StepInfo::default()
        })
    }
}

impl EpisodeKey {
    /// Returns the key of the next episode of the same environment.
    pub fn next(self) -> Self {
        Self { episode: self.episode + 1, ..self }
    }
}

/// Creates a world and closes its hand at `pose` with `force` (N, sum over the fingers).
fn start_grasp(
    shared: &EnvShared,
    model: &Arc<Model>,
    pose: Pose,
    force: f64,
) -> Result<(Environment, Frame), EarlyTermination> {
    let mut environment = shared.environment(model, pose).map_err(|e| EarlyTermination::fault(e.to_string()))?;
    match close_hand(&mut environment, model, force) {
        Ok(frame) => Ok((environment, frame)),
        Err(stop) => {
            shared.recycle(environment);
            Err(stop)
        }
    }
}

/// Closes the hand of a new world with `force` (N, sum over the fingers).
fn close_hand(environment: &mut Environment, model: &Model, force: f64) -> Result<Frame, EarlyTermination> {
    environment.world_mut().insert_resource(ForceCommand { force: 0.0 });
    loop {
        match environment.phase() {
            Phase::Ramp { .. } => return advance_world(environment, model, force, DVec3::ZERO),
            Phase::Dropped { reason } => return Err(EarlyTermination { dropped: true, reason }),
            Phase::Infeasible { reason } | Phase::Fault { reason } => return Err(EarlyTermination::fault(reason)),
            Phase::Done => return Err(EarlyTermination::fault("the grasp ended before its first step")),
            Phase::Place | Phase::Close => environment.step(),
        };
    }
}

/// Takes one step of the world under `force` (N, sum over the fingers) and `load` on the object (N, hand frame).
fn advance_world(
    environment: &mut Environment,
    model: &Model,
    force: f64,
    load: DVec3,
) -> Result<Frame, EarlyTermination> {
    let world = environment.world_mut();
    world.insert_resource(ForceCommand { force: force / model.fingers.len() as f64 });
    world.query::<&mut ObjectWeight>().iter_mut(world).for_each(|mut weight| weight.0 = load);
    let phase = environment.step();
    match (phase, environment.take_frame()) {
        (Phase::Dropped { reason }, _) => Err(EarlyTermination { dropped: true, reason }),
        (Phase::Fault { reason } | Phase::Infeasible { reason }, _) => Err(EarlyTermination::fault(reason)),
        (_, Some(frame)) => Ok(frame),
        (other, None) => Err(EarlyTermination::fault(format!("the step ended in {other:?} without a state"))),
    }
}

/// Writes all observations of `frame` to `out`.
fn observe(shared: &EnvShared, model: &Model, frame: &Frame, out: &mut [f32]) {
    let (now, mut rest) = (SensorInput { fingers: &model.fingers, object: &model.object, frame }, out);
    for sense in &shared.sensors {
        let (own, others) = rest.split_at_mut(sense.spec().size());
        sense.write(&now, own);
        rest = others;
    }
}
