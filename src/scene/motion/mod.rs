//! What the hand does in a dynamic scene: one file per motion, played one after the other.
//!
//! To add a motion: one file with a struct that implements [`Play`], one line in `motions!`.

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

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// Where the hand is and how hard it squeezes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HandState {
    /// Origin of the hand frame in the world, m.
    pub position: DVec3,
    /// Rotation from the hand frame to the world.
    pub rotation: DQuat,
    /// Sum of the closing forces of the fingers, N.
    pub force: f64,
}

impl HandState {
    /// A point of the hand frame in the world, m.
    pub fn to_world(&self, x: DVec3) -> DVec3 {
        self.rotation * x + self.position
    }

    /// A point of the world in the hand frame, m.
    pub fn to_hand(&self, x: DVec3) -> DVec3 {
        self.rotation.conjugate() * (x - self.position)
    }
}

/// What a motion needs to know of the scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stage {
    /// Unit vector against gravity, world; zero without gravity.
    pub up: DVec3,
    /// Point midway between the pads, hand frame, m.
    pub center: DVec3,
}

/// A motion of the hand.
pub trait Play {
    /// How long it takes, s.
    fn duration(&self) -> f64;
    /// The hand after `time` (0 to the duration, s) of a motion that began at `start`.
    fn hand(&self, start: &HandState, time: f64, stage: &Stage) -> HandState;
    /// Enters the end (s) and the force (N) of every squeeze of a motion that begins at `begin` (s).
    fn squeezes(&self, _begin: f64, _found: &mut Vec<(f64, f64)>) {}
    /// True if it goes against gravity.
    fn needs_gravity(&self) -> bool {
        false
    }
}

/// Declares [`Motion`] with one variant per kind.
macro_rules! motions {
    ($($(#[$doc:meta])* $name:ident,)*) => {
        /// One motion of the hand.
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
        pub enum Motion {
            $($(#[$doc])* $name($name),)*
        }

        impl Motion {
            /// As the trait object that plays it.
            pub fn play(&self) -> &dyn Play {
                match self {
                    $(Motion::$name(motion) => motion,)*
                }
            }
        }
    };
}

motions! {
    /// Change the squeezing force.
    Close,
    /// Move up, against gravity.
    Lift,
    /// Move by a vector.
    Move,
    /// Do nothing.
    Hold,
    /// Oscillate along a direction.
    Shake,
    /// Turn about an axis through the middle between the pads.
    Rotate,
    /// Play motions several times.
    Repeat,
}

/// Duration of motions one after the other, s.
pub fn duration(motions: &[Motion]) -> f64 {
    motions.iter().map(|m| m.play().duration()).sum()
}

/// The hand `time` (s) after it began to play `motions` at `start`; at their end afterwards.
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

/// Ends (s) and forces (N) of all squeezes.
pub fn squeezes(motions: &[Motion]) -> Vec<(f64, f64)> {
    let (mut found, mut begin) = (Vec::new(), 0.0);
    for motion in motions {
        motion.play().squeezes(begin, &mut found);
        begin += motion.play().duration();
    }
    found
}

/// From 0 to 1 with no velocity and no acceleration at either end (minimum jerk: Flash & Hogan 1985, equation 2).
fn smooth(s: f64) -> f64 {
    let s = s.clamp(0.0, 1.0);
    s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
}
