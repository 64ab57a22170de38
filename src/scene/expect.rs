//! Expected results of a scene, checked after each grasp: `expect` for finite elements, `expect_network` for a network.

use super::leaf::{Finite, Length, Positive};
use super::vector::Vec3;
use serde::{Deserialize, Serialize};

/// Expected result that is checked on every grasp of the scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Expectation {
    /// The loading is reached: the final force of a squeeze, the final depth of a press.
    ReachesForce,
    /// Force balance of the object (fingers, weight, support): largest residual over the force of the loading.
    ForceBalance(Relative),
    /// Torque balance of the object: largest residual over the force times the object size.
    TorqueBalance(Relative),
    /// All recorded numbers are finite.
    Finite,
    /// No element of the pads is inverted in any frame.
    NoInversion,
    /// Pads and object do not overlap in any frame by more than the contact offset, the resolution of the contact law.
    NoPenetration,
    /// Largest penetration of pads and object in any frame, m. With coarse pads, the object penetrates between the
    /// contact samples.
    Penetration(Bounds),
    /// Force balance of the gel in every frame: largest residual over the force of a finger. Quasi-static scenes only.
    Converged(Relative),
    /// Travel of each finger after contact at the last frame, m.
    Travel(Bounds),
    /// Sum over the fingers of |normal force| at the last frame, N.
    Force(Bounds),
    /// Force at a given travel after contact, interpolated between frames.
    ForceAt(ForceAt),
    /// Largest von Mises stress at the last frame, Pa.
    MaxStress(Bounds),
    /// Dynamic: largest displacement (upper bound) of any point of the object in any frame, relative to the hand from
    /// the end of the first squeeze on or, without fingers, relative to the world.
    ObjectHeld(Slip),
    /// Dynamic: largest displacement (upper bound) of any point of the object at the last frame, m, relative to the
    /// same frame of reference as in `ObjectHeld`.
    ObjectSlides(Bounds),
    /// Dynamic: position of the object's centre of mass in the world at the last frame.
    ObjectAt(Place),
    /// Dynamic: speed of the object's centre of mass at the last frame, m/s.
    ObjectSpeed(Bounds),
    /// Dynamic: normal force of the ground on the object at the last frame, N.
    GroundForce(Bounds),
    /// Dynamic: largest total torque of the pads about the closing direction in any frame, N m.
    Torque(Bounds),
    /// Dynamic: conservation of the linear and angular momentum of the object: largest change over the initial value.
    MomentumKept(Relative),
    /// The object is dropped, for a reason that contains this text.
    Dropped(Reason),
    /// The solver fails or its result is invalid, for a reason that contains this text.
    Fault(Reason),
    /// The grasp cannot start, for a reason that contains this text.
    Infeasible(Reason),
}

/// Relative error bound.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Relative {
    /// Largest relative error.
    pub relative: Positive,
}

/// Lower bound, upper bound or both, in the unit of the measured quantity.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Bounds {
    /// Lower bound.
    pub at_least: Option<Finite>,
    /// Upper bound.
    pub at_most: Option<Finite>,
}

/// Point of the force-depth curve.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ForceAt {
    /// Travel of a finger after contact, m.
    pub depth: Length,
    /// Force of that finger at this travel, N.
    pub force: Positive,
    /// Allowed relative error of the force.
    pub relative: Positive,
}

/// Bound on slip.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Slip {
    /// Largest allowed displacement of any point of the object, m.
    pub slip_at_most: Length,
}

/// Position with a tolerance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Place {
    /// Position in the world, m.
    pub position: Vec3,
    /// Allowed distance from the position, m.
    pub within: Length,
}

/// Substring of a reason; an empty text matches any reason.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Reason {
    /// Text that the reason must contain.
    pub contains: String,
}

impl Expectation {
    /// Returns the name of the expectation, as in the scene file.
    pub fn name(&self) -> &'static str {
        match self {
            Expectation::ReachesForce => "ReachesForce",
            Expectation::ForceBalance(_) => "ForceBalance",
            Expectation::TorqueBalance(_) => "TorqueBalance",
            Expectation::Finite => "Finite",
            Expectation::NoInversion => "NoInversion",
            Expectation::NoPenetration => "NoPenetration",
            Expectation::Penetration(_) => "Penetration",
            Expectation::Converged(_) => "Converged",
            Expectation::Travel(_) => "Travel",
            Expectation::Force(_) => "Force",
            Expectation::ForceAt(_) => "ForceAt",
            Expectation::MaxStress(_) => "MaxStress",
            Expectation::ObjectHeld(_) => "ObjectHeld",
            Expectation::ObjectSlides(_) => "ObjectSlides",
            Expectation::ObjectAt(_) => "ObjectAt",
            Expectation::ObjectSpeed(_) => "ObjectSpeed",
            Expectation::GroundForce(_) => "GroundForce",
            Expectation::Torque(_) => "Torque",
            Expectation::MomentumKept(_) => "MomentumKept",
            Expectation::Dropped(_) => "Dropped",
            Expectation::Fault(_) => "Fault",
            Expectation::Infeasible(_) => "Infeasible",
        }
    }

    /// Returns true if the audit checks the expectation.
    pub fn needs_audit(&self) -> bool {
        use Expectation::*;
        matches!(self, Finite | NoInversion | NoPenetration | Penetration(_) | Converged(_))
    }

    /// Returns true if a network meets the expectation by construction, independent of its training. A network answers
    /// at the requested force. Its contact forces are corrected so that they balance the load on the object, as do
    /// their torques except for the torque about the closing direction. Results that are not finite are refused. The
    /// deformation of the pads, the penetration and the inversion of gel elements are only learned, to within the error
    /// of the network; a scene with such expectations for a network gives their bounds in `expect_network`.
    pub fn holds_by_construction(&self) -> bool {
        use Expectation::*;
        matches!(self, ReachesForce | ForceBalance(_) | Finite | Force(_) | Fault(_) | Infeasible(_))
    }

    /// Returns the unit of the value and of its bound; "" for a ratio or a text.
    pub fn unit(&self) -> &'static str {
        match self {
            Expectation::ReachesForce | Expectation::Force(_) | Expectation::ForceAt(_) => "N",
            Expectation::NoPenetration | Expectation::Penetration(_) | Expectation::Travel(_) => "m",
            Expectation::MaxStress(_) => "Pa",
            Expectation::ObjectHeld(_) | Expectation::ObjectSlides(_) | Expectation::ObjectAt(_) => "m",
            Expectation::ObjectSpeed(_) => "m/s",
            Expectation::GroundForce(_) => "N",
            Expectation::Torque(_) => "N m",
            _ => "",
        }
    }

    /// Returns true if the expectation requires a dynamic scene.
    pub fn is_dynamic(&self) -> bool {
        use Expectation::*;
        matches!(
            self,
            ObjectHeld(_)
                | ObjectSlides(_)
                | ObjectAt(_)
                | ObjectSpeed(_)
                | GroundForce(_)
                | Torque(_)
                | MomentumKept(_)
        )
    }
}
