//! Face network with packed weights and reused memory.

use super::heads::{Channels, Heads};
use super::latent_code::LatentCode;
use super::message::{BLOCK, IncomingEdges, MessageSizes, NodeUpdate, NormLinear, norm_linear, update_nodes};
use super::output_arrays::OutputArrays;
use super::padded_rows::{concatenate_columns, multiply, padded_row};
use super::response::{self, RequiredFields, linear_response};
use crate::features::loads::LoadFeatures;
use crate::features::{EDGE, GraspFeatures, NODE, PAD};
use crate::matrix::activation::Act;
use crate::matrix::product::{PackedMatrix, RowsView, padded};
use crate::network::Normalisers;
use crate::network::parameters::Parameters;
use crate::network::spec::Face;
use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};

/// Layer on the means over a pad and over the other pad.
#[derive(Debug)]
struct Pools {
    weights: PackedMatrix,
    bias: Vec<f32>,
}

#[derive(Debug)]
struct Round {
    project: NormLinear,
    pools: Pools,
    global: PackedMatrix,
    receive: NodeUpdate,
}

/// Network with packed weights.
#[derive(Debug)]
pub struct FaceEngine {
    latent: usize,
    start: PackedMatrix,
    start_bias: Vec<f32>,
    start_pad: PackedMatrix,
    rounds: Vec<Round>,
    last: NormLinear,
    pools: Pools,
    pad: PackedMatrix,
    pad_bias: Vec<f32>,
    heads: Heads,
    normalisers: Normalisers,
    /// Workspaces of earlier passes, for reuse.
    workspaces: Mutex<Vec<Workspace>>,
}

/// Encoded grasp, and the loads at which to decode it.
#[derive(Debug, Clone, Copy)]
pub struct DecodeRequest<'a> {
    /// Features of the grasp.
    pub features: &'a GraspFeatures,
    /// Code of the grasp.
    pub code: &'a LatentCode,
    /// Features of the loads.
    pub loads: &'a LoadFeatures,
}

/// Memory of a pass.
#[derive(Debug, Default)]
struct Workspace {
    h: Vec<f32>,
    scratch: Vec<f32>,
    parts: Vec<f32>,
    blocks: Vec<f32>,
    pooled: Vec<f32>,
    joined: Vec<f32>,
    pool: Vec<f32>,
    global: Vec<f32>,
    response: response::ResponseWorkspace,
    /// Channels of each grasp of a batch.
    channels: Vec<Channels>,
}

impl FaceEngine {
    /// Number of loads to decode together: a batch shares each reading of the weights, a larger one does not fit into
    /// the caches.
    pub const LOADS_PER_BATCH: usize = 32;

    /// Creates the engine from the parameters of a [`crate::network::face::FaceNetwork`] of these sizes.
    pub fn new(sizes: &Face, parameters: &Parameters, normalisers: &Normalisers) -> Self {
        let h = sizes.latent.get();
        let get = |name: &str| parameters.entries(name);
        let packed = |name: &str| parameters.packed(name);
        let norm = |name: &str| [padded_row(get(&format!("{name}.gain"))), padded_row(get(&format!("{name}.shift")))];
        let pools = |name: &str| {
            let parts = ["mean", "near", "other_mean", "other_near"];
            let all: Vec<f32> = parts.iter().flat_map(|k| get(&format!("{name}.{k}"))).collect();
            Pools { weights: PackedMatrix::new(&all, h), bias: padded_row(get(&format!("{name}.bias"))) }
        };
        let round = |r: usize| {
            let name = |part: &str| format!("round{r}.{part}");
            let [sender, receiver, own] = ["sender", "receiver", "own.weight"].map(|k| (get(&name(k)), h));
            let (weights, cols) = concatenate_columns(&[sender, receiver, own]);
            // The bias of the edge layer is added to the part of the receiver.
            let bias = [vec![0.0; padded(h)], padded_row(get(&name("edge.bias"))), padded_row(get(&name("own.bias")))]
                .concat();
            Round {
                project: NormLinear { norm: norm(&name("norm")), weights: PackedMatrix::new(&weights, cols), bias },
                pools: pools(&name("pool")),
                global: packed(&name("global")),
                receive: NodeUpdate {
                    edge: concatenate_columns(&[(get(&name("edge.weight")), h)]).0,
                    messages: packed(&name("messages")),
                    out: packed(&name("out.weight")),
                    out_bias: padded_row(get(&name("out.bias"))),
                },
            }
        };
        Self {
            latent: h,
            start: packed("start.node.weight"),
            start_bias: padded_row(get("start.node.bias")),
            start_pad: packed("start.pad"),
            rounds: (0..sizes.rounds.get()).map(round).collect(),
            last: NormLinear {
                norm: norm("last.norm"),
                weights: packed("node.latent"),
                bias: padded_row(get("node.bias")),
            },
            pools: pools("last.pool"),
            pad: packed("pad.latent"),
            pad_bias: padded_row(get("pad.bias")),
            heads: Heads::new(sizes, parameters),
            normalisers: normalisers.clone(),
            workspaces: Mutex::default(),
        }
    }

    /// Computes the message passing, once per grasp.
    pub fn encode(&self, f: &GraspFeatures) -> LatentCode {
        let mut own = self.acquire_workspace();
        let code = self.encode_with(f, &mut own);
        self.release_workspace(own);
        code
    }

    /// Counts multiplications and additions of the message passing in [`Self::encode`], without activations and norms.
    pub fn operations(&self, f: &GraspFeatures) -> f64 {
        let (h, pads) = (self.latent as f64, f.pads as f64);
        let (nodes, edges) = (pads * f.graph.face.len() as f64, pads * f.graph.edges.list.len() as f64);
        // Per node: five square layers and two pools; per edge: four features, two sums and the sum of the messages.
        let round =
            nodes * (5.0 * 2.0 * h * h + 2.0 * 2.0 * h) + edges * (2.0 * 4.0 + 3.0) * h + pads * 5.0 * 2.0 * h * h;
        let ends = nodes * (2.0 * NODE.len() as f64 * h + 2.0 * h * self.last.weights.cols as f64);
        self.rounds.len() as f64 * round + ends
    }

    /// Counts multiplications and additions of [`Self::decode`] for one load of a grasp, and the bytes of the pad
    /// response, which is read once for all loads.
    pub fn cost_of_load(&self, f: &GraspFeatures, stress: bool) -> (f64, f64) {
        let (operations, bytes) = response::cost(&f.graph, stress);
        (f.pads as f64 * (f.graph.face.len() as f64 * self.heads.operations() + operations), bytes)
    }

    fn acquire_workspace(&self) -> Workspace {
        self.workspaces.lock().unwrap_or_else(PoisonError::into_inner).pop().unwrap_or_default()
    }

    fn release_workspace(&self, own: Workspace) {
        self.workspaces.lock().unwrap_or_else(PoisonError::into_inner).push(own);
    }

    fn encode_with(&self, f: &GraspFeatures, own: &mut Workspace) -> LatentCode {
        let (n, s, pads) = (f.graph.face.len(), padded(self.latent), f.pads);
        let sizes = MessageSizes { nodes: n, latent: self.latent };
        let norms = &self.normalisers;
        let even = (false, false);
        let node = norms.node.apply(&f.node, &NODE, even);
        let pad = norms.pad.apply(&f.pad, &PAD, even);
        // Both pads have the same edges.
        let edge = norms.edge.apply(&f.edge[..f.edge.len() / pads], &EDGE, even);
        let edges = IncomingEdges::new(&f.graph.edges, n, edge);
        let pool_weights = [&f.mean, &f.near].map(|m| m.entries().map(|e| e.1).collect::<Vec<f32>>());
        let pool_weights = pool_weights.each_ref().map(|w| w.as_slice());
        let Workspace { h, scratch, parts, blocks, pooled, joined, pool, global, .. } = own;
        let size = |v: &mut Vec<f32>, n: usize| v.resize(n, 0.0);
        size(h, pads * n * s);
        size(scratch, 2 * pads * n * s);
        size(parts, 3 * pads * n * s);
        size(blocks, pads * n.div_ceil(BLOCK) * 2 * s);
        size(pooled, pads * 2 * s);
        size(joined, pads * 4 * self.latent);
        size(pool, pads * s);
        size(global, pads * s);

        for p in 0..pads {
            let a = |data, stride, count| RowsView { data, stride, count };
            let mut bias = self.start_bias.clone();
            let row = a(&pad[p * PAD.len()..], PAD.len(), 1);
            multiply(row, &self.start_pad, true, None, Act::None, &mut bias);
            let rows = a(&node[p * n * NODE.len()..], NODE.len(), n);
            multiply(rows, &self.start, false, Some(&bias), Act::None, &mut h[p * n * s..(p + 1) * n * s]);
        }
        for round in &self.rounds {
            norm_linear(sizes, &round.project, h, pool_weights, &mut scratch[..pads * n * s], parts, blocks, pooled);
            self.pool(&round.pools, pooled, joined, pool);
            let rows = RowsView { data: &*pool, stride: s, count: pads };
            multiply(rows, &round.global, false, None, Act::None, global);
            update_nodes(sizes, &round.receive, &edges, parts, global, scratch, h);
        }
        let d = self.last.weights.cols;
        let mut code = LatentCode { node: vec![0.0; pads * n * d], pad: vec![0.0; pads * d] };
        norm_linear(sizes, &self.last, h, pool_weights, &mut scratch[..pads * n * s], &mut code.node, blocks, pooled);
        self.pool(&self.pools, pooled, joined, pool);
        let rows = RowsView { data: &*pool, stride: s, count: pads };
        multiply(rows, &self.pad, false, Some(&self.pad_bias), Act::None, &mut code.pad);
        code
    }

    /// Computes a row per pad from the weighted means (pads, 2, padded).
    fn pool(&self, pools: &Pools, pooled: &[f32], joined: &mut [f32], out: &mut [f32]) {
        let (h, s) = (self.latent, padded(self.latent));
        let pads = pooled.len() / (2 * s);
        for (p, row) in joined.chunks_exact_mut(4 * h).enumerate() {
            for (k, part) in row.chunks_exact_mut(h).enumerate() {
                let from = if k < 2 { Some(p) } else { (pads == 2).then_some(1 - p.min(1)) };
                match from {
                    Some(from) => part.copy_from_slice(&pooled[(2 * from + k % 2) * s..][..h]),
                    // With one finger there is no other pad.
                    None => part.fill(0.0),
                }
            }
        }
        let rows = RowsView { data: &*joined, stride: 4 * h, count: pads };
        multiply(rows, &pools.weights, false, Some(&pools.bias), Act::Gated, out);
    }

    /// Computes the outputs of grasps on pads of one graph, each at some loads, in the units of the network, as far as they
    /// are required. The response of the pads is read once for all of them.
    pub fn decode(&self, grasps: &[DecodeRequest], fields: RequiredFields) -> Vec<OutputArrays> {
        let Some(graph) = grasps.first().map(|grasp| &grasp.features.graph) else { return Vec::new() };
        let n = graph.face.len();
        let mut own = self.acquire_workspace();
        let Workspace { channels: all, response: memory, .. } = &mut own;
        all.resize_with(grasps.len().max(all.len()), Channels::default);
        for (DecodeRequest { features, code, loads }, channels) in grasps.iter().zip(all.iter_mut()) {
            self.heads.run(n, features.pads, &self.normalisers, code, loads, channels);
            if !loads.balance.is_empty() {
                let levels = channels.contact.par_chunks_exact_mut(3 * features.pads * n).zip(&loads.balance);
                levels.for_each(|(contact, balance)| balance.balance(contact, [1.0; 2]));
            }
        }
        let scales: Vec<Vec<f32>> = grasps.iter().map(|grasp| grasp.loads.scale(grasp.features)).collect();
        let items =
            all.iter().zip(&scales).flat_map(|(c, scales)| c.contact.chunks_exact(3 * n).zip(scales.iter().copied()));
        let given = linear_response(graph, &items.collect::<Vec<_>>(), fields, memory);
        let mut first = 0;
        let mut outputs = Vec::with_capacity(grasps.len());
        for (scales, channels) in scales.iter().zip(all.iter_mut()) {
            let (displacement, stress) = given.correct(first, channels, &self.normalisers);
            first += scales.len();
            let [contact, travel, motion] =
                [&mut channels.contact, &mut channels.travel, &mut channels.motion].map(std::mem::take);
            outputs.push(OutputArrays { displacement, stress, contact, travel, motion });
        }
        self.release_workspace(own);
        outputs
    }
}
