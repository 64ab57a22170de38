//! Loads on the object: its weight, once the support is removed, and pushes.

use base::random::Random;
use glam::{DQuat, DVec3};
use scene::Task;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// Push on the object, hand frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Push {
    /// First step of the push, from 1.
    pub begin: usize,
    /// Duration, steps.
    pub lasts: usize,
    /// Peak force, N, perpendicular to the closing direction.
    pub force: DVec3,
}

impl Push {
    /// Returns the force at step `step`, N: a half-sine pulse, positive in the first and the last of its steps.
    pub fn at(&self, step: usize) -> DVec3 {
        let on = (self.begin..self.begin + self.lasts).contains(&step);
        let part = (step + 1).saturating_sub(self.begin) as f64 / (self.lasts + 1) as f64;
        if on { self.force * (PI * part).sin() } else { DVec3::ZERO }
    }
}

/// Draws the pushes of an episode.
pub fn pushes(task: &Task, random: &mut Random) -> Vec<Push> {
    let Some(wanted) = task.pushes else { return Vec::new() };
    let first = task.lift.get() + 1;
    let push = |begin: usize| {
        let (size, angle) = (wanted.force.interpolate(random.uniform()), TAU * random.uniform());
        Push { begin, lasts: wanted.lasts.get(), force: DVec3::new(0.0, angle.cos(), angle.sin()) * size }
    };
    (first..=task.steps.get()).step_by(wanted.every.get()).map(push).collect()
}

/// Loads of an episode.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct EpisodeLoads {
    /// Full weight of the object, N, hand frame.
    pub weight: DVec3,
    /// Number of steps over which the weight is ramped up.
    pub lift: usize,
    /// Pushes.
    pub pushes: Vec<Push>,
}

impl EpisodeLoads {
    /// Returns the force on the object's centre of mass at step `step`, N, hand frame, with the hand rotated by `twist`
    /// (rad) about the closing direction. The component along the closing direction is zero, because the fingers are
    /// mechanically coupled and support it.
    pub fn at(&self, step: usize, twist: f64) -> DVec3 {
        let part = (step as f64 / self.lift as f64).min(1.0);
        let weight = DQuat::from_rotation_x(-twist) * self.weight * part;
        let sum = self.pushes.iter().map(|push| push.at(step)).sum::<DVec3>() + weight;
        DVec3 { x: 0.0, ..sum }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weight_comes_on_and_pushes_come_and_go() {
        let push = Push { begin: 4, lasts: 3, force: DVec3::Y };
        let loads = EpisodeLoads { weight: DVec3::new(5.0, 0.0, -2.0), lift: 2, pushes: vec![push] };
        assert_eq!(loads.at(0, 0.0), DVec3::ZERO);
        assert_eq!(
            loads.at(1, 0.0),
            DVec3::new(0.0, 0.0, -1.0),
            "half the weight, nothing along the closing direction"
        );
        assert!((loads.at(5, 0.0) - DVec3::new(0.0, 1.0, -2.0)).length() < 1e-12, "the push is at its height");
        assert_eq!(loads.at(7, 0.0), DVec3::new(0.0, 0.0, -2.0));
        assert!((loads.at(3, PI) - DVec3::new(0.0, 0.0, 2.0)).length() < 1e-12, "the hand is upside down");
    }
}
