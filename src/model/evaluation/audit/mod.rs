//! Independent audit of recorded frames: what a scene expects about inversion, penetration and equilibrium is checked
//! from the node positions alone. It shares with the solver the data of a scene and the strain energy density of the
//! gel, but not the solver's code.
//!
//! | expectation | checked by |
//! |---|---|
//! | finite | every number of the frame |
//! | no inversion | [`inversion`]: det F at corners, edge midpoints, quadrature points and centre of each tetrahedron |
//! | no penetration | [`penetration`]: points of pads against [`solid`], of object and other pad against tetrahedra |
//! | converged | [`equilibrium`]: elastic forces of the recorded positions ([`elasticity`]) against the loads |
//!
//! Apart from finiteness, only the checks that the expectations of a scene need are computed.

pub mod columns;
pub mod elasticity;
pub mod equilibrium;
pub mod inversion;
pub mod penetration;
pub mod solid;
pub mod tetrahedra;
pub mod triangle;

use crate::part::FingerModel;
use geometry::shape::Shape;
use glam::DVec3;
use penetration::{ObjectPoints, PadSurface};
use rayon::prelude::*;
use record::Frame;
use scene::{self, Expectation};
use serde::Serialize;
use solid::Solid;
use tetrahedra::Tetrahedra;

/// Findings of the audit of a frame, or of all frames of a grasp.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Findings {
    /// True if every number is finite.
    pub finite: bool,
    /// Smallest det F; positive if nothing is inverted. NaN, like the penetration and the imbalance, if no expectation
    /// is about it.
    pub min_det_f: f64,
    /// Largest penetration depth of pads and object in each other, m; zero if they do not overlap.
    pub penetration: f64,
    /// Contact offset, m; smaller depths are not resolved.
    pub offset: f64,
    /// Largest unbalanced force over the force of a finger.
    pub imbalance: f64,
}

impl Findings {
    /// Returns true if the state is admissible: every number is finite, and no element was found to be inverted.
    pub fn is_admissible(&self) -> bool {
        self.finite && (self.min_det_f.is_nan() || self.min_det_f > 0.0)
    }

    /// Returns the worse value of both for every finding; NaN (not measured) is worse than any number.
    pub fn merge_worst(self, other: Self) -> Self {
        let pick =
            |a: f64, b: f64, worse: fn(f64, f64) -> f64| if a.is_nan() || b.is_nan() { f64::NAN } else { worse(a, b) };
        Self {
            finite: self.finite && other.finite,
            min_det_f: pick(self.min_det_f, other.min_det_f, f64::min),
            penetration: pick(self.penetration, other.penetration, f64::max),
            offset: self.offset.max(other.offset),
            imbalance: pick(self.imbalance, other.imbalance, f64::max),
        }
    }
}

/// Checks that the expectations of a scene need.
#[derive(Debug)]
struct RequestedChecks {
    inversion: bool,
    penetration: bool,
    equilibrium: bool,
}

/// Auditor of a scene, with the data that are the same for all frames.
#[derive(Debug)]
pub struct Auditor {
    asked: RequestedChecks,
    solid: Solid,
    object: ObjectPoints,
    pads: Vec<PadSurface>,
    /// Contact offset, m.
    offset: f64,
}

impl Auditor {
    /// Creates the auditor for the expectations `expectations` about the scene's object with the geometry `shape`, and its
    /// fingers; `offset` is the contact offset, m.
    pub fn new(
        expectations: &[Expectation],
        object: &scene::Object,
        shape: &Shape,
        fingers: &[FingerModel],
        offset: f64,
    ) -> Self {
        let pads: Vec<_> = fingers.iter().map(|f| PadSurface::new(&f.topology)).collect();
        let spacing = pads.iter().map(|p| p.spacing).fold(f64::INFINITY, f64::min);
        let (solid, object) =
            (Solid::new(object, shape), ObjectPoints::new(&shape.surface, shape.has_display_mesh(), spacing));
        let asked = |of: fn(&Expectation) -> bool| expectations.iter().any(of);
        let asked = RequestedChecks {
            inversion: asked(|e| matches!(e, Expectation::NoInversion)),
            penetration: asked(|e| matches!(e, Expectation::NoPenetration | Expectation::Penetration(_))),
            equilibrium: asked(|e| matches!(e, Expectation::Converged(_))),
        };
        Self { asked, solid, object, pads, offset }
    }

    /// Audits a frame of the same fingers; `gravity` is in the hand frame, m/s2.
    pub fn audit(&self, fingers: &[FingerModel], frame: &Frame, gravity: DVec3) -> Findings {
        let offset = self.offset;
        if !finite(frame) {
            let nan = f64::NAN;
            return Findings { finite: false, min_det_f: nan, penetration: nan, offset, imbalance: nan };
        }
        let det = || {
            let pads = fingers.iter().zip(&frame.pads);
            pads.map(|(f, pad)| inversion::min_det_f(&f.topology, &pad.position)).fold(f64::INFINITY, f64::min)
        };
        let imbalance = || equilibrium::imbalance(fingers, &self.pads, frame, gravity);
        let if_asked = |asked: bool, of: &dyn Fn() -> f64| if asked { of() } else { f64::NAN };
        let (penetration, (min_det_f, imbalance)) = rayon::join(
            || if_asked(self.asked.penetration, &|| self.penetration(fingers, frame)),
            || (if_asked(self.asked.inversion, &det), if_asked(self.asked.equilibrium, &imbalance)),
        );
        Findings { finite: true, min_det_f, penetration, offset, imbalance }
    }

    /// Returns the largest penetration depth of pads and object in each other, m.
    fn penetration(&self, fingers: &[FingerModel], frame: &Frame) -> f64 {
        let inverse = frame.object_rotation.inverse();
        let placed = |p: &DVec3| inverse * (*p - frame.object_position);
        let x: Vec<Vec<DVec3>> = frame.pads.iter().map(|pad| pad.position.iter().map(placed).collect()).collect();
        let depth = |(i, (finger, pad)): (usize, (&FingerModel, &PadSurface))| {
            let tets = Tetrahedra::new(&finger.topology, &x[i]);
            let mut depth = pad.depth(&tets, &self.solid, &self.object);
            for j in (0..x.len()).filter(|j| *j != i) {
                let surface = x[j].iter().zip(&self.pads[j].free).filter(|(_, free)| **free).map(|(p, _)| *p);
                depth = depth.max(pad.depth_of_nodes(&tets, surface));
            }
            depth
        };
        fingers.par_iter().zip(&self.pads).enumerate().map(depth).reduce(|| 0.0, f64::max)
    }
}

/// Returns true if every number of the frame is finite.
fn finite(frame: &Frame) -> bool {
    let scalars =
        [frame.applied_force, frame.time, frame.energy, frame.residual, frame.force_balance, frame.torque_balance];
    let rigid = frame.object_position.is_finite() && frame.object_rotation.is_finite();
    let pad = |p: &record::PadFrame| {
        let vectors = p.position.iter().chain(&p.displacement).chain(&p.contact_force);
        vectors.into_iter().all(|v| v.is_finite())
            && p.von_mises_node.iter().chain(&p.von_mises_element).chain(&p.gap).all(|v| v.is_finite())
            && p.wrench.force.is_finite()
            && p.wrench.torque.is_finite()
    };
    rigid && scalars.iter().chain(&frame.travel).all(|v| v.is_finite()) && frame.pads.iter().all(pad)
}
