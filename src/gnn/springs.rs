//! The grasp on beds of springs (Winkler 1867): what imposed geometry and equilibrium alone say about travel, contact and
//! the motion of the object.
//!
//! Every face node is a spring, normal and tangential, of stiffness `modulus * E area / thickness`. It begins where the node
//! touches the object and sticks there up to Coulomb's limit. The object is rigid: its pose and the travel of the fingers
//! are in equilibrium with the springs, at forces that rise step by step. The network learns what the gel does differently.
//!
//! Dimensionless: lengths over the thickness t, forces over `E t^2`; hand axes, origin amid the pads.

use super::foundation::MODULUS;
use super::side::Side;
use glam::DVec3;
use pulp::Arch;

/// Stiffness of a spring along the normal.
pub(super) const NORMAL: f64 = MODULUS;
/// Along the face.
pub(super) const TANGENTIAL: f64 = 0.6;
/// Forces at which the path of the springs is kept: each is this many times the one before.
const STEP: f64 = 1.4;
/// The first of them.
const FIRST: f64 = 1e-3;
/// Part of its force that a finger presses with at least, however heavy the object.
const LEAST: f64 = 0.05;
/// Unknowns: the travel of two fingers (of both, if they are geared, in the first), translation and rotation of the object.
pub(super) const UNKNOWNS: usize = 8;

pub(super) type Vector = [f64; UNKNOWNS];

/// A face node as a spring.
#[derive(Debug, Clone)]
pub struct Spring {
    /// Number of its finger.
    pub finger: usize,
    /// Position at first contact.
    pub at: DVec3,
    /// Area that it stands for.
    pub area: f64,
    /// Way to the object along the closing direction.
    pub gap: f64,
    /// Outward normal of the object there; zero if it is out of reach.
    pub normal: DVec3,
}

/// All springs of a grasp, and their path.
#[derive(Debug, Clone)]
pub struct Bed {
    springs: Vec<Spring>,
    sides: Vec<Side>,
    friction: f64,
    /// Weight of the object.
    weight: DVec3,
    /// Whether the object may move.
    free: bool,
    /// States at the forces `FIRST * STEP^k`.
    path: Vec<Rest>,
}

/// Springs at rest under a force.
#[derive(Debug, Clone, PartialEq)]
pub struct Rest {
    /// Travel of each finger since first contact.
    pub travel: [f64; 2],
    /// Translation of the object.
    pub shift: DVec3,
    /// Rotation vector of the object.
    pub turn: DVec3,
    /// How far each spring is pressed in along the normal; negative is a gap.
    pub pressed: Vec<f64>,
    /// How far the object has dragged each spring along its surface, by axes.
    pub(super) drag: [Vec<f64>; 3],
}

impl Rest {
    /// How far the object has dragged a spring along its surface.
    pub fn dragged(&self, spring: usize) -> DVec3 {
        DVec3::from_array([0, 1, 2].map(|k| self.drag[k][spring]))
    }
}

impl Bed {
    /// Springs under forces up to `most` per finger; those of a finger follow each other.
    pub fn new(springs: Vec<Spring>, closing: Vec<DVec3>, friction: f64, weight: DVec3, free: bool, most: f64) -> Self {
        let sides = closing.iter().enumerate().map(|(finger, closing)| Side::new(&springs, finger, *closing)).collect();
        let mut bed = Self { sides, springs, friction, weight, free, path: Vec::new() };
        let mut state = bed.touch();
        let mut force = FIRST;
        while force < most {
            state = bed.follow(&state, force);
            bed.path.push(state.clone());
            force *= STEP;
        }
        bed
    }

    /// The springs.
    pub fn springs(&self) -> &[Spring] {
        &self.springs
    }

    /// Force of a pressed spring along the normal.
    pub fn pressure(&self, spring: &Spring, pressed: f64) -> f64 {
        NORMAL * spring.area * pressed.max(0.0)
    }

    /// Force of a dragged spring along the face.
    pub fn drag(&self, spring: &Spring, dragged: DVec3) -> DVec3 {
        dragged * (TANGENTIAL * spring.area)
    }

    /// Which unknown is the travel of `finger`: fingers around a free object are geared, as in the finite elements.
    fn travel(&self, finger: usize) -> usize {
        if self.free { 0 } else { finger }
    }

    /// What `finger` presses with at `force` per finger: one carries more of a free object's weight than the other.
    pub fn carried_by(&self, finger: usize, force: f64) -> f64 {
        let share = self.weight.dot(self.sides[finger].closing) / self.sides.len() as f64;
        if self.free { (force - share).max(LEAST * force) } else { force }
    }

    /// At `force` per finger.
    pub fn rest(&self, force: f64) -> Rest {
        let known = ((force / FIRST).ln() / STEP.ln()).ceil().max(0.0) as usize;
        match self.path.get(..known.min(self.path.len())).and_then(<[Rest]>::last) {
            Some(before) => self.follow(before, force),
            None => self.follow(&self.touch(), force),
        }
    }

    /// At first contact.
    fn touch(&self) -> Rest {
        let slope = |s: &Spring| -s.normal.dot(self.sides[s.finger].closing);
        Rest {
            travel: [0.0; 2],
            shift: DVec3::ZERO,
            turn: DVec3::ZERO,
            pressed: self.springs.iter().map(|s| -s.gap * slope(s)).collect(),
            drag: [(); 3].map(|()| vec![0.0; self.springs.len()]),
        }
    }

    /// Equilibrium under `force` after `before`: Newton's method on the springs that touch.
    fn follow(&self, before: &Rest, force: f64) -> Rest {
        let mut step = [0.0; UNKNOWNS];
        if before.pressed.iter().all(|p| *p <= 0.0) {
            // Something to start from: each finger alone.
            for (finger, side) in self.sides.iter().enumerate() {
                step[self.travel(finger)] = side.alone.depth(force);
            }
        }
        let mut now = before.clone();
        let slide = |step: &Vector, now: &mut Rest| {
            let moved = |(finger, side): (usize, &Side)| {
                Arch::new().dispatch(|| side.slide(step[self.travel(finger)], &step[2..], before, now))
            };
            // All of them, whatever the first one says.
            self.sides.iter().enumerate().map(moved).fold(false, |any, changed| any | changed)
        };
        slide(&step, &mut now);
        for _ in 0..12 {
            let (mut gradient, mut stiffness) = ([0.0; UNKNOWNS], [[0.0; UNKNOWNS]; UNKNOWNS]);
            for k in 0..3 {
                gradient[2 + k] = -self.weight[k];
            }
            for (finger, side) in self.sides.iter().enumerate() {
                gradient[self.travel(finger)] -= force;
                side.add(self.travel(finger), before, &now, &mut gradient, &mut stiffness);
            }
            let change = self.solve(stiffness, gradient);
            step = std::array::from_fn(|a| step[a] - change[a]);
            let same = !slide(&step, &mut now);
            if same && change.iter().all(|c| c.abs() < 1e-9) {
                break;
            }
        }
        (0..self.sides.len()).for_each(|finger| now.travel[finger] += step[self.travel(finger)]);
        now.shift += DVec3::from_slice(&step[2..5]);
        now.turn += DVec3::from_slice(&step[5..8]);
        // Friction carries no more than Coulomb's limit: what is beyond has slipped.
        for i in 0..now.pressed.len() {
            let limit = self.friction * NORMAL / TANGENTIAL * now.pressed[i].max(0.0);
            let dragged = now.dragged(i).clamp_length_max(limit);
            (0..3).for_each(|k| now.drag[k][i] = dragged[k]);
        }
        now
    }

    /// Solves for the unknowns that there are; a touch of stiffness holds what no spring holds.
    fn solve(&self, stiffness: [[f64; UNKNOWNS]; UNKNOWNS], gradient: Vector) -> Vector {
        let used = |a: usize| if a < 2 { (0..self.sides.len()).any(|f| self.travel(f) == a) } else { self.free };
        let scale = (0..UNKNOWNS).map(|a| stiffness[a][a]).fold(1e-6, f64::max);
        let matrix = faer::Mat::<f64>::from_fn(UNKNOWNS, UNKNOWNS, |a, b| match (used(a) && used(b), a == b) {
            (true, same) => stiffness[a][b] + if same { 1e-6 * scale } else { 0.0 },
            (false, same) => f64::from(u8::from(same)),
        });
        let right = faer::Mat::<f64>::from_fn(UNKNOWNS, 1, |a, _| if used(a) { gradient[a] } else { 0.0 });
        match matrix.llt(faer::Side::Lower) {
            Ok(factor) => {
                let x = faer::linalg::solvers::Solve::solve(&factor, &right);
                std::array::from_fn(|a| x[(a, 0)])
            }
            Err(_) => [0.0; UNKNOWNS],
        }
    }
}
