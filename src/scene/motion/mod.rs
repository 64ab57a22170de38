//! Motions of the hand in a dynamic scene, executed one after the other: one file per motion.
//!
//! To add a motion, write one file with a struct that implements [`Play`] and one line in `motions!`.

mod close;
mod hold;
mod lift;
mod repeat;
mod rotate;
mod shake;
mod shift;

pub use close::Close;
pub use hold::Hold;
pub use lift::Lift;
pub use repeat::Repeat;
pub use rotate::Rotate;
pub use shake::Shake;
pub use shift::Move;

use geometry::Pose;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Pose and squeezing force of the hand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HandState {
    /// Pose of the hand in the world.
    pub pose: Pose,
    /// Sum of the closing forces of the fingers, N.
    pub force: f64,
}

impl HandState {
    /// Returns this state with the hand displaced by `by` (m, world frame).
    fn displaced(&self, by: DVec3) -> Self {
        Self { pose: Pose { position: self.pose.position + by, ..self.pose }, ..*self }
    }
}

/// Properties of the scene that a motion needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stage {
    /// Unit vector against gravity, world; zero without gravity.
    pub up: DVec3,
    /// Point midway between the pads, hand frame, m.
    pub center: DVec3,
}

/// Motion of the hand.
pub trait Play {
    /// Returns the duration, s.
    fn duration(&self) -> f64;
    /// Returns the state of the hand at `time` (0 to the duration, s) after the start of the motion from `start`.
    fn hand(&self, start: &HandState, time: f64, stage: &Stage) -> HandState;
    /// Adds to `found` the end time (s) and the force (N) of every squeeze of a motion that begins at `begin` (s).
    fn squeezes(&self, _begin: f64, _found: &mut Vec<(f64, f64)>) {}
    /// Returns true if the direction of the motion is defined by gravity.
    fn needs_gravity(&self) -> bool {
        false
    }
}

/// Declares [`Motion`] with one variant per kind.
macro_rules! motions {
    ($($(#[$doc:meta])* $name:ident,)*) => {
        /// Motion of the hand.
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
        pub enum Motion {
            $($(#[$doc])* $name($name),)*
        }

        impl Motion {
            /// Returns the motion as a trait object.
            pub fn play(&self) -> &dyn Play {
                match self {
                    $(Motion::$name(motion) => motion,)*
                }
            }
        }
    };
}

motions! {
    /// Changes the squeezing force.
    Close,
    /// Moves the hand against gravity.
    Lift,
    /// Moves the hand by a vector.
    Move,
    /// Keeps the hand in place.
    Hold,
    /// Oscillates the hand along a direction.
    Shake,
    /// Rotates the hand about an axis through the point midway between the pads.
    Rotate,
    /// Repeats motions several times.
    Repeat,
}

/// Returns the total duration of motions executed one after the other, s.
pub fn duration(motions: &[Motion]) -> f64 {
    motions.iter().map(|m| m.play().duration()).sum()
}

/// Returns the state of the hand at `time` (s) after the start of `motions` from `start`; after their end, the final
/// state.
pub fn follow(motions: &[Motion], start: &HandState, time: f64, stage: &Stage) -> HandState {
    let (mut hand, mut rest) = (*start, time);
    for motion in motions {
        let motion = motion.play();
        let duration = motion.duration();
        if rest < duration {
            return motion.hand(&hand, rest, stage);
        }
        hand = motion.hand(&hand, duration, stage);
        rest -= duration;
    }
    hand
}

/// Returns the end times (s) and forces (N) of all squeezes.
pub fn squeezes(motions: &[Motion]) -> Vec<(f64, f64)> {
    let (mut found, mut begin) = (Vec::new(), 0.0);
    for motion in motions {
        motion.play().squeezes(begin, &mut found);
        begin += motion.play().duration();
    }
    found
}

/// Rises from 0 to 1 with zero velocity and acceleration at both ends (minimum jerk: Flash & Hogan 1985, equation 2).
fn smooth(s: f64) -> f64 {
    let s = s.clamp(0.0, 1.0);
    s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
}
