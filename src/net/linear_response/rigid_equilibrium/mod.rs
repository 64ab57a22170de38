//! Grasp with pads that respond linearly: travel, contact and motion of the object from geometry, friction and
//! equilibrium alone.
//!
//! The object is rigid, and free or held; the pads respond to contact forces linearly, as in the reference state. The
//! force rises in steps: at each, distance and normal of the object are queried at the current pads, and `step.rs`
//! solves for contact forces, travel and pose together. This is repeated while the object moves far (one that is
//! released, or rolls). The network learns the effects of large strains.
//!
//! Quantities are dimensionless: lengths over the thickness t, forces over `E t^2`. Axes are those of the hand, with
//! the origin midway between the pads; those of a pad are in its frame.

mod step;

use crate::linear_response::contact_point::{BasisPoint, ContactPoint};
use crate::linear_response::first_contact::GeometricContact;
use crate::linear_response::pad_graph::PadGraph;
use crate::linear_response::{GraspLoad, enclosing_pair};
use geometry::{Pose, Wrench};
use glam::{DMat3, DQuat, DVec3};
use model::Model;
use std::sync::Arc;

/// Distance by which a point inside the object is moved back against the closing direction, over its depth.
const BACK: f64 = 2.0;
/// Force of each step of the path over that of the previous one.
const STEP: f64 = 1.5;
/// Force of the first step.
const FIRST: f64 = 1e-3;
/// Least force of a finger, over its nominal force, however heavy the object.
const LEAST: f64 = 0.05;
/// Largest number of queries of the object under one force.
const QUERIES: usize = 8;
/// Rigid motion, over the largest of a step, below which no further query is needed.
const SETTLED_MOTION: f64 = 0.1;
/// Gap from which on a face node is out of reach of the object.
const MAX_QUERY_GAP: f64 = 2.5;

/// Grasp, and its path from first contact to its largest force.
#[derive(Debug, Clone)]
pub struct RigidEquilibrium {
    fingers: Vec<Finger>,
    graph: Arc<PadGraph>,
    /// Coulomb's coefficient.
    friction: f64,
    /// Weight of the object, and its point of application at first contact.
    weight: [DVec3; 2],
    /// Flag: the object may move.
    pub(crate) free: bool,
    /// Flag: on the path that is being computed, the object is not released yet.
    held: bool,
    /// Force below which a free object is held fixed and its support carries its weight.
    release: f64,
    /// Smallest gap of the basis functions of each pad at first contact.
    smallest_gaps: Vec<f64>,
    /// States of the path with their forces: first contact, `FIRST`, then steps by the factor `STEP` and the release,
    /// up to at least the largest force.
    path: Vec<(f64, Equilibrium)>,
    /// Contact points of each pad, one for each face node.
    pub(crate) contact_points: Vec<Vec<ContactPoint>>,
    /// Contact points of the basis functions of each pad.
    basis_points: Vec<Vec<BasisPoint>>,
    /// Queries of the object at every contact point of each pad, at first contact and at the end of the path.
    face_queries: Vec<[Vec<QueriedPoint>; 2]>,
}

/// Frame of a finger.
#[derive(Debug, Clone)]
struct Finger {
    closing: DVec3,
    /// Rotation from its pad frame to the hand.
    rotation: DMat3,
    /// Origin of its pad at first contact.
    origin: DVec3,
}

/// Result of a query of the object at a point of a pad.
#[derive(Debug, Clone, Copy, PartialEq)]
struct QueriedPoint {
    /// Distance; negative is inside.
    gap: f64,
    /// Outward normal of the object, pad frame; zero if it is out of reach.
    normal: DVec3,
    /// Queried point, moved back with the object to its pose at first contact; hand axes.
    point: DVec3,
}

/// Equilibrium of the grasp under a force.
#[derive(Debug, Clone, PartialEq)]
pub struct Equilibrium {
    /// Travel of each finger since first contact.
    pub travel: [f64; 2],
    /// Translation of the point of the object midway between the pads.
    pub translation: DVec3,
    /// Rotation of the object.
    pub rotation: DQuat,
    /// Force on each basis function of each pad.
    pub force: Vec<Vec<DVec3>>,
    /// Displacement under each basis function.
    pub displacement: Vec<Vec<DVec3>>,
    /// Moment on each pad about its closing direction by friction within the basis functions.
    pub twist: [f64; 2],
    /// Queries of the object at each basis function; empty for a state interpolated between two states of the path.
    queries: Vec<Vec<QueriedPoint>>,
}

impl Equilibrium {
    /// Returns the linear interpolation towards another state, by the fraction `part`.
    fn interpolated(&self, other: &Self, part: f64) -> Self {
        let all = |from: &[Vec<DVec3>], to: &[Vec<DVec3>]| {
            let pads = from.iter().zip(to);
            pads.map(|(from, to)| from.iter().zip(to).map(|(a, b)| a.lerp(*b, part)).collect()).collect()
        };
        Self {
            travel: [0, 1].map(|k| self.travel[k] + part * (other.travel[k] - self.travel[k])),
            translation: self.translation.lerp(other.translation, part),
            rotation: self.rotation.lerp(other.rotation, part),
            force: all(&self.force, &other.force),
            displacement: all(&self.displacement, &other.displacement),
            twist: [0, 1].map(|k| self.twist[k] + part * (other.twist[k] - self.twist[k])),
            queries: Vec::new(),
        }
    }
}

impl RigidEquilibrium {
    /// Creates the grasp of `model` from first contact `touch`, and its path to the model's largest force.
    pub fn new(
        model: &Model,
        graph: &Arc<PadGraph>,
        touch: &GeometricContact,
        contact_points: Vec<Vec<ContactPoint>>,
    ) -> Self {
        let (t, midpoint) = (graph.thickness, model.midpoint_between_pads());
        let unit = model.material.moduli().young * t.powi(2);
        let finger = |(finger, travel): (&model::part::FingerModel, &f64)| {
            let place = &finger.placement;
            let origin = (place.place(DVec3::ZERO) + place.closing * *travel - midpoint) / t;
            Finger { closing: place.closing, rotation: place.rotation, origin }
        };
        let center = touch.object.position + touch.object.rotation * model.object.mass.center;
        let mut equilibrium = Self {
            fingers: model.fingers.iter().zip(&touch.travel).map(finger).collect(),
            graph: graph.clone(),
            friction: model.friction,
            weight: [touch.weight / unit, (center - midpoint) / t],
            free: model.free,
            held: true,
            release: model.release / unit,
            smallest_gaps: vec![0.0; model.fingers.len()],
            path: Vec::new(),
            basis_points: contact_points.iter().map(|points| BasisPoint::all(graph, points)).collect(),
            contact_points,
            face_queries: Vec::new(),
        };
        let object = Object { model, pose: touch.object, midpoint, thickness: t };
        let most = model.levels.iter().copied().fold(0.0, f64::max) / unit;
        let start = equilibrium.first_contact(&object);
        // First contact is that of the full face at a small clearance: gaps of the basis functions of each pad are
        // measured from the smallest one there.
        let nearest = |seen: &Vec<QueriedPoint>| seen.iter().map(|s| s.gap).fold(f64::INFINITY, f64::min);
        equilibrium.smallest_gaps = start.queries.iter().map(nearest).collect();
        let (mut force, mut state) = (0.0, equilibrium.with_queries(start, &object));
        let release = equilibrium.release;
        while force < most {
            let next = f64::max(FIRST, force * STEP);
            let lets_go = equilibrium.free && force < release && release <= next;
            let next = if lets_go { release } else { next };
            let after = equilibrium.solve_and_query(&state, next, &object);
            equilibrium.path.push((force, std::mem::replace(&mut state, after)));
            force = next;
            if lets_go {
                equilibrium.held = false;
                let after = equilibrium.solve_and_query(&state, force, &object);
                equilibrium.path.push((force.next_down(), std::mem::replace(&mut state, after)));
            }
        }
        equilibrium.held = false;
        let ends = |p: usize| [&equilibrium.path[0].1, &state].map(|at| equilibrium.query_face(p, at, &object));
        equilibrium.face_queries = (0..equilibrium.fingers.len()).map(ends).collect();
        equilibrium.path.push((force, state));
        equilibrium
    }

    /// Returns true if a free object is still held fixed under `load`: its support carries its weight then, and it does
    /// not move.
    pub fn is_held_fixed(&self, load: &GraspLoad) -> bool {
        self.free && load.force < self.release
    }

    /// Returns the force of `finger` under `load` at `state`. Geared fingers share their force: around a held object in
    /// proportion to the resistance of their pads; else one carries more of the load on the object than the other.
    pub fn finger_force(&self, finger: usize, load: &GraspLoad, state: &Equilibrium) -> f64 {
        let fingers = self.fingers.len() as f64;
        if self.is_held_fixed(load) {
            let resists = |pad: &Vec<DVec3>| -pad.iter().map(|force| force.z).sum::<f64>();
            let all: f64 = state.force.iter().map(resists).sum();
            // One pad may not touch the object at all.
            let part = if all > 0.0 { fingers * resists(&state.force[finger]) / all } else { 1.0 };
            return part.max(LEAST) * load.force;
        }
        let share = self.load_about_centre(load).force.dot(self.fingers[finger].closing) / fingers;
        if self.free { (load.force - share).max(LEAST * load.force) } else { load.force }
    }

    /// Returns the force and moment of weight and push on the object, about its centre of mass.
    pub fn load_about_centre(&self, load: &GraspLoad) -> Wrench {
        let weight = if self.is_held_fixed(load) { DVec3::ZERO } else { self.weight[0] };
        Wrench { force: weight + load.push.force, torque: load.push.torque }
    }

    /// Returns the force and moment of weight and push on the object at `state`, about the point midway between the
    /// pads.
    pub fn load_about_midpoint(&self, state: &Equilibrium, load: &GraspLoad) -> Wrench {
        let (Wrench { force, torque }, center) =
            (self.load_about_centre(load), state.rotation * self.weight[1] + state.translation);
        Wrench { force, torque: torque + center.cross(force) }
    }

    /// Returns the state under `load`: interpolated between two states of the path, then pushed.
    pub fn equilibrium(&self, load: &GraspLoad) -> Equilibrium {
        let squeezed = match (enclosing_pair(&self.path, load.force), self.path.last()) {
            (Some((before, after, part)), _) => before.interpolated(after, part),
            (None, Some((most, last))) if *most < load.force => self.solve_equilibrium(last, &load.force.into()).0,
            _ => self.path[0].1.clone(),
        };
        if load.push == Wrench::ZERO || !self.free { squeezed } else { self.under_push(&squeezed, load) }
    }

    /// Returns the equilibrium under a force, with the object queried there: solution and query alternate until the
    /// rigid motion is small.
    fn solve_and_query(&self, before: &Equilibrium, force: f64, object: &Object) -> Equilibrium {
        let mut state = before.clone();
        for _ in 0..QUERIES {
            let (after, motion) = self.solve_equilibrium(&state, &force.into());
            state = self.with_queries(after, object);
            if motion < SETTLED_MOTION {
                break;
            }
        }
        state
    }

    /// Returns the state after a push on the squeezed object. Gaps and normals are extrapolated from those of the first
    /// state of the path with at least its force.
    fn under_push(&self, squeezed: &Equilibrium, load: &GraspLoad) -> Equilibrium {
        let near = self.path.partition_point(|(force, _)| *force < load.force).min(self.path.len() - 1);
        let known = &self.path[near].1;
        let along = |pad: usize| {
            let functions =
                squeezed.displacement[pad].iter().zip(&known.displacement[pad]).zip(&self.basis_points[pad]);
            functions.zip(&known.queries[pad]).map(move |(((moved, then), at), seen)| {
                // The object is replaced by its tangent plane there.
                let place = |state: &Equilibrium, moved: DVec3| {
                    state.rotation.inverse() * (self.hand_position(pad, at.position, moved, state) - state.translation)
                };
                let (now, then) = (place(squeezed, *moved), place(known, *then));
                let turn = self.fingers[pad].rotation.transpose();
                let normal =
                    turn * (squeezed.rotation * known.rotation.inverse() * (self.fingers[pad].rotation * seen.normal));
                let apart = turn * (squeezed.rotation * (now - then));
                QueriedPoint { gap: seen.gap + normal.dot(apart), normal, point: now }
            })
        };
        let queries = (0..self.fingers.len()).map(|pad| along(pad).collect()).collect();
        self.solve_equilibrium(&Equilibrium { queries, ..squeezed.clone() }, load).0
    }

    /// Returns the depth that the object prescribes at each contact point of `pad` along its normal, with this normal;
    /// negative is a gap.
    pub fn prescribed_depths(&self, pad: usize, state: &Equilibrium) -> Vec<(f64, DVec3)> {
        let inverse = self.fingers[pad].rotation.transpose();
        // A tangent plane of the object predicts the depth near the state in which it was found.
        let end = self.path.last().map_or(0.0, |(_, end)| end.travel[pad]);
        let part = if end > 0.0 { (state.travel[pad] / end).clamp(0.0, 1.0) } else { 1.0 };
        let along = |(at, (first, last)): (&ContactPoint, (&QueriedPoint, &QueriedPoint))| {
            let depth = |seen: &QueriedPoint| {
                let apart = self.hand_position(pad, at.position, DVec3::ZERO, state)
                    - state.rotation * seen.point
                    - state.translation;
                -seen.gap - seen.normal.dot(inverse * apart)
            };
            if at.node().is_none() && first.normal != DVec3::ZERO {
                return (depth(first), first.normal);
            }
            if first.normal == DVec3::ZERO || last.normal == DVec3::ZERO {
                return (depth(last), last.normal);
            }
            (depth(first) + part * (depth(last) - depth(first)), last.normal)
        };
        let [first, last] = &self.face_queries[pad];
        self.contact_points[pad].iter().zip(first.iter().zip(last)).map(along).collect()
    }

    /// Returns the position of a point of `pad` with reference position `at` (m, pad frame) and displacement `moved`.
    pub fn hand_position(&self, pad: usize, at: DVec3, moved: DVec3, state: &Equilibrium) -> DVec3 {
        let Finger { closing, rotation, origin } = &self.fingers[pad];
        *rotation * (at / self.graph.thickness + moved) + *origin + *closing * state.travel[pad]
    }

    /// Queries the object at the point `place` of `pad`, with the grasp at `state`.
    fn query_point(&self, pad: usize, place: DVec3, state: &Equilibrium, object: &Object) -> QueriedPoint {
        let inverse = state.rotation.inverse();
        let point = inverse * (place - state.translation);
        let (mut gap, mut normal) = object.distance_and_normal(point);
        if gap < 0.0 {
            // Inside the object the nearest face may be another one than the pad has met: seen from before that face,
            // its tangent plane is extended to the point.
            let back = inverse * self.fingers[pad].closing * (BACK * gap);
            let (before, met) = object.distance_and_normal(point + back);
            if before > 0.0 {
                (gap, normal) = (before - met.dot(back), met);
            }
        }
        QueriedPoint {
            gap: gap - self.smallest_gaps[pad],
            normal: self.fingers[pad].rotation.transpose() * (state.rotation * normal),
            point,
        }
    }

    /// Returns the state at first contact, without any force.
    fn first_contact(&self, object: &Object) -> Equilibrium {
        let basis = &self.graph.basis;
        let all = || vec![vec![DVec3::ZERO; basis.count()]; self.fingers.len()];
        let state = Equilibrium {
            travel: [0.0; 2],
            translation: DVec3::ZERO,
            rotation: DQuat::IDENTITY,
            force: all(),
            displacement: all(),
            twist: [0.0; 2],
            queries: Vec::new(),
        };
        self.with_queries(state, object)
    }

    /// Returns `state` with the object queried at its basis functions.
    fn with_queries(&self, mut state: Equilibrium, object: &Object) -> Equilibrium {
        let of = |pad: usize| {
            let points = self.basis_points[pad].iter().zip(&state.displacement[pad]);
            points
                .map(|(x, u)| self.query_point(pad, self.hand_position(pad, x.position, *u, &state), &state, object))
                .collect()
        };
        state.queries = (0..self.fingers.len()).map(of).collect();
        state
    }

    /// Queries the object at the contact points of `pad`, with the grasp at `state`.
    fn query_face(&self, pad: usize, state: &Equilibrium, object: &Object) -> Vec<QueriedPoint> {
        let graph = &self.graph;
        let forces = graph.basis.face_forces(&state.force[pad], graph.face.len());
        let moved = graph.compliance.face_displacements(&graph.face, &[forces]).remove(0);
        let see = |at: &ContactPoint| {
            let moved = at.interpolate(&moved);
            let seen = self.query_point(pad, self.hand_position(pad, at.position, moved, state), state, object);
            if seen.gap < MAX_QUERY_GAP { seen } else { QueriedPoint { normal: DVec3::ZERO, ..seen } }
        };
        self.contact_points[pad].iter().map(see).collect()
    }
}

/// Object in its pose at first contact.
struct Object<'a> {
    model: &'a Model,
    pose: Pose,
    midpoint: DVec3,
    thickness: f64,
}

impl Object<'_> {
    /// Returns the signed distance of a point, and the normal in hand axes.
    fn distance_and_normal(&self, place: DVec3) -> (f64, DVec3) {
        let at = self.pose.rotation.inverse() * (place * self.thickness + self.midpoint - self.pose.position);
        let closest = self.model.object.distance.closest(at, f64::INFINITY);
        closest.map_or((f64::MAX, DVec3::ZERO), |c| (c.distance / self.thickness, self.pose.rotation * c.normal))
    }
}
