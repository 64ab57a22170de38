//! Answers at loads that are not known beforehand: an agent asks for one after the other.
//!
//! Several loads side by side cost the network little more than one. So a grasp is answered once at a ladder of forces, and answers
//! between two rungs are interpolated linearly: contact forces still sum to the pressing force of the finger. Where the network was trained
//! for pushes, each rung also has the answers to a push along each of two directions across the fingers, and other pushes are combinations of
//! these: contact forces still balance them.

use super::answer::{Answer, mixed};
use super::predict::{GraspState, Predictor, Seen};
use crate::error::Result;
use crate::linear::{GraspLoad, around};
use glam::DVec3;

/// Number of rungs; neighbours differ by a third of their force where the largest force of an agent is seven times the smallest.
const RUNGS: i32 = 8;
/// Push of a rung over what friction holds.
const PUSH: f64 = 0.4;

/// States of the pads of a grasp at rising forces per finger, N.
#[derive(Debug)]
pub struct ForceLadder {
    /// Forces, with the number of their first level.
    rungs: Vec<(f64, usize)>,
    /// Directions of the pushes, hand frame; empty for a network that knows none.
    directions: Vec<DVec3>,
    /// Push over the force per finger.
    push: f64,
    answer: Answer,
}

impl ForceLadder {
    /// Creates the ladder from the force `low` to `high`, N per finger.
    ///
    /// # Errors
    /// Fails if predicted numbers are not finite.
    pub fn new(predictor: &Predictor, seen: &Seen, low: f64, high: f64) -> Result<Self> {
        let model = seen.model();
        let pushed = predictor.knows_pushes() && model.free && model.law.friction > 0.0;
        let axes = model.fingers.first().map(|finger| finger.placement.rotation);
        let directions: Vec<DVec3> =
            axes.filter(|_| pushed).iter().flat_map(|axes| [axes.x_axis, axes.y_axis]).collect();
        let push = PUSH * model.law.friction * model.fingers.len() as f64;
        let step = (high / low).powf(1.0 / f64::from(RUNGS - 1));
        let forces: Vec<f64> = (0..RUNGS).map(|k| low * step.powi(k)).collect();
        let levels = |force: &f64| {
            let pushes = std::iter::once(DVec3::ZERO).chain(directions.iter().map(|along| *along * (push * force)));
            pushes.map(|push| GraspLoad { force: *force, push: [push, DVec3::ZERO] }).collect::<Vec<_>>()
        };
        let loads: Vec<GraspLoad> = forces.iter().flat_map(levels).collect();
        let answer = predictor.answer(seen, &loads)?;
        let rungs = forces.into_iter().zip((0..).step_by(1 + directions.len())).collect();
        Ok(Self { rungs, directions, push, answer })
    }

    /// Returns true if it answers pushes.
    pub fn knows_pushes(&self) -> bool {
        !self.directions.is_empty()
    }

    /// Returns the states of the pads at `force` per finger, N, with a `push` on the object, N, hand frame; None beyond the ladder.
    pub fn at(&self, force: f64, push: DVec3) -> Option<GraspState> {
        let (before, after, part) = around(&self.rungs, force)?;
        let along: Vec<f64> = self.directions.iter().map(|d| d.dot(push) / (self.push * force)).collect();
        let whole: f64 = along.iter().sum();
        let mut levels = Vec::with_capacity(2 * (1 + along.len()));
        for (rung, part) in [(*before, 1.0 - part), (*after, part)] {
            levels.push((rung, part * (1.0 - whole)));
            levels.extend(
                along.iter().zip(rung + 1..).filter(|(by, _)| **by != 0.0).map(|(by, level)| (level, part * by)),
            );
        }
        let parts: Vec<_> = levels.into_iter().map(|(level, part)| (&self.answer, level, part)).collect();
        Some(mixed(&parts))
    }
}
