//! Domain randomisation: episode parameters that depend on (seed, environment, episode) alone.

use super::load::{Push, pushes};
use base::random::Random;
use geometry::Pose;
use glam::{DQuat, DVec3};
use scene::Task;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Key of the random numbers of an episode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct EpisodeKey {
    /// Seed of the batch.
    pub seed: u64,
    /// Index of the environment.
    pub env: u64,
    /// Index of the episode of this environment, from 0.
    pub episode: u64,
}

impl EpisodeKey {
    /// Returns the random generator of this episode; `attempt` counts infeasible starts.
    pub fn random(&self, attempt: u64) -> Random {
        let words = [self.seed, self.env, self.episode, attempt];
        Random::new(words.into_iter().fold(0, |state, word| Random::new(state ^ word).next_u64()))
    }
}

/// Randomised parameters of an episode.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EpisodeParameters {
    /// Index of the object.
    pub object: usize,
    /// Index of its variant.
    pub variant: usize,
    /// Pose of the hand in the object frame.
    pub pose: Pose,
    /// Density of the object, kg/m3; None uses that of the scene.
    pub density: Option<f64>,
    /// Pushes, in temporal order.
    pub pushes: Vec<Push>,
}

/// Candidate grasps of each object.
pub type GraspCandidates<'a> = &'a [&'a [Pose]];

/// Draws the parameters of an episode. `center` is the midpoint between the pads, hand frame, m.
pub fn draw(task: &Task, choices: GraspCandidates, center: DVec3, random: &mut Random) -> EpisodeParameters {
    let scatter = &task.randomise;
    let object = random.uniform_below(choices.len());
    let variant = random.uniform_below(scatter.variants.get());
    let pose = choices[object][random.uniform_below(choices[object].len())];
    let shift = DVec3::new(0.0, 2.0 * random.uniform() - 1.0, 2.0 * random.uniform() - 1.0) * scatter.shift.get();
    let turn = direction(random) * (random.uniform() * scatter.turn_deg.get().to_radians());
    let part = random.uniform();
    EpisodeParameters {
        object,
        variant,
        pose: displaced_hand(&pose, center, shift, DQuat::from_scaled_axis(turn)),
        density: scatter.density.map(|span| span.interpolate(part)),
        pushes: pushes(task, random),
    }
}

/// Returns the hand pose `pose`, shifted in hand axes (m) and rotated about `center` (hand frame, m).
pub fn displaced_hand(pose: &Pose, center: DVec3, shift: DVec3, turn: DQuat) -> Pose {
    Pose {
        position: pose.position + pose.rotation * (center + shift - turn * center),
        rotation: (pose.rotation * turn).normalize(),
    }
}

/// Draws a unit vector, uniformly distributed on the sphere.
fn direction(random: &mut Random) -> DVec3 {
    let (z, angle) = (2.0 * random.uniform() - 1.0, TAU * random.uniform());
    let r = (1.0 - z * z).max(0.0).sqrt();
    DVec3::new(r * angle.cos(), r * angle.sin(), z)
}
