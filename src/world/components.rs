//! The only declaration of the state of a world: every component with its unit, its range and the system that writes
//! it.
//!
//! | entity | components | spawned |
//! |---|---|---|
//! | node | [`FingerIndex`], [`RestPosition`], [`Position`] | always |
//! | | [`NodalStress`] | stress is recorded or expected |
//! | | [`ContactForce`] | contact forces are recorded |
//! | | [`NodeGap`] | gaps are recorded |
//! | | [`NodeSlip`] | slip is observed |
//! | tetrahedron | [`FingerIndex`], [`TetStress`] | stress is recorded or expected |
//! | contact edge | [`FingerIndex`], [`ContactEdge`] | with finite elements, a fixed pool |
//! | | [`ContactFriction`] | friction is above zero |
//! | finger | [`FingerIndex`], [`ClosingDirection`], [`FirstContact`], [`FingerTravel`] | always |
//! | | [`FingerForce`], [`FingerWrench`] | always |
//! | | [`ContactArea`] | the contact area is observed |
//! | object | [`ObjectPose`] | always |
//! | | [`ObjectWeight`] | gravity is set, or an agent acts, and the object may move |
//! | | [`ObjectVelocity`], [`ObjectMomentum`], [`InertialWrench`] | the scene is dynamic and the object may move |
//! | | [`GroundWrench`] | there is a ground and the object may move |
//! | hand | [`HandPose`] | the scene is dynamic |
//!
//! No entity is despawned and no component is added or removed after the spawn, so that columns stay contiguous and in
//! spawn order; the defined order is that of the indices, not that of the rows.

use base::error::Result;
use bevy_ecs::component::Component;
use bevy_ecs::component::Mutable;
use geometry::{Pose, Wrench};
use glam::DVec3;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Reason why columns are contiguous.
pub const TABLES: &str = "components are stored in tables";

/// Returns the rows of a table that belong to each pad, with the number of its finger: nodes, tetrahedra and contact
/// edges are spawned pad by pad, in the order of their index, and never removed.
pub fn rows_by_pad(finger: &[FingerIndex]) -> impl Iterator<Item = (usize, Range<usize>)> {
    let mut end = 0;
    finger.chunk_by(|a, b| a.0 == b.0).map(move |rows| {
        let start = end;
        end += rows.len();
        (rows[0].0 as usize, start..end)
    })
}

/// Visitor of the columns that a step may change.
pub(crate) trait ColumnVisitor {
    /// Visits the column of `C`.
    fn visit<C>(&mut self) -> Result<()>
    where
        C: Component<Mutability = Mutable> + Copy + Serialize + DeserializeOwned;
}

/// Visits every column that a step may change, in a fixed order; the others are written at spawn.
pub(crate) fn visit_columns(visitor: &mut impl ColumnVisitor) -> Result<()> {
    visitor.visit::<Position>()?;
    visitor.visit::<NodalStress>()?;
    visitor.visit::<TetStress>()?;
    visitor.visit::<ContactForce>()?;
    visitor.visit::<NodeGap>()?;
    visitor.visit::<NodeSlip>()?;
    visitor.visit::<ContactEdge>()?;
    visitor.visit::<ContactFriction>()?;
    visitor.visit::<FirstContact>()?;
    visitor.visit::<FingerTravel>()?;
    visitor.visit::<FingerForce>()?;
    visitor.visit::<FingerWrench>()?;
    visitor.visit::<ContactArea>()?;
    visitor.visit::<ObjectPose>()?;
    visitor.visit::<ObjectWeight>()?;
    visitor.visit::<ObjectVelocity>()?;
    visitor.visit::<ObjectMomentum>()?;
    visitor.visit::<InertialWrench>()?;
    visitor.visit::<GroundWrench>()?;
    visitor.visit::<HandPose>()
}

/// Declares components: plain data, copied freely.
macro_rules! components {
    ($($(#[$doc:meta])* $name:ident($(#[$inner:meta])* $type:ty);)*) => {
        $($(#[$doc])*
        #[derive(Component, Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
        pub struct $name($(#[$inner])* pub $type);)*
    };
}

components! {
    /// Finger that the entity is or belongs to: 0 left, 1 right. Written at spawn.
    FingerIndex(u32);
    /// Reference position of a node, m, hand frame at zero travel. Written at spawn.
    RestPosition(DVec3);
    /// Position of a node, m, in hand axes relative to its finger: in the hand frame it is at
    /// `Position + FingerTravel * ClosingDirection`. Written by the stepper.
    Position(DVec3);
    /// Von Mises stress at a node, Pa, >= 0, volume-weighted over its tetrahedra. Written by the stepper.
    NodalStress(f64);
    /// Von Mises stress of a tetrahedron, Pa, >= 0. Written by the stepper.
    TetStress(f64);
    /// Contact force on a node of the pad, N, hand frame. Written by the stepper; zero away from the contact.
    ContactForce(DVec3);
    /// Signed distance of a node to the object, m; negative inside. Written by `measure_gap`.
    NodeGap(f64);
    /// Fraction of the contact force of a node that slipping points carry, 0 to 1. Written by `measure_slip`.
    NodeSlip(f64);
    /// Contact area of the pad of a finger, m2, in the reference state. Written by `measure_contact_area`.
    ContactArea(f64);
    /// Unit vector along which a finger closes, hand frame. Written at spawn.
    ClosingDirection(DVec3);
    /// Travel of a finger at first contact, m, 0 to the stroke. Written once by `close_to_contact`.
    FirstContact(f64);
    /// Travel of a finger from the open gripper, m, 0 to the stroke. Written by `close_to_contact`, then by the
    /// stepper.
    FingerTravel(f64);
    /// Force that closes a finger, N, >= 0: set by `set_load`; if travel is prescribed, the reaction of the finger's
    /// mount, written by the stepper.
    FingerForce(f64);
    /// Weight of a free object, N, hand frame; in the world of an agent, the total load on it. Written at spawn, by the
    /// stepper if the hand rotates, by [`env`] before a step.
    ObjectWeight(DVec3);
}

/// Potential contact between a pad and the object, from a fixed pool. Written by the stepper, which reads it in the
/// next step.
#[derive(Component, Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ContactEdge {
    /// Distance of the pad's point to the object, m; `+inf` if out of range.
    pub gap: f64,
    /// Outward normal of the object at the contact, unit, hand frame; zero if out of range.
    pub normal: DVec3,
    /// Pressure, Pa, >= 0.
    pub pressure: f64,
    /// Stiffness factor, >= 1: raised where the pressure would use up the contact offset.
    pub scale: f64,
    /// Point at which the force acts, m, hand frame; zero if out of range.
    pub point: DVec3,
    /// Force on the pad, friction included, N, hand frame.
    pub force: DVec3,
}

/// Friction on a contact edge. Written by the stepper, which reads it in the next step.
#[derive(Component, Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ContactFriction {
    /// Friction anchor (sticking point), m: object frame for a point of the pad, hand axes relative to the finger for a
    /// contact vertex of the object.
    pub anchor: Option<DVec3>,
    /// Normal of the friction plane, hand frame; zero before any contact.
    pub plane: DVec3,
    /// Coulomb limit of the traction, Pa.
    pub limit: f64,
    /// Friction traction on the pad, Pa, hand frame.
    pub traction: DVec3,
    /// Flag: Coulomb's limit is reached.
    pub slips: bool,
}

/// Resultant of the contact on the pad of a finger, about the origin of its pad frame, which moves with the finger, hand
/// frame. Written by the stepper.
#[derive(Component, Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct FingerWrench(pub Wrench);

/// Pose of the object in the hand frame. Written by `place_object`, then by the stepper.
#[derive(Component, Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ObjectPose(pub Pose);

/// Pose of the hand in the world. Written by the stepper.
#[derive(Component, Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HandPose(pub Pose);

/// Velocity of a free object. Written by the stepper.
#[derive(Component, Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ObjectVelocity {
    /// Velocity of the centre of mass, m/s, world axes.
    pub linear: DVec3,
    /// Angular velocity, rad/s, world axes.
    pub angular: DVec3,
}

/// Momentum of a free object. Written by the stepper.
#[derive(Component, Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ObjectMomentum {
    /// Linear momentum, kg m/s, world axes.
    pub linear: DVec3,
    /// Angular momentum about the centre of mass, kg m2/s, world axes.
    pub angular: DVec3,
}

/// Forces of inertia on a free object, about its centre of mass, hand frame: minus the rates of its momenta in the last
/// time step. Written by the stepper.
#[derive(Component, Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct InertialWrench(pub Wrench);

/// Force and torque of the ground on a free object, about its centre of mass, hand frame. Written by the stepper.
#[derive(Component, Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct GroundWrench(pub Wrench);

impl Default for ContactEdge {
    fn default() -> Self {
        Self {
            gap: f64::INFINITY,
            normal: DVec3::ZERO,
            pressure: 0.0,
            scale: 1.0,
            point: DVec3::ZERO,
            force: DVec3::ZERO,
        }
    }
}
