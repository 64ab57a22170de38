//! Expected processor time of grasps, before they are computed.
//!
//! ```text
//! a run             START + grasps x (time of a grasp)
//! finite elements   iterations x ITERATION (N / 1e4)^POWER, the part CONDENSED of it with condensed pads
//!   iterations      PATH + FRAME x frames       friction: the path decides on the increments
//!                   ALONE x frames              no friction: an increment for each frame
//!                   STEP x steps                motion in time
//! network           LOAD x loads x nodes / 1e3
//! ```
//!
//! with the unknowns N of the whole pads. The times meet those of the table "Speed against error" of `docs/results.md` (756 to 17,400 unknowns,
//! whole, condensed and a network) to within a factor of three, and so those of the ten objects there but for the cuboid. The numbers of
//! iterations are in the middle of those that it lists for the hard cases, to which `tests/scenes/expected_effort.rs` holds them: a face that is
//! pressed flat takes a third, an object that rolls three times as many, and what stands on the edge of moving more than that.

use crate::model::Model;
use crate::scene::{Fem, Scene, Solver, StepperChoice};
use serde::Serialize;

/// Factor within which seven of eight measured times lie about the expected one.
pub const EXPECTED_WITHIN: u32 = 3;

/// Time in which the program starts and meshes, s.
const START: f64 = 0.03;
/// Time of a Newton iteration with 10,000 unknowns, s, increments that are refused included.
const ITERATION: f64 = 0.1;
/// Power of the unknowns.
const POWER: f64 = 1.2;
/// Part of that time which a grasp with condensed pads takes.
const CONDENSED: f64 = 0.65;
/// Iterations of a grasp with friction.
const PATH: f64 = 32.0;
/// Iterations of such a grasp for each of its frames.
const FRAME: f64 = 2.0;
/// Iterations of a frame without friction.
const ALONE: f64 = 10.0;
/// Iterations of a step in time.
const STEP: f64 = 2.3;
/// Time of a load of a network with 1,000 nodes, s.
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
    /// Returns the time that `grasps` grasps of `scene`, whose model is `model`, are expected to take on this number of threads.
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
        (None, None) => ALONE * frames,
    };
    fem.effort.map_or(iterations, |most| iterations.min(most.get() as f64))
}

/// Returns the number of steps in time of a grasp, at least one to a frame; None if nothing moves in time.
pub fn steps(model: &Model) -> Option<f64> {
    let end = model.levels.last().copied().unwrap_or(0.0);
    model.dynamics.as_ref().map(|dynamics| (end / dynamics.time_step).ceil().max(model.levels.len() as f64))
}
