//! Motions of the hand in a dynamic scene, executed one after the other: one file per motion, except [`Repeat`],
//! which holds motions.
//!
//! To add a motion, write one file with a struct that implements [`MotionProfile`] and one line in `motions!`.

mod close;
mod hold;
mod lift;
mod profile;
mod rotate;
mod shake;
mod shift;

pub use close::Close;
pub use hold::Hold;
pub use lift::Lift;
pub use profile::{HandState, MotionContext, MotionProfile};
pub use rotate::Rotate;
pub use shake::Shake;
pub use shift::Move;

use crate::leaf::Count;
use serde::{Deserialize, Serialize};

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
            pub fn as_profile(&self) -> &dyn MotionProfile {
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

/// Executes a sequence of motions several times.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Repeat {
    /// Number of repetitions.
    pub times: Count<1, 10000>,
    /// Motions to repeat.
    pub motions: Vec<Motion>,
}

impl MotionProfile for Repeat {
    fn duration(&self) -> f64 {
        self.times.get() as f64 * duration(&self.motions)
    }

    fn hand_state(&self, start: &HandState, time: f64, stage: &MotionContext) -> HandState {
        let (mut hand, mut rest, once) = (*start, time, duration(&self.motions));
        for _ in 1..self.times.get() {
            if rest < once {
                break;
            }
            hand = hand_state_at(&self.motions, &hand, once, stage);
            rest -= once;
        }
        hand_state_at(&self.motions, &hand, rest, stage)
    }

    fn squeezes(&self, begin: f64, found: &mut Vec<(f64, f64)>) {
        let once = squeezes(&self.motions);
        found.extend(once.into_iter().map(|(end, force)| (begin + end, force)));
    }

    fn needs_gravity(&self) -> bool {
        self.motions.iter().any(|m| m.as_profile().needs_gravity())
    }
}

/// Returns the total duration of motions executed one after the other, s.
pub fn duration(motions: &[Motion]) -> f64 {
    motions.iter().map(|m| m.as_profile().duration()).sum()
}

/// Returns the state of the hand at `time` (s) after the start of `motions` from `start`; after their end, the final
/// state.
pub fn hand_state_at(motions: &[Motion], start: &HandState, time: f64, stage: &MotionContext) -> HandState {
    let (mut hand, mut rest) = (*start, time);
    for motion in motions {
        let motion = motion.as_profile();
        let duration = motion.duration();
        if rest < duration {
            return motion.hand_state(&hand, rest, stage);
        }
        hand = motion.hand_state(&hand, duration, stage);
        rest -= duration;
    }
    hand
}

/// Returns the end times (s) and forces (N) of all squeezes.
pub fn squeezes(motions: &[Motion]) -> Vec<(f64, f64)> {
    let (mut found, mut begin) = (Vec::new(), 0.0);
    for motion in motions {
        motion.as_profile().squeezes(begin, &mut found);
        begin += motion.as_profile().duration();
    }
    found
}
