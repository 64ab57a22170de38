//! Reasons why a solve stops without an equilibrium.

use std::fmt;

/// Reason why a solve stopped without converging.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Failure {
    /// The iteration limit was reached with this residual, N.
    Iterations(f64),
    /// No step along the Newton direction lowers the energy; residual, N.
    LineSearch(f64),
    /// The stiffness is not positive definite even after projection, or not finite.
    Singular,
    /// The corrections of condensed pads do not converge; size of the last one over the displacement.
    Corrections(f64),
    /// The path deviates too much from a straight increment; path error over the error allowed.
    PathError(f64),
    /// The object kept rolling or sliding and did not reach equilibrium.
    Unsettled,
    /// A finger closes without contact: the object left the grasp.
    LostContact,
    /// The object moved farther than an object that counts as held.
    MovedTooFar,
    /// The number of Newton iterations reached this limit of a grasp, or of a step of an agent.
    Effort(u64),
    /// The wall time allowed for a grasp was exceeded, s.
    Time(f64),
    /// The user interrupted the run.
    Interrupted,
}

impl Failure {
    /// Returns true if the object left the grasp: a physical outcome, not a numerical one.
    pub fn leaves_the_grasp(&self) -> bool {
        matches!(self, Failure::LostContact | Failure::MovedTooFar | Failure::Unsettled)
    }

    /// Returns true if no further attempt may be made.
    pub fn is_out_of_effort(&self) -> bool {
        matches!(self, Failure::Effort(_) | Failure::Time(_) | Failure::Interrupted)
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Failure::Iterations(r) => write!(f, "no equilibrium within the iteration limit (residual {r:.1e} N)"),
            Failure::LineSearch(r) => write!(f, "line search: no step lowers the energy (residual {r:.1e} N)"),
            Failure::Corrections(e) => {
                write!(f, "the corrections of the condensed pads do not converge (error {e:.1e})")
            }
            Failure::PathError(error) => write!(f, "the path error of one increment is {error:.1} times its tolerance"),
            Failure::LostContact => f.write_str("a finger closes without contact: the object was squeezed out"),
            Failure::MovedTooFar => f.write_str("the object moves farther than a held object may"),
            Failure::Effort(most) => write!(
                f,
                "no equilibrium within {most} Newton iterations, the limit for a grasp with this number of steps or \
                 for a step of an agent"
            ),
            Failure::Time(seconds) => {
                write!(f, "no equilibrium within {seconds} s of wall time, the limit for a grasp")
            }
            Failure::Interrupted => f.write_str("interrupted"),
            Failure::Unsettled => f.write_str("the object keeps rolling or sliding and does not come to rest"),
            Failure::Singular => f.write_str("the stiffness is not positive definite or not finite"),
        }
    }
}
