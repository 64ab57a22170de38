//! Expected processor time of grasps, before they are computed.
//!
//! ```text
//! a run             START + grasps x (time of a grasp)
//! finite elements   iterations x ITERATION (N / 1e4)^POWER, the part CONDENSED of it with condensed pads
//!   iterations      PATH + FRAME x frames       friction: the path decides on the increments
//!                   FRICTIONLESS_FRAME x frames              no friction: an increment for each frame
//!                   STEP x steps                motion in time
//! network           LOAD x loads x nodes / 1e3
//! ```
//!
//! N is the number of unknowns of the full pads. The times agree with those of the table "Speed against error" of
//! `docs/results.md` (756 to 17,400 unknowns, full, condensed and a network) to within a factor of three, and with
//! those of the ten objects there except the cuboid. The numbers of iterations are in the middle of those that it lists
//! for the hard cases, which `tests/scenes/expected_effort.rs` checks: a face that is pressed flat takes a third, a
//! rolling object three times as many, and an object at the limit of stability more than that.

use model::Model;
use scene::{Fem, Scene, Solver, StepperChoice};
use serde::Serialize;

/// Factor within which seven of eight measured times agree with the expected one.
pub const EXPECTED_TIME_FACTOR: u32 = 3;

/// Time to start the program and to mesh, s.
const START: f64 = 0.03;
/// Time of a Newton iteration with 10,000 unknowns, s, rejected increments included.
const ITERATION: f64 = 0.1;
/// Exponent of the number of unknowns.
const POWER: f64 = 1.2;
/// Fraction of that time that a grasp with condensed pads takes.
const CONDENSED: f64 = 0.65;
/// Base number of iterations of a grasp with friction.
const PATH: f64 = 32.0;
/// Additional iterations of such a grasp per frame.
const FRAME: f64 = 2.0;
/// Iterations per frame without friction.
const FRICTIONLESS_FRAME: f64 = 10.0;
/// Iterations per time step.
const STEP: f64 = 2.3;
/// Time of a network per load and 1,000 nodes, s.
const LOAD: f64 = 2e-3;

/// Expected time of the grasps of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ExpectedTime {
    /// Newton iterations of one grasp; 0 for a network.
    pub iterations: f64,
    /// Processor time of one grasp, s.
    pub grasp_s: f64,
    /// Processor time of all grasps, s.
    pub processor_s: f64,
    /// Wall time of all grasps on the threads of this machine, s.
    pub wall_s: f64,
}

impl ExpectedTime {
    /// Returns the expected time of `grasps` grasps of `scene`, whose model is `model`, on this number of threads.
    pub fn of(scene: &Scene, model: &Model, grasps: usize, threads: usize) -> Self {
        let (iterations, grasp_s) = match &scene.stepper {
            StepperChoice::Fem(fem) => {
                let iterations = iterations(fem, model);
                let part = if matches!(fem.solver, Solver::Condensed(_)) { CONDENSED } else { 1.0 };
                let each = part * ITERATION * (model.unknowns().total as f64 / 1e4).powf(POWER);
                (iterations, iterations * each)
            }
            StepperChoice::Gnn(_) => {
                let nodes: usize = model.fingers.iter().map(|finger| finger.body.rest.len()).sum();
                (0.0, LOAD * model.levels.len() as f64 * nodes as f64 / 1e3)
            }
        };
        let at_once = threads.min(grasps).max(1) as f64;
        let all = grasp_s * grasps as f64;
        Self { iterations, grasp_s, processor_s: START + all, wall_s: START + all / at_once }
    }
}

/// Returns the expected number of Newton iterations of a grasp by finite elements.
fn iterations(fem: &Fem, model: &Model) -> f64 {
    let frames = model.levels.len() as f64;
    let iterations = match (steps(model), model.path_error) {
        (Some(steps), _) => STEP * steps,
        (None, Some(_)) => PATH + FRAME * frames,
        (None, None) => FRICTIONLESS_FRAME * frames,
    };
    fem.effort.map_or(iterations, |most| iterations.min(most.get() as f64))
}

/// Returns the number of time steps of a grasp, at least one per frame; None for a quasi-static scene.
pub fn steps(model: &Model) -> Option<f64> {
    let end = model.levels.last().copied().unwrap_or(0.0);
    model.dynamics.as_ref().map(|dynamics| (end / dynamics.time_step).ceil().max(model.levels.len() as f64))
}
