//! Execution of the grasps of a scene, several in parallel, with bitwise identical results on any number of threads.

pub mod expected_time;
pub mod grasp_files;
mod motion;
mod options;
pub mod recorder;
pub mod sensitivity;
pub mod writer;

use crate::Stepper;
use crate::environment::Environment;
use crate::schedule::{Phase, Timings};
use crate::systems::inversion::inversion_message;
use base::error::{Error, Result};
use base::interrupt;
use geometry::Pose;
pub use grasp_files::GraspRecorder;
use model::Model;
use model::evaluation::Findings;
use model::evaluation::GraspMeasurements;
use model::limits::free_memory;
pub use options::RecordingOptions;
use record::{Frame, GraspSummary, Status};
pub use recorder::RunRecorder;

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// Receiver of events while grasps run, on the threads that run them. An error ends the run.
pub trait Observer: Sync {
    /// Receives the start of grasp `index`.
    fn begin(&self, _index: usize) -> Result<()> {
        Ok(())
    }
    /// Receives a frame of grasp `index`.
    fn frame(&self, _index: usize, _frame: &Frame) -> Result<()> {
        Ok(())
    }
    /// Receives the outcome of grasp `index`.
    fn end(&self, _index: usize, _outcome: &Outcome) -> Result<()> {
        Ok(())
    }
}

/// Observer that ignores all events.
impl Observer for () {}

/// Pair of observers that both receive all events.
impl<A: Observer + ?Sized, B: Observer + ?Sized> Observer for (&A, &B) {
    fn begin(&self, index: usize) -> Result<()> {
        self.0.begin(index)?;
        self.1.begin(index)
    }
    fn frame(&self, index: usize, frame: &Frame) -> Result<()> {
        self.0.frame(index, frame)?;
        self.1.frame(index, frame)
    }
    fn end(&self, index: usize, outcome: &Outcome) -> Result<()> {
        self.0.end(index, outcome)?;
        self.1.end(index, outcome)
    }
}

/// Outcome of a grasp.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// Summary for `run.json`.
    pub summary: GraspSummary,
    /// Quantities for the scene's expectations.
    pub measured: GraspMeasurements,
    /// Times of the stages, s: the stages of the stepper; `spawn`, creation of the world; `first_contact`, placing and
    /// closing; `record`, the observer; `other`, the rest.
    pub timings: Timings,
}

/// Runs `grasps` (number and pose of the hand) on `threads` threads; the outcomes are in the order of `grasps`.
///
/// The number of grasps that run in parallel is limited by threads and memory. Each has its own thread pool: a thread
/// that waits for a pad never starts another grasp meanwhile, so the wall time of a grasp is its own. Surplus threads
/// compute pads in parallel.
///
/// # Errors
/// Returns the first error of the observer or of setting up an environment, or [`Error::Interrupted`] if an end was
/// requested before all grasps had run. A grasp that fails is an outcome, not an error.
pub fn run_grasps(
    model: &Arc<Model>,
    stepper: &dyn Stepper,
    grasps: &[(usize, Pose)],
    threads: usize,
    observer: &dyn Observer,
) -> Result<Vec<Outcome>> {
    let workers = threads.clamp(1, grasps.len().max(1)).min(grasps_in_memory(model));
    let (queue, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
    let slots: Vec<Mutex<Option<Result<Outcome>>>> = grasps.iter().map(|_| Mutex::new(None)).collect();
    std::thread::scope(|scope| {
        let spawned: Vec<_> = (0..workers)
            .map(|worker| {
                // 5 threads for 2 grasps: 3 and 2.
                let share = threads / workers + usize::from(worker < threads % workers);
                let (queue, stop, slots) = (&queue, &stop, &slots);
                scope.spawn(move || -> Result<()> {
                    let pool = rayon::ThreadPoolBuilder::new()
                        .num_threads(share.max(1))
                        .build()
                        .map_err(|e| Error::Start(format!("cannot start {share} threads: {e}")))?;
                    loop {
                        let k = queue.fetch_add(1, Ordering::Relaxed);
                        let goes_on = !stop.load(Ordering::Relaxed) && !interrupt::requested();
                        let Some(&(index, pose)) = grasps.get(k).filter(|_| goes_on) else {
                            return Ok(());
                        };
                        let outcome = pool.install(|| run_grasp(model, stepper, index, pose, observer));
                        if outcome.is_err() {
                            stop.store(true, Ordering::Relaxed);
                        }
                        if let Ok(mut slot) = slots[k].lock() {
                            *slot = Some(outcome);
                        }
                    }
                })
            })
            .collect();
        spawned.into_iter().try_for_each(|thread| match thread.join() {
            Ok(result) => result,
            Err(panic) => std::panic::resume_unwind(panic),
        })
    })?;
    let done = slots.into_iter().filter_map(|slot| slot.into_inner().ok().flatten());
    let done: Vec<Outcome> = done.collect::<Result<_>>()?;
    if done.len() < grasps.len() {
        interrupt::check()?;
    }
    Ok(done)
}

/// Returns the number of grasps that fit into free memory at once; at least one.
fn grasps_in_memory(model: &Model) -> usize {
    let most = free_memory().map_or(usize::MAX, |free| (free / model.memory.max(1)) as usize);
    most.max(1)
}

/// Runs one grasp to its end.
///
/// # Errors
/// Fails if the observer fails or the environment cannot be set up; returns [`Error::Interrupted`] if an end was
/// requested.
pub fn run_grasp(
    model: &Arc<Model>,
    stepper: &dyn Stepper,
    index: usize,
    pose: Pose,
    observer: &dyn Observer,
) -> Result<Outcome> {
    let clock = Instant::now();
    observer.begin(index)?;
    let mut environment = Environment::new(model, stepper, pose)?;
    let spawning = clock.elapsed().as_secs_f64();
    let mut tally = Tally::default();
    let (mut closing, mut recording) = (0.0, 0.0);
    let end = loop {
        let (before, started) = (environment.phase(), Instant::now());
        let phase = environment.step();
        if matches!(before, Phase::Place | Phase::Close) {
            closing += started.elapsed().as_secs_f64();
        }
        // An unfinished grasp is discarded: its solver may have stopped only because of the request.
        if phase != Phase::Done {
            interrupt::check()?;
        }
        if let Some(frame) = environment.frame() {
            tally.observe(model, frame, environment.findings());
            let clock = Instant::now();
            observer.frame(index, frame)?;
            recording += clock.elapsed().as_secs_f64();
        }
        if phase.is_final() {
            break phase;
        }
    };
    let wall = clock.elapsed().as_secs_f64();
    let mut timings = environment.timings().clone();
    timings.stages.extend([("spawn", spawning), ("first_contact", closing), ("record", recording)]);
    let accounted: f64 = timings.stages.values().sum();
    timings.stages.insert("other", (wall - accounted).max(0.0));
    let mut outcome = tally.finish(end, timings, wall);
    outcome.summary.grasp = index;
    outcome.summary.handed_over = environment.fallback_reason().map(str::to_string);
    observer.end(index, &outcome)?;
    Ok(outcome)
}

/// Sums and extremes over the frames of a grasp.
#[derive(Default)]
struct Tally {
    measured: Option<GraspMeasurements>,
    summary: Option<GraspSummary>,
    motion: motion::MotionTally,
    /// Fault of the first frame that is physically impossible; not every backend stops there.
    unsound: Option<String>,
}

impl Tally {
    fn observe(&mut self, model: &Model, frame: &Frame, findings: Option<Findings>) {
        let m = self.measured.get_or_insert_with(|| GraspMeasurements {
            force_balance: 0.0,
            torque_balance: 0.0,
            ..GraspMeasurements::default()
        });
        let normal = |i: usize| frame.pads[i].wrench.force.dot(model.fingers[i].placement.closing).abs();
        m.force_n = (0..frame.pads.len()).map(normal).sum();
        for (slot, travel) in m.travel_m.iter_mut().zip(&frame.travel) {
            *slot = *travel;
        }
        m.findings = m.findings.map_or(findings, |old| findings.map(|new| old.merge_worst(new)));
        m.force_balance = m.force_balance.max(frame.force_balance);
        m.torque_balance = m.torque_balance.max(frame.torque_balance);
        let stress = frame.pads.iter().flat_map(|p| &p.von_mises_node).copied().reduce(f64::max);
        m.max_stress_pa = stress.unwrap_or(f64::NAN);
        if let Some(travel) = frame.travel.first() {
            m.curve.push((*travel, normal(0)));
        }
        if let Some(moving) = &frame.moving {
            self.motion.observe(m, model, frame, moving);
        }
        let unsound = findings.is_some_and(|f| !f.is_admissible()) || frame.min_det_f <= 0.0;
        if unsound && self.unsound.is_none() {
            let x: Vec<_> = frame.pads.iter().map(|pad| &pad.position[..]).collect();
            let finite = findings.is_none_or(|f| f.finite);
            let what = if finite { inversion_message(model, &x) } else { "a recorded number is not finite".into() };
            self.unsound = Some(format!("frame {}: {what}", frame.index));
        }
        self.summary.get_or_insert_with(|| GraspSummary::new(Status::Reached, None)).observe(frame);
    }

    fn finish(self, end: Phase, timings: Timings, wall: f64) -> Outcome {
        let (status, reason) = match end {
            Phase::Done => match self.unsound {
                None => (Status::Reached, None),
                Some(reason) => (Status::Fault, Some(reason)),
            },
            Phase::Infeasible { reason } => (Status::Infeasible, Some(reason)),
            Phase::Dropped { reason } => (Status::Dropped, Some(reason)),
            Phase::Fault { reason } => (Status::Fault, Some(reason)),
            other => (Status::Fault, Some(format!("ended in {other:?}, which is not a final phase"))),
        };
        let mut summary = self.summary.unwrap_or_else(|| GraspSummary::new(status, None));
        summary.status = status;
        summary.reason = reason.clone();
        summary.wall_s = wall;
        summary.newton_iterations = timings.iterations;
        summary.methods = timings.methods;
        let mut measured = self.measured.unwrap_or_default();
        measured.status = status;
        measured.reason = reason.unwrap_or_default();
        Outcome { summary, measured, timings }
    }
}
