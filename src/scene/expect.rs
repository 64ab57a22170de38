//! What a scene promises about its own outcome: `expect` of finite elements, `expect_network` of a network.

use super::leaf::{Finite, Length, Positive};
use super::vector::Vec3;
use serde::{Deserialize, Serialize};

/// One promise, judged on every grasp of the scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Expectation {
    /// The loading is reached: the final force of a squeeze, the final depth of a press.
    ReachesForce,
    /// Forces on the object (fingers, weight, support) cancel: residual over the force of the loading.
    ForceBalance(Relative),
    /// Torques on the object cancel: residual over force times object size.
    TorqueBalance(Relative),
    /// Every recorded number is finite.
    Finite,
    /// No soft element is turned inside out in any frame.
    NoInversion,
    /// Pads and object are nowhere inside each other in any frame, deeper than the offset of the contact law, below which nothing is
    /// resolved.
    NoPenetration,
    /// How deep they are at the worst point of any frame, m: where a coarse pad is known to sink in between its points.
    Penetration(Bounds),
    /// The forces on the gel balance in every frame: what is left over, over the force of a finger. Quasi-static scenes.
    Converged(Relative),
    /// Travel of each finger after contact at the last frame, m.
    Travel(Bounds),
    /// Sum over the fingers of |normal force| at the last frame, N.
    Force(Bounds),
    /// Force at a travel after contact, interpolated between frames.
    ForceAt(ForceAt),
    /// Largest von Mises stress of the last frame, Pa.
    MaxStress(Bounds),
    /// Dynamic: no point of the object moves far relative to what holds it: the hand from the end of the first squeeze on,
    /// or, without fingers, the world.
    ObjectHeld(Slip),
    /// Dynamic: by the last frame it has moved, relative to the same.
    ObjectSlides(Bounds),
    /// Dynamic: where its centre of mass is in the world at the last frame.
    ObjectAt(Place),
    /// Dynamic: speed of its centre of mass at the last frame, m/s.
    ObjectSpeed(Bounds),
    /// Dynamic: normal force of the ground on it at the last frame, N.
    GroundForce(Bounds),
    /// Dynamic: largest torque of the pads about the closing direction in any frame, N m.
    Torque(Bounds),
    /// Dynamic: linear and angular momentum of the object stay those of the start: largest change over the start's.
    MomentumKept(Relative),
    /// The object leaves the grasp, and the reason contains this text.
    Dropped(Reason),
    /// The solver gives up, or finds what is unsound, and its reason contains this text.
    Fault(Reason),
    /// The start is refused, and the reason contains this text.
    Infeasible(Reason),
}

/// A relative error bound.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Relative {
    /// Largest relative error.
    pub relative: Positive,
}

/// A lower bound, an upper bound or both, in the unit of the measured thing.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Bounds {
    /// Smallest allowed value.
    pub at_least: Option<Finite>,
    /// Largest allowed value.
    pub at_most: Option<Finite>,
}

/// A point of the force-depth curve.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ForceAt {
    /// Travel of a finger after contact, m.
    pub depth: Length,
    /// Force of that finger there, N.
    pub force: Positive,
    /// Allowed relative error of the force.
    pub relative: Positive,
}

/// A bound on slip.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Slip {
    /// Largest allowed motion of any point of the object, m.
    pub slip_at_most: Length,
}

/// A place.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Place {
    /// World, m.
    pub position: Vec3,
    /// Allowed distance from it, m.
    pub within: Length,
}

/// Part of a reason; empty is any.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Reason {
    /// The text.
    pub contains: String,
}

impl Expectation {
    /// Its name, as in the scene file.
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

    /// Whether it is judged by the [`crate::judge::audit`].
    pub fn audited(&self) -> bool {
        use Expectation::*;
        matches!(self, Finite | NoInversion | NoPenetration | Penetration(_) | Converged(_))
    }

    /// Whether a network keeps it by its making, whatever it has learnt: it answers at the force that it is asked for, its contact
    /// forces are put into balance with the load on the object (their torques too, but for the twist about the closing direction), and
    /// numbers that are not finite are refused. How far the pads give way, how deep they meet the object and how a gel element is
    /// turned it has only learnt, to within its error; a scene that asks for that of a network says how much in `expect_network`.
    pub fn by_network(&self) -> bool {
        use Expectation::*;
        matches!(self, ReachesForce | ForceBalance(_) | Finite | Force(_) | Fault(_) | Infeasible(_))
    }

    /// Unit of its value and bound; "" for a ratio or a text.
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

    /// True if only a dynamic scene can be judged by it.
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
