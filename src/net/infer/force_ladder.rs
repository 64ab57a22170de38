//! Answers at forces that are not known beforehand: an agent asks for one after the other.
//!
//! Several loads side by side cost the network little more than one. So a grasp is answered once at a ladder of forces, and answers
//! between two rungs are interpolated linearly: contact forces still sum to the pressing force of the finger.

use super::answer::Answer;
use super::predict::{GraspState, Predictor, Seen};
use crate::error::Result;
use crate::linear::{GraspLoad, around};

/// Number of rungs; neighbours differ by a third of their force where the largest force of an agent is seven times the smallest.
const RUNGS: i32 = 8;

/// States of the pads of a grasp at rising forces per finger, N.
#[derive(Debug)]
pub struct ForceLadder {
    /// Forces, with the number of their level.
    rungs: Vec<(f64, usize)>,
    answer: Answer,
}

impl ForceLadder {
    /// Creates the ladder from the force `low` to `high`, N per finger.
    ///
    /// # Errors
    /// Fails if predicted numbers are not finite.
    pub fn new(predictor: &Predictor, seen: &Seen, low: f64, high: f64) -> Result<Self> {
        let step = (high / low).powf(1.0 / f64::from(RUNGS - 1));
        let forces: Vec<f64> = (0..RUNGS).map(|k| low * step.powi(k)).collect();
        let loads: Vec<GraspLoad> = forces.iter().map(|force| (*force).into()).collect();
        let answer = predictor.answer(seen, &loads)?;
        Ok(Self { rungs: forces.into_iter().zip(0..).collect(), answer })
    }

    /// Returns the states of the pads at `force` per finger, N; None beyond the ladder.
    pub fn at(&self, force: f64) -> Option<GraspState> {
        let (before, after, part) = around(&self.rungs, force)?;
        Some(self.answer.mixed(&[(*before, 1.0 - part), (*after, part)]))
    }
}
