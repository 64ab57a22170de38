//! Answers at loads that are not known in advance, since an agent requests one at a time.
//!
//! Decoding several loads at once costs little more than decoding one. Therefore a grasp is decoded once at a sequence
//! of forces, and answers between two of these are interpolated linearly, so that contact forces still sum to the
//! pressing force of the finger. If the network was trained with pushes, three of the forces are also decoded with a
//! push along each of two directions across the fingers. The change due to a push is proportional to the push and
//! interpolated linearly between these forces, so that contact forces still balance it.

use super::grasp_output::{GraspOutput, linear_combination};
use super::predict::{EncodedGrasp, Predictor};
use super::predicted_state::GraspState;
use crate::linear_response::{GraspLoad, enclosing_pair};
use base::error::Result;
use geometry::Wrench;
use glam::DVec3;

/// Number of forces; neighbours differ by a third if the largest force of an agent is seven times the smallest.
const FORCES: usize = 8;
/// Indices of the forces decoded with pushes. More of them would hardly reduce the error, which is that of combining
/// pushes linearly.
const PUSHED: [usize; 3] = [0, 4, FORCES - 1];
/// Push over the friction limit.
const PUSH: f64 = 0.4;

/// States of the pads of a grasp at increasing forces per finger, N.
#[derive(Debug)]
pub struct ForceInterpolation {
    /// Forces per finger and their levels.
    levels: Vec<(f64, usize)>,
    /// Forces per finger with pushes, and their levels: without a push, and of the first push.
    pushed: Vec<(f64, [usize; 2])>,
    /// Directions of the pushes, hand frame; empty if the network was trained without pushes.
    directions: Vec<DVec3>,
    /// Push over the force per finger.
    push: f64,
    answer: GraspOutput,
}

impl ForceInterpolation {
    /// Decodes the states from the force `low` to `high`, N per finger.
    ///
    /// # Errors
    /// Fails if predicted numbers are not finite.
    pub fn new(predictor: &Predictor, encoded: &EncodedGrasp, low: f64, high: f64) -> Result<Self> {
        let model = encoded.model();
        let pushes = predictor.supports_pushes() && model.free && model.friction > 0.0;
        let axes = model.fingers.first().map(|finger| finger.placement.rotation);
        let directions: Vec<DVec3> =
            axes.filter(|_| pushes).iter().flat_map(|axes| [axes.x_axis, axes.y_axis]).collect();
        let push = PUSH * model.friction * model.fingers.len() as f64;
        let step = (high / low).powf(1.0 / (FORCES - 1) as f64);
        let levels: Vec<(f64, usize)> = (0..FORCES).map(|k| (low * step.powi(k as i32), k)).collect();
        let mut loads: Vec<GraspLoad> = levels.iter().map(|(force, _)| (*force).into()).collect();
        let mut pushed = Vec::new();
        for (force, level) in PUSHED.iter().map(|rung| &levels[*rung]) {
            pushed.push((*force, [*level, loads.len()]));
            let along = |along: &DVec3| GraspLoad {
                force: *force,
                push: Wrench { force: *along * (push * force), ..Wrench::ZERO },
            };
            loads.extend(directions.iter().map(along));
        }
        let answer = predictor.decode(encoded, &loads)?;
        Ok(Self { levels, pushed, directions, push, answer })
    }

    /// Returns true if pushes are available.
    pub fn supports_pushes(&self) -> bool {
        !self.directions.is_empty()
    }

    /// Returns the states of the pads at `force` per finger, N, with a `push` on the object, N, hand frame; None
    /// outside the range of forces.
    pub fn at(&self, force: f64, push: DVec3) -> Option<GraspState> {
        let (before, after, part) = enclosing_pair(&self.levels, force)?;
        let mut levels = vec![(*before, 1.0 - part), (*after, part)];
        let (before, after, part) = enclosing_pair(&self.pushed, force)?;
        let along: Vec<f64> = self.directions.iter().map(|d| d.dot(push) / (self.push * force)).collect();
        let whole: f64 = along.iter().sum();
        for ([still, first], part) in [(before, 1.0 - part), (after, part)] {
            levels.extend(along.iter().zip(*first..).map(|(by, level)| (level, part * by)));
            levels.push((*still, -part * whole));
        }
        levels.retain(|(_, weight)| *weight != 0.0);
        let parts: Vec<_> = levels.into_iter().map(|(level, part)| (&self.answer, level, part)).collect();
        Some(linear_combination(&parts))
    }
}
