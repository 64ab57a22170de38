//! Features of a grasp, computed by this module alone, for training and inference alike.
//!
//! All features are dimensionless: lengths over the pad's thickness t, forces over `E t^2`, stresses over E.
//! Quasi-static elasticity has no other scale, so modulus and thickness need not be learnt. The features of every pad
//! are in its own frame. The [`Parity`] of each feature states how it changes when the scene is mirrored (x -> -x or y
//! -> -y of the pad).

pub mod loads;
pub mod normalise;
mod object_query;
pub mod pad_range;
mod parity;
pub mod range;
mod sub_element;
pub mod volume;

use self::object_query::ObjectQuery;
use self::parity::Parity::{Even, X, Y};
pub use self::parity::{Parity, ROTATION, VECTOR};
use self::sub_element::SmallestGap;
use self::volume::VolumeGraph;
use crate::linear_response::first_contact::GeometricContact;
use crate::linear_response::pad_graph::{Layout, PadGraph};
use crate::linear_response::rigid_equilibrium::RigidEquilibrium;
use crate::matrix::Sparse;
use geometry::face_lookup::FaceLookup;
use glam::{DMat3, DVec3};
use model::Model;
use std::sync::Arc;

/// Version of the features, increased whenever the meaning of one changes; a network accepts only the version of its
/// training.
pub const VERSION: u32 = 10;

/// Features of a face node: x, y; the gap along the closing direction and its decay at three scales; normal of the
/// object where the node would meet it; distance to the object and its normal when the undeformed pad has closed by 0,
/// 0.25 and 0.6 thicknesses; height, spacing; vector to the rim and its length; the smallest gap around the node: the
/// difference to its own, its decay at two scales, its position.
pub const NODE: [Parity; 31] = [
    X, Y, Even, Even, Even, Even, X, Y, Even, Even, X, Y, Even, Even, X, Y, Even, Even, X, Y, Even, Even, Even, X, Y,
    Even, Even, Even, Even, X, Y,
];
/// Features of an edge: relative position and its length.
pub const EDGE: [Parity; 4] = [X, Y, Even, Even];
/// Features of a pad: Poisson's ratio, friction, weight of the object; length, width and mean spacing; 1 if the object
/// is free.
pub const PAD: [Parity; 9] = [Even, Even, X, Y, Even, Even, Even, Even, Even];
/// Depths by which the undeformed pad is moved into the object, over its thickness.
const DEPTHS: [f64; 3] = [0.0, 0.25, 0.6];
/// Largest distance to the rim, over the thickness; larger ones are clamped.
const MAX_RIM_DISTANCE: f64 = 1.5;
/// Largest gap, over the thickness; larger ones are clamped.
const MAX_GAP: f64 = 2.5;
/// Decay lengths of the gap, over the thickness.
const DECAY_LENGTHS: [f64; 3] = [0.05, 0.2, 0.8];

/// Features of a grasp, ordered by pad, left first.
#[derive(Debug, Clone)]
pub struct GraspFeatures {
    /// Graph of a pad; both pads are identical.
    pub graph: Arc<PadGraph>,
    /// Number of pads.
    pub pads: usize,
    /// Features of nodes (pads * face nodes, [`NODE`]).
    pub node: Vec<f32>,
    /// Features of edges (pads * edges, [`EDGE`]).
    pub edge: Vec<f32>,
    /// Features of pads (pads, [`PAD`]).
    pub pad: Vec<f32>,
    /// Matrix of the area-weighted mean over the face of each pad: (pads, pads * face nodes).
    pub mean: Arc<Sparse>,
    /// The same, weighted also by proximity to the object.
    pub near: Arc<Sparse>,
    /// Graph of the full pads and the object, for a network that passes messages there.
    pub volume: Option<Arc<VolumeGraph>>,
    /// Model of the grasp.
    pub model: Arc<Model>,
    pub(crate) first_contact: GeometricContact,
    /// Young's modulus, Pa.
    pub young: f64,
    /// Equilibrium of the rigid object between linearly elastic pads.
    pub equilibrium: Arc<RigidEquilibrium>,
    /// Rotations from hand axes to the frame of each pad.
    pub to_pad: Vec<DMat3>,
}

impl GraspFeatures {
    /// Computes the features of a grasp of `model` at first contact.
    pub fn new(model: &Arc<Model>, graph: &Arc<PadGraph>, touch: &GeometricContact) -> Self {
        let (t, n, pads) = (graph.thickness, graph.face.len(), model.fingers.len());
        let moduli = model.material.moduli();
        let mut node = Vec::with_capacity(pads * n * NODE.len());
        let (mut gaps, mut pad, mut contact_points) = (Vec::new(), Vec::new(), Vec::new());
        let area: Vec<f64> = graph.area.iter().map(|a| a / (t * t)).collect();
        let lookup = FaceLookup::new(&graph.rest, &graph.triangles);
        for (finger, travel) in model.fingers.iter().zip(&touch.travel) {
            let placement = &finger.placement;
            let view = ObjectQuery::new(model, touch, placement, *travel);
            let own: Vec<f64> = graph.rest.iter().map(|x| view.gap(view.pad_to_object(*x), MAX_GAP * t) / t).collect();
            let nearest = sub_element::smallest_gaps(&view, graph, &lookup, &own);
            for (i, (x, gap)) in graph.rest.iter().zip(&own).enumerate() {
                let (at, gap) = (view.pad_to_object(*x), *gap);
                let normal = view.distance_and_normal(at + view.closing * (gap.min(MAX_GAP) * t)).1;
                let normal = if gap < MAX_GAP { normal } else { DVec3::ZERO };
                let mut row = vec![x.x / t, x.y / t, gap];
                row.extend(DECAY_LENGTHS.map(|f| (-gap / f).exp()));
                row.extend(normal.to_array());
                for depth in DEPTHS {
                    let (distance, normal) = view.distance_and_normal(at + view.closing * (depth * t));
                    row.push((distance / t).min(MAX_GAP));
                    row.extend(normal.to_array());
                }
                row.extend([x.z / t, area[i].sqrt()]);
                let (distance, way) = graph.to_rim[i];
                row.extend([way.x, way.y, distance].map(|v| (v / t).clamp(-MAX_RIM_DISTANCE, MAX_RIM_DISTANCE)));
                let SmallestGap { gap: least, offset } = nearest[i];
                let fade = |gap: f64, f: f64| (-gap.max(0.0) / f).exp();
                row.extend([
                    gap - least,
                    fade(least, DECAY_LENGTHS[0]),
                    fade(least, DECAY_LENGTHS[1]),
                    offset.x,
                    offset.y,
                ]);
                node.extend(row.into_iter().map(|v| v as f32));
            }
            let weight = placement.rotation.transpose() * touch.weight / (moduli.young * t * t);
            pad.extend([moduli.poisson, model.friction, weight.x, weight.y, weight.z].map(|v| v as f32));
            let size = (graph.bounds[1] - graph.bounds[0]) / t;
            let spacing = (area.iter().sum::<f64>() / n as f64).sqrt();
            pad.extend([size.x, size.y, spacing, f64::from(u8::from(model.free))].map(|v| v as f32));
            contact_points.push(sub_element::contact_points(&view, graph, &lookup, &own, &nearest));
            gaps.push(own);
        }
        let edge = edge_features(graph).repeat(pads);
        let pool = |weight: &dyn Fn(usize, usize) -> f64| {
            let row = |p: usize| {
                let sum: f64 = (0..n).map(|i| weight(p, i)).sum();
                (0..n).map(|i| ((p * n + i) as u32, (weight(p, i) / sum) as f32)).collect::<Vec<_>>()
            };
            Sparse::new(&(0..pads).map(row).collect::<Vec<_>>(), pads * n)
        };
        Self {
            mean: pool(&|_, i| area[i]),
            near: pool(&|p, i| area[i] * (-gaps[p][i] / DECAY_LENGTHS[1]).exp()),
            volume: (graph.layout == Layout::Volume).then(|| Arc::new(VolumeGraph::new(model, graph, touch))),
            graph: graph.clone(),
            pads,
            node,
            edge,
            pad,
            model: model.clone(),
            first_contact: touch.clone(),
            young: moduli.young,
            equilibrium: Arc::new(RigidEquilibrium::new(model, graph, touch, contact_points)),
            to_pad: model.fingers.iter().map(|f| f.placement.rotation.transpose()).collect(),
        }
    }

    /// Returns the unit of force of the network, N.
    pub fn unit_force(&self) -> f64 {
        self.young * self.graph.thickness.powi(2)
    }
}

/// Returns the features of the edges of a pad (edges, [`EDGE`]).
pub fn edge_features(graph: &PadGraph) -> Vec<f32> {
    let of = |(s, r): &(u32, u32)| {
        let d = (graph.rest[*s as usize] - graph.rest[*r as usize]) / graph.thickness;
        [d.x, d.y, d.z, d.length()].map(|v| v as f32)
    };
    graph.edges.list.iter().flat_map(of).collect()
}

/// Returns the rows of the blocks with the indices `wanted`, out of `count` blocks of equal size.
pub(crate) fn select_rows<T: Copy>(all: &[T], count: usize, wanted: &[usize]) -> Vec<T> {
    let width = all.len() / count;
    wanted.iter().flat_map(|l| &all[l * width..(l + 1) * width]).copied().collect()
}
