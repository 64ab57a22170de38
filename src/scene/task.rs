//! The scene as an environment of reinforcement learning: what an agent may do, what it sees, what it is paid for.

use super::defaults;
use super::leaf::{Count, Depth, Length, NonNegative, Positive};
use super::loading::Loading;
use super::object::ObjectMotion;
use super::schema::Scene;
use super::vector::{Tuple, Vec3};
use crate::number::shown;
use crate::scene::Observe;
use crate::scene::Reward;
use serde::{Deserialize, Serialize};

/// Least and most.
pub type Span = Tuple<Positive, 2>;

/// A task. An episode closes the hand on the object, which lies on a support, squeezes with `start`, and withdraws the
/// support in `lift` steps; then pushes may follow. Loads act on the object's centre of mass; the closing direction's part
/// of them is carried by the gearing of the fingers, not by the pads.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Task {
    /// Gravity in the world, which is the object frame at the start of each grasp, m/s2; None is none.
    pub gravity: Option<Vec3>,
    /// Sum of the finger forces that the agent may ask for, N.
    pub force: Span,
    /// Sum of the finger forces at the start of an episode, N.
    pub start: Positive,
    /// What the first number of an action means.
    pub control: Control,
    /// Most that a step turns the wrist about the closing direction, degrees; None leaves the wrist alone.
    pub twist_deg: Option<Positive>,
    /// Every step opens the hand and grasps anew; None holds on.
    pub regrasp: Option<Regrasp>,
    /// Steps after which an episode is cut off.
    pub steps: Count<1, 10000>,
    /// Steps in which the support is withdrawn.
    pub lift: Count<1, 10000>,
    /// Pushes against the object; None is none.
    pub pushes: Option<Pushes>,
    /// Way of the object over the pads at which it counts as lost, m.
    pub slip_limit: Length,
    /// What the agent sees.
    pub observe: Vec<Observe>,
    /// What it is paid for, added up.
    pub reward: Vec<Reward>,
    /// What differs between episodes.
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
            observe: Observe::USUAL.to_vec(),
            reward: vec![Reward::default()],
            randomise: Randomise::default(),
        }
    }
}

/// What the first number of an action, -1 to 1, means.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub enum Control {
    /// The force itself, from the least to the most.
    #[default]
    Force,
    /// Its change, this many newtons per step at most.
    Rate(Positive),
}

/// How far a new grasp may be from the first one: three numbers of an action.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Regrasp {
    /// Along the finger width and along the approach, m.
    pub shift: Length,
    /// About the closing direction, degrees.
    pub turn_deg: Positive,
}

/// Pushes one after the other, in random directions across the closing direction; each rises and falls as half a sine.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pushes {
    /// Largest force of a push, N.
    pub force: Span,
    /// Steps from push to push.
    pub every: Count<1, 10000>,
    /// Steps that a push lasts.
    pub lasts: Count<1, 10000>,
}

/// What differs between episodes, drawn by (seed, environment, episode). The object is drawn from the scene's, the grasp
/// from the object's.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Randomise {
    /// Factor on Young's modulus of the gel.
    pub young: Option<Span>,
    /// Coefficient of friction.
    pub friction: Option<Span>,
    /// Pairs of the two that are prepared per object, to draw from.
    pub variants: Count<1, 1000>,
    /// Density of the object, kg/m3.
    pub density: Option<Span>,
    /// Of the hand, across the closing direction, at most, m.
    pub shift: Depth,
    /// Of the hand, about any axis through the pads' middle, at most, degrees.
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

impl Tuple<Positive, 2> {
    /// The number at `part` (0..1) of the way.
    pub fn at(self, part: f64) -> f64 {
        let [low, high] = self.0.map(Positive::get);
        low + part * (high - low)
    }
}

/// The first thing that does not fit, as field and message.
pub(super) fn problem(scene: &Scene) -> Option<(String, String)> {
    let task = scene.task.as_ref()?;
    let field = |name: &str, message: &str| Some((format!("task{name}"), message.to_string()));
    let random = &task.randomise;
    let spans = [
        (".force", Some(task.force)),
        (".pushes.force", task.pushes.map(|p| p.force)),
        (".randomise.young", random.young),
        (".randomise.friction", random.friction),
        (".randomise.density", random.density),
    ];
    let falls = |s: &Span| s.0[0].get() > s.0[1].get();
    if let Some((name, _)) = spans.iter().find(|(_, s)| s.as_ref().is_some_and(falls)) {
        return field(name, "the first number is the least, the second the most: (1, 10)");
    }
    let [least, most] = task.force.0.map(Positive::get);
    if !(least..=most).contains(&task.start.get()) {
        return field(".start", &format!("must lie within the allowed force, {} to {} N", shown(least), shown(most)));
    }
    if task.observe.is_empty() {
        return field(".observe", "the agent sees nothing\nleave `observe` out for the usual");
    }
    if (1..task.observe.len()).any(|i| task.observe[..i].iter().any(|o| o.name() == task.observe[i].name())) {
        return field(".observe", "two observations have the same name");
    }
    if scene.gravity.is_some() {
        return field(
            ".gravity",
            "gravity of a task stands in the task, which withdraws the support little by little\nmove `gravity` into `task`",
        );
    }
    let free = scene.object.motion == ObjectMotion::Free;
    match &scene.loading {
        Loading::Squeeze(_) if free => None,
        Loading::Squeeze(_) => field("", "there is nothing to hold: the object is fixed\nuse motion: Free"),
        _ => field("", "a task squeezes by force\nuse loading: Squeeze(force: ...)"),
    }
}
