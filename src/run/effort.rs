//! Expected time of grasps, before they are computed.
//!
//! The path of the load decides on the number of increments, not the number of frames, so that unknowns tell most. The law was fitted to one
//! grasp on one thread (AMD EPYC) of 25 shipped scenes with 763 to 10,591 unknowns and 1 to 50 frames. Of those, 20 lie within a factor
//! of three; flat faces take less, and objects that roll, thin pads and needles up to five times as much.

use crate::model::Model;
use crate::scene::{Fem, Scene, Solver, StepperChoice};

/// Factor within which four of five measured times lie about the expected one.
pub const EXPECTED_WITHIN: u32 = 3;
/// Time of a grasp with [`UNKNOWNS`] unknowns, s.
const SECONDS: f64 = 2.6;
const UNKNOWNS: f64 = 8500.0;
/// Power of the unknowns.
const POWER: f64 = 1.4;
/// Time of a grasp with condensed pads over that with whole ones.
const CONDENSED: f64 = 0.3;

/// Returns the wall time that `grasps` grasps of `scene` are expected to take on this number of threads, s; None for a network, which has no
/// increments, and for motion in time, whose steps depend on impacts.
pub fn expected_seconds(scene: &Scene, model: &Model, grasps: usize, threads: usize) -> Option<f64> {
    let StepperChoice::Fem(Fem { solver, .. }) = &scene.stepper else { return None };
    if model.dynamics.is_some() {
        return None;
    }
    let part = if matches!(solver, Solver::Condensed(_)) { CONDENSED } else { 1.0 };
    let each = part * SECONDS * (model.unknowns().total as f64 / UNKNOWNS).powf(POWER);
    Some(each * grasps as f64 / threads.min(grasps).max(1) as f64)
}
