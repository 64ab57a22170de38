//! The unknowns of a grasp, and the few rigid unknowns that all bodies share.

use super::stencil::Stencil;
use super::time_step::TimeStep;
use geometry::Pose;
use glam::{DMat3, DQuat, DVec3};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Maximum number of rigid unknowns of a scene: two travels and six of a free object.
pub const MAX_RIGID: usize = 8;

/// Configuration of all bodies. Pad nodes are stored relative to their finger, in hand axes: the position in the hand
/// frame is `x + travel * closing`, so that elasticity does not depend on the travel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Node positions of each body, m, relative to the finger.
    pub x: Vec<Vec<DVec3>>,
    /// Travel of each finger along its closing direction, m.
    pub travel: Vec<f64>,
    /// Object origin in the hand frame, m.
    pub position: DVec3,
    /// Object orientation in the hand frame.
    pub rotation: DQuat,
}

impl State {
    /// Returns the pose of the object in the hand frame.
    pub fn pose(&self) -> Pose {
        Pose { position: self.position, rotation: self.rotation }
    }
}

/// Layout of the rigid unknowns: which travels are unknown, and whether the object's pose is.
#[derive(Debug, Clone)]
pub struct RigidUnknowns {
    /// Closing direction of each body's finger, unit, hand frame.
    pub closing: Vec<DVec3>,
    /// Column of each finger's travel; None where it is prescribed.
    pub travel: Vec<Option<usize>>,
    /// First of the six columns of the object's pose (translation, then rotation); None for a fixed object.
    pub pose: Option<usize>,
    /// Length that converts rotations to metres of surface motion, m: the object's bounding radius.
    pub length: f64,
    /// Number of columns.
    pub size: usize,
}

impl RigidUnknowns {
    /// Creates a layout without rigid unknowns: bodies alone, with stationary fingers.
    pub fn none(bodies: usize) -> Self {
        Self { closing: vec![DVec3::ZERO; bodies], travel: vec![None; bodies], pose: None, length: 1.0, size: 0 }
    }

    /// Creates the layout for fingers with the given closing directions; `driven` fingers are pushed by a force, others
    /// have a prescribed travel.
    pub fn new(closing: Vec<DVec3>, driven: bool, free_object: bool, length: f64) -> Self {
        let fingers = if driven { closing.len() } else { 0 };
        let travel = (0..closing.len()).map(|i| driven.then_some(i)).collect();
        let size = fingers + if free_object { 6 } else { 0 };
        Self { closing, travel, pose: free_object.then_some(fingers), length, size }
    }
}

impl RigidUnknowns {
    /// Creates the layout for geared fingers, which share one travel.
    pub fn geared(closing: Vec<DVec3>, driven: bool, free_object: bool, length: f64) -> Self {
        let travels = usize::from(driven && !closing.is_empty());
        let travel = closing.iter().map(|_| driven.then_some(0)).collect();
        let size = travels + if free_object { 6 } else { 0 };
        Self { closing, travel, pose: free_object.then_some(travels), length, size }
    }

    /// Difference between the rigid unknowns of `to` and those of `from`, m per column.
    pub fn difference(&self, to: &State, from: &State) -> [f64; MAX_RIGID] {
        let mut d = [0.0; MAX_RIGID];
        for (i, column) in self.travel.iter().enumerate() {
            if let Some(c) = column {
                d[*c] = to.travel[i] - from.travel[i];
            }
        }
        if let Some(c) = self.pose {
            let turn = turn(to.rotation * from.rotation.inverse()) * self.length;
            d[c..c + 3].copy_from_slice(&(to.position - from.position).to_array());
            d[c + 3..c + 6].copy_from_slice(&turn.to_array());
        }
        d
    }

    /// Norm of that difference, m.
    pub fn distance(&self, to: &State, from: &State) -> f64 {
        self.difference(to, from).iter().map(|d| d * d).sum::<f64>().sqrt()
    }
}

/// Rotation vector, rad; accurate also for tiny rotations, which glam rounds to zero.
fn turn(q: DQuat) -> DVec3 {
    let (half, cosine) = (q.xyz(), q.w);
    let sine = half.length();
    if sine < 1e-8 { half * (2.0 * cosine.signum()) } else { q.to_scaled_axis() }
}

/// A Newton step: increments of every unknown.
#[derive(Debug, Clone)]
pub struct NewtonStep {
    /// Increment per body and node, m.
    pub x: Vec<Vec<DVec3>>,
    /// Increment per rigid column, m.
    pub rigid: [f64; MAX_RIGID],
}

impl NewtonStep {
    /// Euclidean norm over all unknowns, m.
    pub fn norm(&self) -> f64 {
        self.dot(self).sqrt()
    }

    /// Euclidean norm over the rigid columns, m.
    pub fn rigid_norm(&self) -> f64 {
        self.rigid.iter().map(|d| d * d).sum::<f64>().sqrt()
    }

    /// Scalar product over all unknowns, m2.
    pub fn dot(&self, other: &NewtonStep) -> f64 {
        let nodes = self.x.iter().flatten().zip(other.x.iter().flatten()).map(|(a, b)| a.dot(*b)).sum::<f64>();
        nodes + self.rigid.iter().zip(&other.rigid).map(|(a, b)| a * b).sum::<f64>()
    }

    /// Adds `factor` times `other`.
    pub fn add(&mut self, other: &NewtonStep, factor: f64) {
        self.x.iter_mut().flatten().zip(other.x.iter().flatten()).for_each(|(a, b)| *a += *b * factor);
        self.rigid.iter_mut().zip(&other.rigid).for_each(|(a, b)| *a += b * factor);
    }

    /// Multiplies every increment by `factor`.
    pub fn scale(&mut self, factor: f64) {
        self.x.iter_mut().flatten().for_each(|d| *d *= factor);
        self.rigid.iter_mut().for_each(|d| *d *= factor);
    }

    /// Motion of body `index`, and of the frames that it interacts with, in this step.
    pub fn motion<'a>(&'a self, index: usize, view: &BodyView) -> BodyMotion<'a> {
        let offset = view.travel_column.map_or(DVec3::ZERO, |c| view.closing * self.rigid[c]);
        BodyMotion { x: &self.x[index], offset, object: self.object_motion(&view.object) }
    }

    /// Motion of the object in this step.
    pub fn object_motion(&self, view: &ObjectView) -> ObjectIncrement {
        let three = |c: usize| DVec3::new(self.rigid[c], self.rigid[c + 1], self.rigid[c + 2]);
        let pose = view.column.map(|c| ObjectIncrement { position: three(c), rotation: three(c + 3) / view.length });
        pose.unwrap_or_default()
    }
}

/// A small motion of a body, its finger and the object.
#[derive(Debug, Clone, Copy)]
pub struct BodyMotion<'a> {
    /// Motion of the nodes relative to the finger, m.
    pub x: &'a [DVec3],
    /// Motion of the finger, m.
    pub offset: DVec3,
    /// Motion of the object.
    pub object: ObjectIncrement,
}

/// A small motion of the object.
#[derive(Debug, Clone, Copy, Default)]
pub struct ObjectIncrement {
    /// Motion of the origin, m.
    pub position: DVec3,
    /// Rotation about the origin, rad.
    pub rotation: DVec3,
}

impl ObjectIncrement {
    /// Motion of the object's point at arm `r` (m from the origin), m.
    pub fn at(&self, r: DVec3) -> DVec3 {
        self.position + self.rotation.cross(r)
    }
}

impl BodyMotion<'_> {
    /// Motion of the point of the body at `stencil` relative to the object's point at arm `r` (m from the origin), m.
    pub fn relative(&self, stencil: &Stencil, r: DVec3) -> DVec3 {
        stencil.position(self.x) + self.offset - self.object.position - self.object.rotation.cross(r)
    }
}

impl State {
    /// Returns this state moved by `alpha * step`; rotations are updated multiplicatively.
    pub fn moved(&self, rigid: &RigidUnknowns, step: &NewtonStep, alpha: f64) -> State {
        let mut next = self.clone();
        for (x, d) in next.x.iter_mut().zip(&step.x) {
            for (x, d) in x.iter_mut().zip(d) {
                *x += *d * alpha;
            }
        }
        for (t, column) in next.travel.iter_mut().zip(&rigid.travel) {
            if let Some(c) = column {
                *t += alpha * step.rigid[*c];
            }
        }
        if let Some(c) = rigid.pose {
            let b = &step.rigid[c..];
            next.position += DVec3::new(b[0], b[1], b[2]) * alpha;
            let rotation = DVec3::new(b[3], b[4], b[5]) * (alpha / rigid.length);
            next.rotation = (DQuat::from_scaled_axis(rotation) * self.rotation).normalize();
        }
        next
    }

    /// Linear extrapolation `self + factor (self - before)`.
    pub fn extrapolated(&self, before: &State, factor: f64) -> State {
        let mut next = self.clone();
        for (body, (now, old)) in next.x.iter_mut().zip(self.x.iter().zip(&before.x)) {
            for (x, (a, b)) in body.iter_mut().zip(now.iter().zip(old)) {
                *x = *a + (*a - *b) * factor;
            }
        }
        for (t, (a, b)) in next.travel.iter_mut().zip(self.travel.iter().zip(&before.travel)) {
            *t = a + (a - b) * factor;
        }
        next.position = self.position + (self.position - before.position) * factor;
        let turn = (self.rotation * before.rotation.inverse()).to_scaled_axis();
        next.rotation = (DQuat::from_scaled_axis(turn * factor) * self.rotation).normalize();
        next
    }

    /// View of the state from body `index`.
    pub fn view<'a>(&'a self, index: usize, rigid: &'a RigidUnknowns) -> BodyView<'a> {
        BodyView {
            x: &self.x[index],
            offset: rigid.closing[index] * self.travel[index],
            closing: rigid.closing[index],
            travel_column: rigid.travel[index],
            object: self.object_view(rigid),
        }
    }

    /// View of the object's pose.
    pub fn object_view(&self, rigid: &RigidUnknowns) -> ObjectView {
        let rotation = DMat3::from_quat(self.rotation);
        ObjectView { position: self.position, rotation, column: rigid.pose, length: rigid.length }
    }
}

/// The accepted state from which an increment starts, for one body.
#[derive(Debug, Clone)]
pub struct IncrementStart {
    state: Arc<State>,
    index: usize,
    offset: DVec3,
    turn: DMat3,
    /// Time step of the increment; None on a quasi-static path.
    pub step: Option<TimeStep>,
}

impl IncrementStart {
    /// Creates the start of an increment of body `index` from `state`.
    pub fn new(state: Arc<State>, index: usize, rigid: &RigidUnknowns, step: Option<TimeStep>) -> Self {
        let view = state.view(index, rigid);
        let (offset, turn) = (view.offset, view.object.rotation);
        Self { state, index, offset, turn, step }
    }

    /// Position of a point of the body at the start of the increment, relative to its finger, m.
    pub fn point(&self, stencil: &Stencil) -> DVec3 {
        stencil.position(&self.state.x[self.index])
    }

    /// Position of that point in the object's frame, m.
    pub fn in_object(&self, stencil: &Stencil) -> DVec3 {
        self.turn.transpose() * (self.point(stencil) + self.offset - self.state.position)
    }

    /// Position of the point `p` of the object (object frame, m) at the start of the increment, relative to the finger,
    /// m.
    pub fn of_object(&self, p: DVec3) -> DVec3 {
        self.state.position + self.turn * p - self.offset
    }
}

/// View of the state from one body: its nodes and the rigid frames that it interacts with.
#[derive(Debug, Clone, Copy)]
pub struct BodyView<'a> {
    /// Node positions relative to the finger, m.
    pub x: &'a [DVec3],
    /// Finger displacement, m, hand frame.
    pub offset: DVec3,
    /// Closing direction, unit.
    pub closing: DVec3,
    /// Rigid column of the travel.
    pub travel_column: Option<usize>,
    /// Pose of the object.
    pub object: ObjectView,
}

/// Pose of the object, and its columns among the rigid unknowns.
#[derive(Debug, Clone, Copy)]
pub struct ObjectView {
    /// Object origin, m.
    pub position: DVec3,
    /// Object orientation.
    pub rotation: DMat3,
    /// First rigid column of the pose; None for a fixed object.
    pub column: Option<usize>,
    /// Length scale of rotations, m.
    pub length: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiny_rotations_are_felt() {
        for angle in [1e-14, 1e-9, 1e-3, 2.0] {
            let vector = DVec3::new(0.6, 0.0, -0.8) * angle;
            let felt = turn(DQuat::from_scaled_axis(vector));
            assert!(felt.distance(vector) <= 1e-12 * angle, "{felt} rad, not {vector} rad");
        }
    }
}
