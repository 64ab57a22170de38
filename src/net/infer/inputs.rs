//! Inputs of the face network as named plain arrays: all that a second implementation needs to compute the same
//! outputs.
//!
//! Features are normalised. All nodes are those of the canonical mesh ([`crate::linear_response::canonical_pads`]). Sizes:
//! `P` pads, `n` nodes and `E` edges of a face, `N` nodes of a pad, `L` loads.

use crate::features::loads::{LoadFeatures, NODE_LOAD, PAD_LOAD};
use crate::features::normalise::Normaliser;
use crate::features::{EDGE, GraspFeatures, NODE, PAD, Parity, edge_features};
use crate::linear_response::balance::{EQUATIONS, ObjectBalance};
use crate::linear_response::canonical_pads::CanonicalPads;
use crate::linear_response::pad_graph::PadGraph;
use crate::network::Normalisers;
use std::sync::Arc;

/// Named array.
#[derive(Debug, Clone, PartialEq)]
pub struct Array<T> {
    /// Name of the array.
    pub name: &'static str,
    /// Length along each axis.
    pub shape: Vec<usize>,
    /// Entries, row-major.
    pub numbers: Vec<T>,
}

impl<T> Array<T> {
    fn new(name: &'static str, shape: &[usize], numbers: Vec<T>) -> Self {
        Self { name, shape: shape.to_vec(), numbers }
    }

    /// Creates an empty array with capacity for `count` arrays of this shape.
    pub(super) fn stack(&self, count: usize) -> Self {
        let shape = std::iter::once(count).chain(self.shape.iter().copied()).collect();
        Self { name: self.name, shape, numbers: Vec::with_capacity(count * self.numbers.len()) }
    }
}

/// Inputs shared by all grasps with a pad.
#[derive(Debug, Clone, PartialEq)]
pub struct PadInputs {
    /// `face` (n): its nodes; `edges` (E, 2): sender and receiver; `hang` (N, k): depth channels (face node * depths +
    /// depth) from which a node is interpolated.
    pub indices: Vec<Array<u32>>,
    /// `edge` (E, 4), `mean` (n): weights of the mean over the face, `hang_weight` (N, k): weights of the
    /// interpolation, `free` (N): zero where bonded; `response` (3 n, 3 N) and `stress_response` (3 n, 5 N):
    /// displacement over the thickness and deviatoric stress over Young's modulus per force over `E t^2`; `units` (2):
    /// the network's units of displacement and stress; `young_pa`, `thickness_m` (1).
    pub numbers: Vec<Array<f32>>,
}

/// Returns the inputs shared by the grasps with a pad of this graph, whose gel has Young's modulus `young`, Pa.
pub fn pad_inputs(graph: &PadGraph, young: f64, normalisers: &Normalisers) -> PadInputs {
    let (n, nodes, edges) = (graph.face.len(), graph.node_count, graph.edges.list.len());
    let (hang, hang_weight, wide) = interpolation_channels(graph);
    let free = (0..nodes).map(|node| f32::from(u8::from(!graph.interpolate_free.row(node).is_empty())));
    let edge = normalisers.edge.apply(&edge_features(graph), &EDGE, (false, false));
    let whole: f64 = graph.area.iter().sum();
    let pad = &graph.compliance;
    let unit = |i: usize| (0..pad.forces).map(move |j| f32::from(u8::from(i == j)));
    let moved = pad.displacements(&(0..pad.forces).flat_map(unit).collect::<Vec<f32>>());
    let response = pad.scatter.times(&moved, 3);
    let stress_response = pad.stresses(&moved);
    let pairs = graph.edges.list.iter().flat_map(|(sender, receiver)| [*sender, *receiver]).collect();
    PadInputs {
        indices: vec![
            Array::new("face", &[n], graph.face.clone()),
            Array::new("edges", &[edges, 2], pairs),
            Array::new("hang", &[nodes, wide], hang),
        ],
        numbers: vec![
            Array::new("edge", &[edges, EDGE.len()], edge),
            Array::new("mean", &[n], graph.area.iter().map(|area| (area / whole) as f32).collect()),
            Array::new("hang_weight", &[nodes, wide], hang_weight),
            Array::new("free", &[nodes], free.collect()),
            Array::new("response", &[pad.forces, 3 * nodes], response),
            Array::new("stress_response", &[pad.forces, 5 * nodes], stress_response),
            Array::new("units", &[2], vec![normalisers.displacement, normalisers.stress]),
            Array::new("young_pa", &[1], vec![young as f32]),
            Array::new("thickness_m", &[1], vec![graph.thickness as f32]),
        ],
    }
}

impl PadInputs {
    /// Adds the map from the canonical nodes to the `M` nodes of the mesh of the scene, unless both meshes are equal:
    /// `scene_nodes`, `scene_weight` (M, k): canonical nodes and their weights in displacement and stress; `scene_free`
    /// (M): zero where bonded; `scene_forces` (E, 2), `scene_fraction` (E): node of the scene, canonical node, and the
    /// fraction of its contact force.
    pub fn with_scene(mut self, pads: &CanonicalPads) -> Self {
        let Some(map) = pads.to_scene() else { return self };
        let rows = map.stencils().rows();
        let wide = rows.iter().map(Vec::len).max().unwrap_or(0);
        let filled = rows.iter().flat_map(|row| row.iter().copied().chain(std::iter::repeat((0, 0.0))).take(wide));
        let (nodes, weights): (Vec<u32>, Vec<f32>) = filled.map(|(node, weight)| (node, weight as f32)).unzip();
        let free: Vec<f32> = map.bonded().iter().map(|bonded| f32::from(u8::from(!bonded))).collect();
        let pairs: Vec<u32> = map.forces().iter().flat_map(|(to, from, _)| [*to, *from]).collect();
        let fractions: Vec<f32> = map.forces().iter().map(|(.., part)| *part as f32).collect();
        self.indices.push(Array::new("scene_nodes", &[rows.len(), wide], nodes));
        self.indices.push(Array::new("scene_forces", &[fractions.len(), 2], pairs));
        self.numbers.push(Array::new("scene_weight", &[rows.len(), wide], weights));
        self.numbers.push(Array::new("scene_free", &[free.len()], free));
        self.numbers.push(Array::new("scene_fraction", &[fractions.len()], fractions));
        self
    }
}

/// Returns channels and weights of every node of the pad, and their number per node; rows are padded with zero weights.
fn interpolation_channels(graph: &PadGraph) -> (Vec<u32>, Vec<f32>, usize) {
    let rows = || (0..graph.node_count).map(|node| graph.interpolate.row(node));
    let wide = rows().map(<[_]>::len).max().unwrap_or(0);
    let filled = rows().flat_map(|row| row.iter().copied().chain(std::iter::repeat((0, 0.0))).take(wide));
    let (channels, weights) = filled.unzip();
    (channels, weights, wide)
}

/// Returns the inputs of a grasp under some loads: `node` (P, n, [`NODE`]), `pad` (P, [`PAD`]), `near` (P, n): weights
/// of the mean near the object; `node_load` (L, P, n, [`NODE_LOAD`]), `pad_load` (L, P, [`PAD_LOAD`]); `carried` (L, P,
/// n, 3): fraction of the force in the projected contact, and tangential over normal force; `depth_m`, `pressing_n` (L,
/// P). For a free object between two pads also its equilibrium: `wrench` (L, 6, 3 P n): force and moment of a unit of
/// each component of contact; `pull` (L, 6, 3 P n): contributions of a unit of each correction (pulls and twists of the
/// pads) to the components; `inverse` (L, 6, 6): map from the residual force and moment to these corrections;
/// `hangs` (L, 6): force and moment that the pads must carry.
pub fn grasp_inputs(features: &GraspFeatures, loads: &LoadFeatures, normalisers: &Normalisers) -> Vec<Array<f32>> {
    let (p, n, l) = (features.pads, features.graph.face.len(), loads.load.len());
    let carried = loads.node.chunks_exact(NODE_LOAD.len()).flat_map(|row| [row[6], row[7], row[8]]).collect();
    let normal =
        |rows: &[f32], normaliser: &Normaliser, parity: &[Parity]| normaliser.apply(rows, parity, (false, false));
    let near = features.near.entries().map(|(_, weight)| weight).collect();
    let pressing = loads.pressing_force.iter().map(|force| (force * features.unit_force()) as f32).collect();
    let mut arrays = vec![
        Array::new("node", &[p, n, NODE.len()], normal(&features.node, &normalisers.node, &NODE)),
        Array::new("pad", &[p, PAD.len()], normal(&features.pad, &normalisers.pad, &PAD)),
        Array::new("near", &[p, n], near),
        Array::new("node_load", &[l, p, n, NODE_LOAD.len()], normal(&loads.node, &normalisers.node_load, &NODE_LOAD)),
        Array::new("pad_load", &[l, p, PAD_LOAD.len()], normal(&loads.pad, &normalisers.pad_load, &PAD_LOAD)),
        Array::new("carried", &[l, p, n, 3], carried),
        Array::new("depth_m", &[l, p], loads.depth.iter().map(|depth| *depth as f32).collect()),
        Array::new("pressing_n", &[l, p], pressing),
    ];
    if !loads.balance.is_empty() {
        arrays.extend(balances(&loads.balance));
    }
    arrays
}

fn balances(balances: &[Arc<ObjectBalance>]) -> [Array<f32>; 4] {
    let l = balances.len();
    let by_component = |of: &dyn Fn(&ObjectBalance, usize) -> [[f32; EQUATIONS]; 3]| -> Vec<f32> {
        let row = |b: &ObjectBalance, k: usize| (0..b.nodes()).flat_map(|i| of(b, i).map(|c| c[k])).collect::<Vec<_>>();
        balances.iter().flat_map(|b| (0..EQUATIONS).flat_map(|k| row(b, k)).collect::<Vec<_>>()).collect()
    };
    let pulls = |b: &ObjectBalance, i: usize| {
        let [x, y] = b.correction_contributions(i);
        [[0.0; EQUATIONS], x, y]
    };
    let [wrench, pull] = [by_component(&ObjectBalance::wrenches), by_component(&pulls)];
    let components = wrench.len() / (l * EQUATIONS);
    [
        Array::new("wrench", &[l, EQUATIONS, components], wrench),
        Array::new("pull", &[l, EQUATIONS, components], pull),
        Array::new(
            "inverse",
            &[l, EQUATIONS, EQUATIONS],
            balances.iter().flat_map(|b| b.correction_map().0.concat()).collect(),
        ),
        Array::new("hangs", &[l, EQUATIONS], balances.iter().flat_map(|b| *b.correction_map().1).collect()),
    ]
}
