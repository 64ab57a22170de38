//! Data of a dynamic scene in addition to those of a quasi-static one.

use geometry::Pose;
use geometry::shape::Shape;
use glam::DVec3;
use mech::contact::law::ContactLaw;
use scene::motion::{self, HandState, Motion, MotionContext};
use scene::{Ground, Loading, Scene};

/// Time step, motions, gravity and ground. The world frame is the object frame at the start of the grasp.
#[derive(Debug, Clone)]
pub struct Dynamics {
    /// Largest time step, s.
    pub time_step: f64,
    /// Gravity, world, m/s2; zero if the scene has none.
    pub gravity: DVec3,
    /// Ratio of viscosity to stiffness of the gel, s.
    pub damping: f64,
    /// Speed at which a finger closes without contact under the largest force, m/s.
    pub closing_speed: f64,
    /// Largest sum of the closing forces, N; zero if the hand never squeezes.
    pub rated_force: f64,
    /// Time at which the first squeeze reaches its force, s; None if the hand never squeezes.
    pub gripped: Option<f64>,
    /// Velocity of the object's centre of mass at the start, world, m/s.
    pub velocity: DVec3,
    /// Angular velocity of the object at the start, world, rad/s.
    pub spin: DVec3,
    /// Ground under the object.
    pub support: Option<Support>,
    motions: Vec<Motion>,
    stage: MotionContext,
}

/// Ground plane `normal . x = height`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Support {
    /// Outward unit normal of the ground, world.
    pub normal: DVec3,
    /// Height along the normal, m.
    pub height: f64,
    /// Contact law of a vertex of the object; its stiffness is in N/m.
    pub law: ContactLaw,
}

/// Smallest stiffness of a vertex contact with the ground over m / d, with the object mass m and the contact offset d,
/// m/s2: ten times standard gravity, so that the object under its weight compresses the offset by a tenth.
const MIN_GROUND_STIFFNESS: f64 = 10.0 * 9.81;
/// Smallest stiffness of a vertex contact with the ground over m / dt^2, with the object mass m and the time step dt:
/// an impact then ends within a step without rebound (a vertex leaves with about the reciprocal of this times its
/// speed).
const MIN_IMPACT_STIFFNESS: f64 = 100.0;

/// Tangential stiffness of a sticking vertex over its normal stiffness: the displacement at which friction reaches its
/// limit is also the slip under a suddenly applied load.
const STICKING: f64 = 10.0;

impl Dynamics {
    /// Returns the dynamics of `scene` if it is dynamic; `mass` is the mass of the object, kg, `offset` the contact
    /// offset, m.
    pub fn from_scene(scene: &Scene, object: &Shape, mass: f64, offset: f64) -> Option<Self> {
        let Loading::Dynamic(dynamic) = &scene.loading else { return None };
        let gravity = scene.gravity.map_or(DVec3::ZERO, |g| g.dvec3());
        let squeezes = motion::squeezes(&dynamic.motions);
        let time_step = dynamic.time_step.get();
        let placement = scene.gripper.placement;
        let vector = |v: Option<scene::vector::Vec3>| v.map_or(DVec3::ZERO, |v| v.dvec3());
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
                let stiffness =
                    mass * (MIN_GROUND_STIFFNESS / offset).max(MIN_IMPACT_STIFFNESS / (time_step * time_step));
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
            stage: MotionContext {
                up: (-gravity).normalize_or_zero(),
                center: DVec3::new(0.0, placement.y.get(), placement.z.get()),
            },
        })
    }

    /// Returns true if the fingers are force-driven.
    pub fn squeezes(&self) -> bool {
        self.gripped.is_some()
    }

    /// Returns the state of the hand at `time` (s) of a grasp that starts at `pose`.
    pub fn hand(&self, pose: &Pose, time: f64) -> HandState {
        let start = HandState { pose: *pose, force: 0.0 };
        motion::hand_state_at(&self.motions, &start, time, &self.stage)
    }
}
