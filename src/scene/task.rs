//! Scene as an environment of reinforcement learning: actions, observations and rewards of an agent.

use super::defaults;
use super::leaf::{Count, Depth, Length, NonNegative, Positive};
pub use super::span::Span;
use super::vector::Vec3;
use crate::Observe;
use crate::Reward;
use serde::{Deserialize, Serialize};

/// Task of an agent. In an episode the hand closes on the object, which lies on a support, and squeezes with the force
/// `start`; the support is then withdrawn in `lift` steps, after which pushes may follow. Loads act at the object's
/// centre of mass; their component along the closing direction is carried by the gearing of the fingers and not applied
/// to the pads.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Task {
    /// Gravity in the world, which is the object frame at the start of each grasp, m/s2; None is no gravity.
    pub gravity: Option<Vec3>,
    /// Allowed range of the sum of the finger forces, N.
    pub force: Span,
    /// Sum of the finger forces at the start of an episode, N.
    pub start: Positive,
    /// Meaning of the first component of an action.
    pub control: Control,
    /// Largest rotation of the wrist about the closing direction per step, degrees; None keeps the wrist fixed.
    pub twist_deg: Option<Positive>,
    /// Regrasp in every step: the hand opens and closes at a new pose; None keeps the first grasp.
    pub regrasp: Option<Regrasp>,
    /// Number of steps after which an episode is truncated.
    pub steps: Count<1, 10000>,
    /// Number of steps in which the support is withdrawn: the weight that acts on the object rises linearly.
    pub lift: Count<1, 10000>,
    /// Pushes on the object; None is no pushes.
    pub pushes: Option<Pushes>,
    /// Accumulated slip of the object on the pads above which the object counts as lost, m.
    pub slip_limit: Length,
    /// Observations of the agent.
    pub observe: Vec<Observe>,
    /// Terms of the reward, which are summed.
    pub reward: Vec<Reward>,
    /// Domain randomisation: quantities drawn for each episode.
    pub randomise: Randomise,
}

impl Default for Task {
    fn default() -> Self {
        Self {
            gravity: None,
            force: defaults::TASK_FORCE,
            start: defaults::TASK_START,
            control: Control::default(),
            twist_deg: None,
            regrasp: None,
            steps: defaults::TASK_STEPS,
            lift: defaults::TASK_LIFT,
            pushes: None,
            slip_limit: defaults::TASK_SLIP_LIMIT,
            observe: Observe::DEFAULT.to_vec(),
            reward: vec![Reward::default()],
            randomise: Randomise::default(),
        }
    }
}

/// Meaning of the first component of an action, -1 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub enum Control {
    /// Force: -1 is the smallest allowed force, 1 the largest.
    #[default]
    Force,
    /// Change of the force per step, N: the component times this value.
    Rate(Positive),
}

/// Largest deviation of a new grasp from the first one; three components of an action set the actual values.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Regrasp {
    /// Displacement along the finger width and along the approach, m.
    pub shift: Length,
    /// Rotation about the closing direction, degrees.
    pub turn_deg: Positive,
}

/// Pushes at regular intervals, each in a random direction perpendicular to the closing direction; the force of each
/// follows half a sine wave in time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pushes {
    /// Range of the peak force of a push, N.
    pub force: Span,
    /// Number of steps from the start of a push to the start of the next.
    pub every: Count<1, 10000>,
    /// Duration of a push, in steps.
    pub lasts: Count<1, 10000>,
}

/// Quantities drawn for each episode, determined by (seed, environment, episode). The object is drawn from the objects
/// of the scene, the grasp from the grasps of the object.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Randomise {
    /// Range of a factor on Young's modulus of the gel.
    pub young: Option<Span>,
    /// Range of the coefficient of friction.
    pub friction: Option<Span>,
    /// Number of pairs of Young's modulus and friction that are prepared for each object; episodes draw from these.
    pub variants: Count<1, 1000>,
    /// Range of the density of the object, kg/m3.
    pub density: Option<Span>,
    /// Largest displacement of the hand along the finger width and along the approach, m.
    pub shift: Depth,
    /// Largest rotation of the hand about a random axis through the point midway between the pads, degrees.
    pub turn_deg: NonNegative,
}

impl Default for Randomise {
    fn default() -> Self {
        Self {
            young: None,
            friction: None,
            variants: defaults::TASK_VARIANTS,
            density: None,
            shift: defaults::TASK_SHIFT,
            turn_deg: defaults::TASK_TURN,
        }
    }
}
