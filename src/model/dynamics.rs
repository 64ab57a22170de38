//! Additional data of a dynamic scene over a quasi-static one.

use crate::geometry::shape::Shape;
use crate::gripper::GraspPose;
use crate::mech::contact::law::ContactLaw;
use crate::scene::motion::{self, HandState, Motion, Stage};
use crate::scene::{Ground, Loading, Scene};
use glam::DVec3;

/// Time, motions and surroundings. The world's frame is that of the object at the start of the grasp.
#[derive(Debug, Clone)]
pub struct Dynamics {
    /// Largest time step, s.
    pub time_step: f64,
    /// Gravity, world, m/s2; zero without.
    pub gravity: DVec3,
    /// Viscosity of the gel over its stiffness, s.
    pub damping: f64,
    /// Speed at which a finger closes on nothing with the largest force, m/s.
    pub closing_speed: f64,
    /// Largest sum of the closing forces, N; zero if the hand never squeezes.
    pub rated_force: f64,
    /// Time at which the first squeeze has reached its force, s; None if the hand never squeezes.
    pub gripped: Option<f64>,
    /// Velocity of the object's centre of mass at the start, world, m/s.
    pub velocity: DVec3,
    /// Its angular velocity, world, rad/s.
    pub spin: DVec3,
    /// Ground that the object may rest on.
    pub support: Option<Support>,
    motions: Vec<Motion>,
    stage: Stage,
}

/// The plane `normal . x = height` below the object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Support {
    /// Normal out of the ground, unit, world.
    pub normal: DVec3,
    /// Height along the normal, m.
    pub height: f64,
    /// Contact law of one vertex of the object, stiffness in N/m.
    pub law: ContactLaw,
}

/// Least stiffness of a vertex against the ground, over the object's mass times standard gravity over the contact offset: the
/// object sinks in by a tenth of the offset under its weight.
const FIRM: f64 = 10.0 * 9.81;
/// Least stiffness of a vertex against the ground over the object's mass, times the square of the time step: so stiff that an
/// impact ends within a step whatever the step, without bouncing (a vertex leaves with about the reciprocal of this of its
/// speed).
const INELASTIC: f64 = 100.0;

/// Tangential stiffness of a sticking vertex over its normal stiffness: the travel that loads friction is the slip of a load
/// that comes at once.
const STICKING: f64 = 10.0;

impl Dynamics {
    /// Returns the dynamics of `scene`, if it is dynamic; `mass` is that of the object, kg. Contact has this `offset` (m).
    pub fn of(scene: &Scene, object: &Shape, mass: f64, offset: f64) -> Option<Self> {
        let Loading::Dynamic(dynamic) = &scene.loading else { return None };
        let gravity = scene.gravity.map_or(DVec3::ZERO, |g| g.dvec3());
        let squeezes = motion::squeezes(&dynamic.motions);
        let time_step = dynamic.time_step.get();
        let placement = scene.gripper.placement;
        let vector = |v: Option<crate::scene::vector::Vec3>| v.map_or(DVec3::ZERO, |v| v.dvec3());
        Some(Self {
            time_step,
            gravity,
            damping: dynamic.damping.get(),
            closing_speed: dynamic.closing_speed.get(),
            rated_force: squeezes.iter().fold(0.0, |m, (_, f)| f64::max(m, *f)),
            gripped: squeezes.first().map(|(end, _)| *end),
            velocity: vector(scene.object.velocity),
            spin: vector(scene.object.spin),
            support: scene.ground.map(|Ground::Plane(plane)| {
                let normal = plane.normal.unit();
                let lowest = || object.surface.vertices.iter().map(|v| normal.dot(*v)).fold(f64::INFINITY, f64::min);
                let stiffness = mass * (FIRM / offset).max(INELASTIC / (time_step * time_step));
                Support {
                    normal,
                    height: plane.height.map_or_else(|| lowest() - offset, |h| h.get()),
                    law: ContactLaw {
                        stiffness,
                        offset,
                        friction: plane.friction.get(),
                        tangential: STICKING * stiffness,
                    },
                }
            }),
            motions: dynamic.motions.clone(),
            stage: Stage {
                up: (-gravity).normalize_or_zero(),
                center: DVec3::new(0.0, placement.y.get(), placement.z.get()),
            },
        })
    }

    /// Returns true if a force drives the fingers.
    pub fn squeezes(&self) -> bool {
        self.gripped.is_some()
    }

    /// State of the hand at `time` (s) of a grasp that starts at `pose`.
    pub fn hand(&self, pose: &GraspPose, time: f64) -> HandState {
        let start = HandState { position: pose.position, rotation: pose.rotation, force: 0.0 };
        motion::follow(&self.motions, &start, time, &self.stage)
    }
}
