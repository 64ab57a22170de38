//! The grasp on beds of springs (Winkler 1867): what imposed geometry and equilibrium alone say about travel, contact and
//! the motion of the object.
//!
//! Every face node is a spring, normal and tangential, of stiffness `modulus * E area / thickness`. It begins where the node
//! touches the object and sticks there up to Coulomb's limit. The object is rigid: its pose and the travel of the fingers
//! are in equilibrium with the springs, at forces that rise step by step. The network learns what the gel does differently.
//!
//! Dimensionless: lengths over the thickness t, forces over `E t^2`; hand axes, origin amid the pads.

use super::foundation::{Foundation, MODULUS};
use glam::DVec3;

/// Stiffness of a spring along the normal.
const NORMAL: f64 = MODULUS;
/// Along the face.
const TANGENTIAL: f64 = 0.6;
/// Forces at which the path of the springs is kept: each is this many times the one before.
const STEP: f64 = 1.4;
/// The first of them.
const FIRST: f64 = 1e-3;
/// Part of its force that a finger presses with at least, however heavy the object.
const LEAST: f64 = 0.05;
/// Unknowns: the travel of two fingers (of both, if they are geared, in the first), translation and rotation of the object.
const UNKNOWNS: usize = 8;

type Vector = [f64; UNKNOWNS];

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
    closing: Vec<DVec3>,
    friction: f64,
    /// Weight of the object.
    weight: DVec3,
    /// Whether the object may move.
    free: bool,
    /// The springs of each finger, pressed along the closing direction by themselves.
    alone: Vec<Foundation>,
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
    /// How far the object has dragged each spring along its surface.
    pub dragged: Vec<DVec3>,
}

impl Bed {
    /// Springs under forces up to `most` per finger.
    pub fn new(springs: Vec<Spring>, closing: Vec<DVec3>, friction: f64, weight: DVec3, free: bool, most: f64) -> Self {
        let alone = |finger: usize| {
            let own = springs.iter().filter(|s| s.finger == finger && s.normal != DVec3::ZERO);
            let (gap, area): (Vec<f64>, Vec<f64>) = own.map(|s| (s.gap, s.area)).unzip();
            Foundation::new(&gap, &area)
        };
        let alone = (0..closing.len()).map(alone).collect();
        let mut bed = Self { alone, springs, closing, friction, weight, free, path: Vec::new() };
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
        let share = self.weight.dot(self.closing[finger]) / self.closing.len() as f64;
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
        Rest {
            travel: [0.0; 2],
            shift: DVec3::ZERO,
            turn: DVec3::ZERO,
            pressed: self.springs.iter().map(|s| -s.gap * self.slope(s)).collect(),
            dragged: vec![DVec3::ZERO; self.springs.len()],
        }
    }

    /// Cosine between normal and closing direction.
    fn slope(&self, spring: &Spring) -> f64 {
        -spring.normal.dot(self.closing[spring.finger])
    }

    /// Equilibrium under `force` after `before`: Newton's method on the springs that touch.
    fn follow(&self, before: &Rest, force: f64) -> Rest {
        let mut step = [0.0; UNKNOWNS];
        if before.pressed.iter().all(|p| *p <= 0.0) {
            // Something to start from: each finger alone.
            for (finger, bed) in self.alone.iter().enumerate() {
                step[self.travel(finger)] = bed.depth(force);
            }
        }
        let mut now = self.moved(before, &step);
        for _ in 0..12 {
            let (mut gradient, mut stiffness) = ([0.0; UNKNOWNS], [[0.0; UNKNOWNS]; UNKNOWNS]);
            for finger in 0..self.closing.len() {
                gradient[self.travel(finger)] -= force;
            }
            for k in 0..3 {
                gradient[2 + k] = -self.weight[k];
            }
            for (i, s) in self.springs.iter().enumerate().filter(|(i, _)| now.pressed[*i] > 0.0) {
                let rows = self.rows(s);
                let (normal, along) = (NORMAL * s.area, TANGENTIAL * s.area);
                let pull = s.normal * (normal * now.pressed[i]) + now.dragged[i] * along;
                let part = touching(before.pressed[i], now.pressed[i]);
                for a in 0..UNKNOWNS {
                    gradient[a] -= pull.dot(rows[a]);
                    let across = rows[a] - s.normal * s.normal.dot(rows[a]);
                    let forced = s.normal * (normal * s.normal.dot(rows[a])) + across * (along * part);
                    for b in 0..UNKNOWNS {
                        stiffness[a][b] += forced.dot(rows[b]);
                    }
                }
            }
            let change = self.solve(stiffness, gradient);
            step = std::array::from_fn(|a| step[a] - change[a]);
            let next = self.moved(before, &step);
            let touches = |r: &Rest| r.pressed.iter().map(|p| *p > 0.0).collect::<Vec<_>>();
            let same = touches(&next) == touches(&now);
            now = next;
            if same && change.iter().all(|c| c.abs() < 1e-9) {
                break;
            }
        }
        // Friction carries no more than Coulomb's limit: what is beyond has slipped.
        for (dragged, pressed) in now.dragged.iter_mut().zip(&now.pressed) {
            *dragged = dragged.clamp_length_max(self.friction * NORMAL / TANGENTIAL * pressed.max(0.0));
        }
        now
    }

    /// How fast the face at a spring moves relative to the object, per unknown.
    fn rows(&self, s: &Spring) -> [DVec3; UNKNOWNS] {
        let mut rows = [DVec3::ZERO; UNKNOWNS];
        rows[self.travel(s.finger)] = self.closing[s.finger];
        for (k, axis) in DVec3::AXES.into_iter().enumerate() {
            rows[2 + k] = -axis;
            rows[5 + k] = -axis.cross(s.at);
        }
        rows
    }

    /// The springs `step` after `before`.
    fn moved(&self, before: &Rest, step: &Vector) -> Rest {
        let (shift, turn) = (DVec3::from_slice(&step[2..5]), DVec3::from_slice(&step[5..8]));
        let mut now = before.clone();
        (0..self.closing.len()).for_each(|finger| now.travel[finger] += step[self.travel(finger)]);
        now.shift += shift;
        now.turn += turn;
        for (i, s) in self.springs.iter().enumerate() {
            let slid = self.closing[s.finger] * step[self.travel(s.finger)] - shift - turn.cross(s.at);
            let into = -s.normal.dot(slid);
            now.pressed[i] += into;
            let part = touching(before.pressed[i], now.pressed[i]);
            // The object drags the node against the way that the node would have gone.
            now.dragged[i] = (before.dragged[i] - (slid + s.normal * into)) * part;
        }
        now
    }

    /// Solves for the unknowns that there are; a touch of stiffness holds what no spring holds.
    fn solve(&self, stiffness: [[f64; UNKNOWNS]; UNKNOWNS], gradient: Vector) -> Vector {
        let used = |a: usize| if a < 2 { (0..self.closing.len()).any(|f| self.travel(f) == a) } else { self.free };
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

/// Part of a step during which a spring touches.
fn touching(before: f64, now: f64) -> f64 {
    if now <= 0.0 {
        0.0
    } else if before >= 0.0 {
        1.0
    } else {
        now / (now - before)
    }
}
