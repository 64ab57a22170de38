//! Graph of the tactile paper: all nodes of the pads, and the object's surface near them, in the frame of the first
//! pad.
//!
//! ```text
//! pad nodes o--o--o    mesh edges along the edges of the tetrahedra
//!            \ : /     contact edges: sensing face <-> object within one thickness (GelSight Mini: 4 mm)
//! object    x--x--x    mesh edges of its triangles, split until they are as fine as the pads
//! ```
//! The paper's mesh edges contain the current and the reference shape; at first contact both are the same and are given
//! once.

use super::parity::Parity::{self, Even, X, Y};
use crate::linear_response::edges::Edges;
use crate::linear_response::first_contact::GeometricContact;
use crate::linear_response::pad_graph::PadGraph;
use crate::matrix::Sparse;
use geometry::Aabb;
use glam::{DMat3, DVec3};
use mech::element::EDGES;
use model::Model;
use record::{ElementNodes, PadTopology};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Features of a node: one-hot kind (interior, surface, object); closing direction of its finger; position; Poisson's
/// ratio, friction. The modulus is part of the unit of force.
pub const VOLUME_NODE: [Parity; 11] = [Even, Even, Even, X, Y, Even, X, Y, Even, Even, Even];
/// Features of a mesh edge: relative position and its length.
pub const MESH_EDGE: [Parity; 4] = [X, Y, Even, Even];
/// Features of a contact edge: relative position and its length, and its fraction of the force.
pub const CONTACT_EDGE: [Parity; 5] = [X, Y, Even, Even, Even];

/// Largest length of a contact edge, over the thickness.
const NEAR: f64 = 1.0;
/// Largest length of an edge of the object, over the thickness.
const FINE: f64 = 0.6;

/// Graph with its features. Nodes: those of the pads, left first, then those of the object.
#[derive(Debug, Clone)]
pub struct VolumeGraph {
    /// Features of nodes (nodes, [`VOLUME_NODE`]).
    pub node: Vec<f32>,
    /// Edges of the meshes.
    pub mesh: Edges,
    /// Features of mesh edges (mesh edges, [`MESH_EDGE`]).
    pub mesh_edge: Vec<f32>,
    /// Edges between pads and object.
    pub contact: Edges,
    /// Features of contact edges without the force (contact edges, 4): [`CONTACT_EDGE`].
    contact_edge: Vec<f32>,
    /// Map from nodes to pad nodes.
    pub pads: Arc<Sparse>,
    /// Map from vector components at nodes to components in the frame of each pad; without entries for bonded nodes.
    pub turned: Arc<Sparse>,
    /// Map from nodes to nodes of the sensing faces.
    pub face: Arc<Sparse>,
}

impl VolumeGraph {
    /// Builds the graph of a grasp of `model` at first contact.
    pub fn new(model: &Model, graph: &PadGraph, touch: &GeometricContact) -> Self {
        let (t, topology) = (graph.thickness, &model.fingers[0].topology);
        let (pads, n) = (model.fingers.len(), topology.rest.len());
        let frame = &model.fingers[0].placement;
        let inverse = frame.rotation.transpose();
        // Over the thickness, in the frame of the first pad.
        let to_graph_frame = |x: DVec3| inverse * (x - frame.origin) / t;
        let carried = model.fingers.iter().zip(&touch.travel);
        let mut x: Vec<DVec3> = carried
            .flat_map(|(f, d)| topology.rest.iter().map(move |x| f.placement.place(*x) + f.placement.closing * *d))
            .map(to_graph_frame)
            .collect();
        let face: Vec<u32> = (0..pads).flat_map(|p| graph.face.iter().map(move |i| (p * n) as u32 + i)).collect();
        let object = object(model, touch, &to_graph_frame, &face.iter().map(|i| x[*i as usize]).collect::<Vec<_>>());

        let surface = outside(topology);
        let material = [model.material.moduli().poisson, model.friction].map(|v| v as f32);
        let mut node = Vec::new();
        for (p, finger) in model.fingers.iter().enumerate() {
            let closing = (inverse * finger.placement.closing).to_array().map(|v| v as f32);
            for i in 0..n {
                let kind = if surface.contains(&(i as u32)) { [0.0, 1.0, 0.0] } else { [1.0, 0.0, 0.0] };
                let at = x[p * n + i].to_array().map(|v| v as f32);
                node.extend(kind.into_iter().chain(closing).chain(at).chain(material));
            }
        }
        for q in &object.points {
            let at = q.to_array().map(|v| v as f32);
            node.extend([0.0, 0.0, 1.0, 0.0, 0.0, 0.0].into_iter().chain(at).chain(material));
        }
        let first = (pads * n) as u32;
        x.extend(&object.points);

        let pad_edges = pad_edges(topology);
        let mesh =
            (0..pads as u32).flat_map(|p| pad_edges.iter().map(move |(a, b)| (a + p * n as u32, b + p * n as u32)));
        let mesh = Edges::new(mesh.chain(object.edges.iter().map(|(a, b)| (a + first, b + first))), x.len(), 1.0);
        let near = |i: u32| {
            let own = x[i as usize];
            let close = object.points.iter().enumerate().filter(move |(_, q)| q.distance(own) <= NEAR);
            close.map(move |(k, _)| (i, first + k as u32))
        };
        let contact = Edges::new(face.iter().flat_map(|i| near(*i)), x.len(), 1.0);
        let relative = |edges: &Edges| -> Vec<f32> {
            let row = |(s, r): &(u32, u32)| {
                let d = x[*s as usize] - x[*r as usize];
                [d.x, d.y, d.z, d.length()].map(|v| v as f32)
            };
            edges.list.iter().flat_map(row).collect()
        };
        Self {
            mesh_edge: relative(&mesh),
            contact_edge: relative(&contact),
            pads: Sparse::gather(0..pads * n, x.len()),
            turned: turned(model, inverse, &topology.bonded, x.len()),
            face: Sparse::gather(face.iter().map(|i| *i as usize), x.len()),
            node,
            mesh,
            contact,
        }
    }

    /// Returns the features of contact edges (contact edges, [`CONTACT_EDGE`]) when each finger closes with `force`,
    /// over `E t^2`, which is divided equally among the edges.
    pub fn contact_edge(&self, force: f64) -> Vec<f32> {
        let part = (force / (self.contact.list.len() / 2).max(1) as f64) as f32;
        self.contact_edge.chunks_exact(4).flat_map(|row| row.iter().copied().chain([part])).collect()
    }
}

/// Nodes of the object, and the pairs of them that are joined by an edge.
struct Points {
    points: Vec<DVec3>,
    edges: BTreeSet<(u32, u32)>,
}

/// Returns the object's surface near the nodes `face` of the pads; `to_graph_frame` transforms points from the hand
/// frame to that of the graph.
fn object(model: &Model, touch: &GeometricContact, to_graph_frame: &dyn Fn(DVec3) -> DVec3, face: &[DVec3]) -> Points {
    let surface = &model.object.surface;
    let pose = &touch.object;
    let vertex: Vec<DVec3> =
        surface.vertices.iter().map(|v| to_graph_frame(pose.rotation * *v + pose.position)).collect();
    let half = face.len() / model.fingers.len();
    let boxes: Vec<Aabb> = face.chunks_exact(half.max(1)).map(|own| Aabb::from_points(own.iter().copied())).collect();
    let apart = |a: &Aabb, b: &Aabb| (a.min - b.max).max(b.min - a.max).max_element() > NEAR;
    let mut rest: Vec<[DVec3; 3]> = surface.triangles.iter().map(|t| t.map(|i| vertex[i as usize])).collect();
    let (mut points, mut edges) = (Vec::new(), BTreeSet::new());
    let mut known: BTreeMap<[u64; 3], Option<u32>> = BTreeMap::new();
    while let Some([a, b, c]) = rest.pop() {
        let own = Aabb::from_points([a, b, c]);
        if boxes.iter().all(|b| apart(b, &own)) {
            continue;
        }
        // Bisects the triangle at its longest edge.
        let sides = [(a, b, c), (b, c, a), (c, a, b)];
        let longest = sides.iter().max_by(|s, r| s.0.distance(s.1).total_cmp(&r.0.distance(r.1)));
        if let Some((a, b, c)) = longest.filter(|(a, b, _)| a.distance(*b) > FINE) {
            let middle = 0.5 * (a + b);
            rest.extend([[*a, middle, *c], [middle, *b, *c]]);
            continue;
        }
        let ids = [a, b, c].map(|p| {
            *known.entry(p.to_array().map(f64::to_bits)).or_insert_with(|| {
                let near = face.iter().any(|x| x.distance(p) <= NEAR);
                near.then(|| {
                    points.push(p);
                    points.len() as u32 - 1
                })
            })
        });
        let pairs = [(ids[0], ids[1]), (ids[1], ids[2]), (ids[2], ids[0])];
        edges.extend(pairs.into_iter().filter_map(|(i, j)| Some((i?, j?))));
    }
    Points { points, edges }
}

/// Returns the edges of the tetrahedra; a 10-node tetrahedron has two along each side.
fn pad_edges(pad: &PadTopology) -> BTreeSet<(u32, u32)> {
    let sorted = |a: u32, b: u32| (a.min(b), a.max(b));
    match &pad.elements {
        ElementNodes::Linear(tets) => tets.iter().flat_map(|t| EDGES.map(|[i, j]| sorted(t[i], t[j]))).collect(),
        ElementNodes::Quadratic(tets) => {
            let halves = |t: &[u32; 10]| {
                let t = *t;
                (0..6).flat_map(move |k| EDGES[k].map(|i| sorted(t[i], t[4 + k])))
            };
            tets.iter().flat_map(halves).collect()
        }
    }
}

/// Returns the nodes of the outer surface, mid-edge nodes included.
fn outside(pad: &PadTopology) -> BTreeSet<u32> {
    let mut nodes: BTreeSet<u32> = pad.surface.iter().flatten().copied().collect();
    if let ElementNodes::Quadratic(tets) = &pad.elements {
        let sides = |t: &[u32; 3]| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])];
        let sides: BTreeSet<_> = pad.surface.iter().flat_map(sides).flat_map(|(a, b)| [(a, b), (b, a)]).collect();
        for t in tets {
            nodes.extend((0..6).filter(|k| sides.contains(&(t[EDGES[*k][0]], t[EDGES[*k][1]]))).map(|k| t[4 + k]));
        }
    }
    nodes
}

/// Computes [`VolumeGraph::turned`]; `inverse` rotates from hand axes to those of the graph.
fn turned(model: &Model, inverse: DMat3, bonded: &[bool], nodes: usize) -> Arc<Sparse> {
    let (mut rows, count) = (Vec::new(), bonded.len());
    for (p, finger) in model.fingers.iter().enumerate() {
        let turn = (inverse * finger.placement.rotation).to_cols_array_2d();
        for (i, bonded) in bonded.iter().enumerate() {
            let at = 3 * (p * count + i) as u32;
            for axis in turn {
                let entry = (0..3).map(|k| (at + k, axis[k as usize] as f32)).filter(|(_, v)| *v != 0.0 && !bonded);
                rows.push(entry.collect::<Vec<_>>());
            }
        }
    }
    Sparse::new(&rows, 3 * nodes)
}
