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

use crate::linear_response::first_contact::GeometricContact;
use crate::linear_response::pad_graph::PadGraph;
use crate::linear_response::{GraspLoad, amid, around};
use geometry::{Pose, Wrench};
use glam::{DMat3, DQuat, DVec3};
use model::Model;
use std::sync::Arc;

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
const FAR: f64 = 2.5;

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
    nearest: Vec<f64>,
    /// States of the path with their forces: first contact, `FIRST`, then steps by the factor `STEP` and the release,
    /// up to at least the largest force.
    path: Vec<(f64, Rest)>,
    /// Queries of the object at every face node of each pad at the end of the path.
    faces: Vec<Vec<Seen>>,
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
struct Seen {
    /// Distance; negative is inside.
    gap: f64,
    /// Outward normal of the object, pad frame; zero if it is out of reach.
    normal: DVec3,
    /// Queried point, moved back with the object to its pose at first contact; hand axes.
    place: DVec3,
}

/// Equilibrium of the grasp under a force.
#[derive(Debug, Clone, PartialEq)]
pub struct Rest {
    /// Travel of each finger since first contact.
    pub travel: [f64; 2],
    /// Translation of the point of the object midway between the pads.
    pub shift: DVec3,
    /// Rotation of the object.
    pub rotation: DQuat,
    /// Force on each basis function of each pad.
    pub force: Vec<Vec<DVec3>>,
    /// Displacement under each basis function.
    pub moved: Vec<Vec<DVec3>>,
    /// Moment on each pad about its closing direction by friction within the basis functions.
    pub twist: [f64; 2],
    /// Queries of the object at each basis function; empty for a state interpolated between two states of the path.
    seen: Vec<Vec<Seen>>,
}

impl Rest {
    /// Returns the linear interpolation towards another state, by the fraction `part`.
    fn towards(&self, other: &Self, part: f64) -> Self {
        let all = |from: &[Vec<DVec3>], to: &[Vec<DVec3>]| {
            let pads = from.iter().zip(to);
            pads.map(|(from, to)| from.iter().zip(to).map(|(a, b)| a.lerp(*b, part)).collect()).collect()
        };
        Self {
            travel: [0, 1].map(|k| self.travel[k] + part * (other.travel[k] - self.travel[k])),
            shift: self.shift.lerp(other.shift, part),
            rotation: self.rotation.lerp(other.rotation, part),
            force: all(&self.force, &other.force),
            moved: all(&self.moved, &other.moved),
            twist: [0, 1].map(|k| self.twist[k] + part * (other.twist[k] - self.twist[k])),
            seen: Vec::new(),
        }
    }
}

impl RigidEquilibrium {
    /// Creates the grasp of `model` from first contact `touch`, and its path to the model's largest force.
    pub fn new(model: &Model, graph: &Arc<PadGraph>, touch: &GeometricContact) -> Self {
        let (t, amid) = (graph.thickness, amid(model));
        let unit = model.material.moduli().young * t.powi(2);
        let finger = |(finger, travel): (&model::part::FingerModel, &f64)| {
            let place = &finger.placement;
            let origin = (place.place(DVec3::ZERO) + place.closing * *travel - amid) / t;
            Finger { closing: place.closing, rotation: place.rotation, origin }
        };
        let center = touch.object.position + touch.object.rotation * model.object.mass.center;
        let mut equilibrium = Self {
            fingers: model.fingers.iter().zip(&touch.travel).map(finger).collect(),
            graph: graph.clone(),
            friction: model.friction,
            weight: [touch.weight / unit, (center - amid) / t],
            free: model.free,
            held: true,
            release: model.release / unit,
            nearest: vec![0.0; model.fingers.len()],
            path: Vec::new(),
            faces: Vec::new(),
        };
        let object = Object { model, pose: touch.object, amid, thickness: t };
        let most = model.levels.iter().copied().fold(0.0, f64::max) / unit;
        let start = equilibrium.at_touch(&object);
        // First contact is that of the full face at a small clearance: gaps of the basis functions of each pad are
        // measured from the smallest one there.
        let nearest = |seen: &Vec<Seen>| seen.iter().map(|s| s.gap).fold(f64::INFINITY, f64::min);
        equilibrium.nearest = start.seen.iter().map(nearest).collect();
        let (mut force, mut rest) = (0.0, equilibrium.looked(start, &object));
        let release = equilibrium.release;
        while force < most {
            let next = f64::max(FIRST, force * STEP);
            let lets_go = equilibrium.free && force < release && release <= next;
            let next = if lets_go { release } else { next };
            let after = equilibrium.solve_and_query(&rest, next, &object);
            equilibrium.path.push((force, std::mem::replace(&mut rest, after)));
            force = next;
            if lets_go {
                equilibrium.held = false;
                let after = equilibrium.solve_and_query(&rest, force, &object);
                equilibrium.path.push((force.next_down(), std::mem::replace(&mut rest, after)));
            }
        }
        equilibrium.held = false;
        equilibrium.faces = (0..equilibrium.fingers.len()).map(|p| equilibrium.face(p, &rest, &object)).collect();
        equilibrium.path.push((force, rest));
        equilibrium
    }

    /// Returns true if a free object is still held fixed under `load`: its support carries its weight then, and it does
    /// not move.
    pub fn holds(&self, load: &GraspLoad) -> bool {
        self.free && load.force < self.release
    }

    /// Returns the force of `finger` under `load` at `rest`. Geared fingers share their force: around a held object in
    /// proportion to the resistance of their pads; else one carries more of the load on the object than the other.
    pub fn finger_force(&self, finger: usize, load: &GraspLoad, rest: &Rest) -> f64 {
        let fingers = self.fingers.len() as f64;
        if self.holds(load) {
            let resists = |pad: &Vec<DVec3>| -pad.iter().map(|force| force.z).sum::<f64>();
            let all: f64 = rest.force.iter().map(resists).sum();
            return if all > 0.0 { fingers * load.force * resists(&rest.force[finger]) / all } else { load.force };
        }
        let share = self.load_about_centre(load).force.dot(self.fingers[finger].closing) / fingers;
        if self.free { (load.force - share).max(LEAST * load.force) } else { load.force }
    }

    /// Returns the force and moment of weight and push on the object, about its centre of mass.
    pub fn load_about_centre(&self, load: &GraspLoad) -> Wrench {
        let weight = if self.holds(load) { DVec3::ZERO } else { self.weight[0] };
        Wrench { force: weight + load.push.force, torque: load.push.torque }
    }

    /// Returns the force and moment of weight and push on the object at `rest`, about the point midway between the
    /// pads.
    pub fn load_about_midpoint(&self, rest: &Rest, load: &GraspLoad) -> Wrench {
        let (Wrench { force, torque }, center) =
            (self.load_about_centre(load), rest.rotation * self.weight[1] + rest.shift);
        Wrench { force, torque: torque + center.cross(force) }
    }

    /// Returns the state under `load`: interpolated between two states of the path, then pushed.
    pub fn rest(&self, load: &GraspLoad) -> Rest {
        let squeezed = match (around(&self.path, load.force), self.path.last()) {
            (Some((before, after, part)), _) => before.towards(after, part),
            (None, Some((most, last))) if *most < load.force => self.follow(last, &load.force.into()).0,
            _ => self.path[0].1.clone(),
        };
        if load.push == Wrench::ZERO || !self.free { squeezed } else { self.pushed(&squeezed, load) }
    }

    /// Returns the equilibrium under a force, with the object queried there: solution and query alternate until the
    /// rigid motion is small.
    fn solve_and_query(&self, before: &Rest, force: f64, object: &Object) -> Rest {
        let mut rest = before.clone();
        for _ in 0..QUERIES {
            let (after, motion) = self.follow(&rest, &force.into());
            rest = self.looked(after, object);
            if motion < SETTLED_MOTION {
                break;
            }
        }
        rest
    }

    /// Returns the state after a push on the squeezed object. Gaps and normals are extrapolated from those of the first
    /// state of the path with at least its force.
    fn pushed(&self, squeezed: &Rest, load: &GraspLoad) -> Rest {
        let near = self.path.partition_point(|(force, _)| *force < load.force).min(self.path.len() - 1);
        let known = &self.path[near].1;
        let along = |pad: usize| {
            let functions = squeezed.moved[pad].iter().zip(&known.moved[pad]).zip(&self.graph.basis.rest);
            functions.zip(&known.seen[pad]).map(move |(((moved, then), at), seen)| {
                // The object is replaced by its tangent plane there.
                let place = |rest: &Rest, moved: DVec3| {
                    rest.rotation.inverse() * (self.place(pad, *at, moved, rest) - rest.shift)
                };
                let (now, then) = (place(squeezed, *moved), place(known, *then));
                let turn = self.fingers[pad].rotation.transpose();
                let normal =
                    turn * (squeezed.rotation * known.rotation.inverse() * (self.fingers[pad].rotation * seen.normal));
                let apart = turn * (squeezed.rotation * (now - then));
                Seen { gap: seen.gap + normal.dot(apart), normal, place: now }
            })
        };
        let seen = (0..self.fingers.len()).map(|pad| along(pad).collect()).collect();
        self.follow(&Rest { seen, ..squeezed.clone() }, load).0
    }

    /// Returns the depth that the object prescribes at each face node of `pad` along its normal, with this normal;
    /// negative is a gap.
    pub fn pressed(&self, pad: usize, rest: &Rest) -> Vec<(f64, DVec3)> {
        let inverse = self.fingers[pad].rotation.transpose();
        let along = |(seen, x): (&Seen, &DVec3)| {
            let apart = self.place(pad, *x, DVec3::ZERO, rest) - rest.rotation * seen.place - rest.shift;
            let apart = inverse * apart;
            (-seen.gap - seen.normal.dot(apart), seen.normal)
        };
        self.faces[pad].iter().zip(&self.graph.rest).map(along).collect()
    }

    /// Returns the position of a point of `pad` with reference position `at` (m, pad frame) and displacement `moved`.
    pub fn place(&self, pad: usize, at: DVec3, moved: DVec3, rest: &Rest) -> DVec3 {
        let Finger { closing, rotation, origin } = &self.fingers[pad];
        *rotation * (at / self.graph.thickness + moved) + *origin + *closing * rest.travel[pad]
    }

    /// Queries the object at the point `place` of `pad`, with the grasp at `rest`.
    fn see(&self, pad: usize, place: DVec3, rest: &Rest, object: &Object) -> Seen {
        let place = rest.rotation.inverse() * (place - rest.shift);
        let (gap, normal) = object.look(place);
        Seen {
            gap: gap - self.nearest[pad],
            normal: self.fingers[pad].rotation.transpose() * (rest.rotation * normal),
            place,
        }
    }

    /// Returns the state at first contact, without any force.
    fn at_touch(&self, object: &Object) -> Rest {
        let basis = &self.graph.basis;
        let all = || vec![vec![DVec3::ZERO; basis.count()]; self.fingers.len()];
        let rest = Rest {
            travel: [0.0; 2],
            shift: DVec3::ZERO,
            rotation: DQuat::IDENTITY,
            force: all(),
            moved: all(),
            twist: [0.0; 2],
            seen: Vec::new(),
        };
        self.looked(rest, object)
    }

    /// Returns `rest` with the object queried at its basis functions.
    fn looked(&self, mut rest: Rest, object: &Object) -> Rest {
        let basis = &self.graph.basis.rest;
        let of = |pad: usize| {
            let points = basis.iter().zip(&rest.moved[pad]);
            points.map(|(x, u)| self.see(pad, self.place(pad, *x, *u, &rest), &rest, object)).collect()
        };
        rest.seen = (0..self.fingers.len()).map(of).collect();
        rest
    }

    /// Queries the object at the face nodes of `pad`, with the grasp at `rest`.
    fn face(&self, pad: usize, rest: &Rest, object: &Object) -> Vec<Seen> {
        let graph = &self.graph;
        let forces = graph.basis.on_face(&rest.force[pad], graph.face.len());
        let moved = graph.compliance.on_face(&graph.face, &[forces]).remove(0);
        let see = |(x, u): (&DVec3, &DVec3)| {
            let seen = self.see(pad, self.place(pad, *x, *u, rest), rest, object);
            if seen.gap < FAR { seen } else { Seen { normal: DVec3::ZERO, ..seen } }
        };
        graph.rest.iter().zip(&moved).map(see).collect()
    }
}

/// Object in its pose at first contact.
struct Object<'a> {
    model: &'a Model,
    pose: Pose,
    amid: DVec3,
    thickness: f64,
}

impl Object<'_> {
    /// Returns the signed distance of a point, and the normal in hand axes.
    fn look(&self, place: DVec3) -> (f64, DVec3) {
        let at = self.pose.rotation.inverse() * (place * self.thickness + self.amid - self.pose.position);
        let closest = self.model.object.distance.closest(at, f64::INFINITY);
        closest.map_or((f64::MAX, DVec3::ZERO), |c| (c.distance / self.thickness, self.pose.rotation * c.normal))
    }
}
