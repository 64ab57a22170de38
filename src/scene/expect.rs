//! Promises of a scene about its own outcome: `expect` for finite elements, `expect_network` for a network.

use super::leaf::{Finite, Length, Positive};
use super::vector::Vec3;
use serde::{Deserialize, Serialize};

/// Promise that is judged on every grasp of the scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Expectation {
    /// Loading reached: the final force of a squeeze, the final depth of a press.
    ReachesForce,
    /// Balance of the forces on the object (fingers, weight, support): residual over the force of the loading.
    ForceBalance(Relative),
    /// Balance of the torques on the object: residual over force times object size.
    TorqueBalance(Relative),
    /// Finite values of all recorded numbers.
    Finite,
    /// Soft elements without inversion in every frame.
    NoInversion,
    /// Pads and object without overlap in every frame, down to the offset of the contact law, below which nothing is resolved.
    NoPenetration,
    /// Depth of the overlap of pads and object at the worst point of any frame, m: a coarse pad is known to sink in
    /// between its points.
    Penetration(Bounds),
    /// Balance of the forces on the gel in every frame: residual over the force of a finger. Quasi-static scenes only.
    Converged(Relative),
    /// Travel of each finger after contact at the last frame, m.
    Travel(Bounds),
    /// Sum over the fingers of |normal force| at the last frame, N.
    Force(Bounds),
    /// Force at a travel after contact, interpolated between frames.
    ForceAt(ForceAt),
    /// Largest von Mises stress of the last frame, Pa.
    MaxStress(Bounds),
    /// Dynamic: largest displacement of any point of the object relative to what holds it. That is the hand from the end
    /// of the first squeeze on or, without fingers, the world.
    ObjectHeld(Slip),
    /// Dynamic: displacement of the object at the last frame, m, relative to the same reference as in `ObjectHeld`.
    ObjectSlides(Bounds),
    /// Dynamic: position of the object's centre of mass in the world at the last frame.
    ObjectAt(Place),
    /// Dynamic: speed of the object's centre of mass at the last frame, m/s.
    ObjectSpeed(Bounds),
    /// Dynamic: normal force of the ground on the object at the last frame, N.
    GroundForce(Bounds),
    /// Dynamic: largest torque of the pads about the closing direction in any frame, N m.
    Torque(Bounds),
    /// Dynamic: conservation of the linear and angular momentum of the object: largest change over the value at the
    /// start.
    MomentumKept(Relative),
    /// Loss of the object from the grasp, for a reason that contains this text.
    Dropped(Reason),
    /// Failure of the solver, or an unsound result, for a reason that contains this text.
    Fault(Reason),
    /// Refusal of the start, for a reason that contains this text.
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
    /// Smallest allowed value.
    pub at_least: Option<Finite>,
    /// Largest allowed value.
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
    /// Largest allowed motion of any point of the object, m.
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

/// Part of a reason; an empty text matches any reason.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Reason {
    /// Text that the reason must contain.
    pub contains: String,
}

impl Expectation {
    /// Returns the name of the promise, as in the scene file.
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

    /// Returns true if the [`crate::judge::audit`] judges the promise.
    pub fn audited(&self) -> bool {
        use Expectation::*;
        matches!(self, Finite | NoInversion | NoPenetration | Penetration(_) | Converged(_))
    }

    /// Returns true if a network keeps the promise by construction, whatever it has learnt. A network answers at the requested force. Its
    /// contact forces are brought into balance with the load on the object, as are their torques except for the twist about the closing
    /// direction. Numbers that are not finite are refused. The deformation of the pads, the depth at which they meet the object and the
    /// inversion of gel elements are only learnt, to within its error; a scene that makes promises about these for a network states the
    /// bounds in `expect_network`.
    pub fn by_network(&self) -> bool {
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

    /// Returns true if only a dynamic scene can be judged by this promise.
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
