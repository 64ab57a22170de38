//! Message passing on the sensing faces, in blocks of nodes.
//!
//! ```text
//! project   x = norm(h);  sender | receiver | own parts = x W;  parts of the pools          per block of nodes
//! pool      g = act(W [mean x, near x, those of the other pad]) W                           per pad
//! receive   m = sum over incoming edges of act(W e + sender + receiver);  h += W act(own + W m + g)
//! ```
//! Edges are sorted by receiver, so that each node sums its own messages without storing them and without atomics.
//! Blocks do not depend on the number of threads, and the pools are summed in the order of the blocks.

use crate::linear_response::edges::Edges;
use crate::matrix::activation::{Act, gated};
use crate::matrix::product::{LANES, PackedMatrix, Product, RowsView, padded, product};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

/// Number of nodes per block: their rows stay in the first-level cache from one operation to the next.
pub const BLOCK: usize = 24;

/// LayerNorm followed by a linear layer.
#[derive(Debug)]
pub struct NormLinear {
    /// Gain and shift, padded.
    pub norm: [Vec<f32>; 2],
    /// Weights.
    pub weights: PackedMatrix,
    /// Bias, padded.
    pub bias: Vec<f32>,
}

/// Layer that updates nodes from their messages.
#[derive(Debug)]
pub struct NodeUpdate {
    /// Weights of the features of an edge: (features, padded latent).
    pub edge: Vec<f32>,
    /// Weights of the sum of the messages.
    pub messages: PackedMatrix,
    /// Weights of the sum of all parts.
    pub out: PackedMatrix,
    /// Bias, padded.
    pub out_bias: Vec<f32>,
}

/// Directed edges, sorted by receiver.
#[derive(Debug, Clone, Default)]
pub struct IncomingEdges {
    /// Index of the first edge of each node, and the number of edges at the end.
    start: Vec<u32>,
    sender: Vec<u32>,
    /// Features of each edge, normalised.
    pub features: Vec<f32>,
    /// Weight of each message in a sum.
    usual: f32,
}

impl IncomingEdges {
    /// Creates the edges of a pad with `nodes` face nodes from `edges`, which are sorted by receiver.
    pub fn new(edges: &Edges, nodes: usize, features: Vec<f32>) -> Self {
        let mut start = vec![0; nodes + 1];
        edges.list.iter().for_each(|(_, receiver)| start[*receiver as usize + 1] += 1);
        (0..nodes).for_each(|i| start[i + 1] += start[i]);
        let sender = edges.list.iter().map(|e| e.0).collect();
        let usual = edges.gather.entries().next().map_or(1.0, |e| e.1);
        Self { start, sender, features, usual }
    }
}

/// Sizes of a pass.
#[derive(Debug, Clone, Copy)]
pub struct MessageSizes {
    /// Number of face nodes of a pad.
    pub nodes: usize,
    /// Number of values per node.
    pub latent: usize,
}

impl MessageSizes {
    /// Returns the number of floats per node, including padding.
    pub fn stride(self) -> usize {
        padded(self.latent)
    }
}

/// Computes `out = norm(h) W + b` for all pads, and for each pad the weighted sums of `norm(h)` over its nodes, with
/// the two rows of `weights` (2, pads * nodes): `pooled` is (pads, 2, stride). `scratch` has the size of h; `parts`
/// holds the sums of all blocks.
#[allow(clippy::too_many_arguments)]
pub fn norm_linear(
    sizes: MessageSizes,
    layer: &NormLinear,
    h: &[f32],
    weights: [&[f32]; 2],
    scratch: &mut [f32],
    out: &mut [f32],
    parts: &mut [f32],
    pooled: &mut [f32],
) {
    let (n, s, cols) = (sizes.nodes, sizes.stride(), layer.weights.cols);
    let blocks = n.div_ceil(BLOCK);
    let pads = h
        .par_chunks_exact(n * s)
        .zip(scratch.par_chunks_exact_mut(n * s))
        .zip(out.par_chunks_exact_mut(n * cols))
        .zip(parts.par_chunks_exact_mut(blocks * 2 * s).zip(pooled.par_chunks_exact_mut(2 * s)));
    pads.enumerate().for_each(|(pad, (((h, x), out), (parts, pooled)))| {
        let own = weights.map(|w| &w[pad * n..(pad + 1) * n]);
        let blocks = h
            .par_chunks(BLOCK * s)
            .zip(x.par_chunks_mut(BLOCK * s))
            .zip(out.par_chunks_mut(BLOCK * cols).zip(parts.par_chunks_exact_mut(2 * s)));
        blocks.enumerate().for_each(|(b, ((h, x), (out, part)))| {
            let rows = b * BLOCK..(b * BLOCK + BLOCK).min(n);
            let weights = own.map(|w| &w[rows.clone()]);
            Arch::new().dispatch(ProjectBlock { latent: sizes.latent, layer, h, weights, x, out, part });
        });
        pooled.fill(0.0);
        parts.chunks_exact(2 * s).for_each(|part| pooled.iter_mut().zip(part).for_each(|(p, v)| *p += v));
    });
}

struct ProjectBlock<'a> {
    latent: usize,
    layer: &'a NormLinear,
    h: &'a [f32],
    weights: [&'a [f32]; 2],
    x: &'a mut [f32],
    out: &'a mut [f32],
    part: &'a mut [f32],
}

impl WithSimd for ProjectBlock<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { latent, layer, h, weights, x, out, part } = self;
        let s = padded(latent);
        norm(simd, layer, latent, h, x);
        for (part, weights) in part.chunks_exact_mut(s).zip(weights) {
            let sum = S::as_mut_simd_f32s(part).0;
            sum.fill(simd.splat_f32s(0.0));
            for (row, w) in x.chunks_exact(s).zip(weights) {
                let w = simd.splat_f32s(*w);
                for (sum, x) in sum.iter_mut().zip(S::as_simd_f32s(row).0) {
                    *sum = simd.mul_add_e_f32s(w, *x, *sum);
                }
            }
        }
        let a = RowsView { data: x, stride: s, count: x.len() / s };
        let (w, bias, stride) = (&layer.weights, Some(layer.bias.as_slice()), layer.weights.cols);
        product(simd, Product { a, w, keep: false, bias, act: Act::None, out, stride });
    }
}

/// Regularisation added to the variance, as in [`crate::autodiff::ops::layer_norm`].
const EPSILON: f32 = 1e-5;

#[inline(always)]
fn norm<S: Simd>(simd: S, layer: &NormLinear, latent: usize, h: &[f32], x: &mut [f32]) {
    let [gain, shift] = layer.norm.each_ref().map(|v| S::as_simd_f32s(v).0);
    let each = 1.0 / latent as f32;
    let s = padded(latent);
    for (h, x) in h.chunks_exact(s).zip(x.chunks_exact_mut(s)) {
        let (h, x) = (S::as_simd_f32s(h).0, S::as_mut_simd_f32s(x).0);
        let sum = h.iter().fold(simd.splat_f32s(0.0), |sum, v| simd.add_f32s(sum, *v));
        let average = simd.reduce_sum_f32s(sum) * each;
        let mean = simd.splat_f32s(average);
        let mut square = simd.splat_f32s(0.0);
        for (x, h) in x.iter_mut().zip(h) {
            *x = simd.sub_f32s(*h, mean);
            square = simd.mul_add_e_f32s(*x, *x, square);
        }
        // The padding of h is zero and has contributed the square of the mean.
        let extra = (s - latent) as f32 * average * average;
        let variance = (simd.reduce_sum_f32s(square) - extra) * each;
        let scale = simd.splat_f32s(1.0 / (variance + EPSILON).sqrt());
        for ((x, gain), shift) in x.iter_mut().zip(gain).zip(shift) {
            // Gain and shift of the padding are zero, so its result is zero.
            *x = simd.mul_add_e_f32s(simd.mul_f32s(*x, scale), *gain, *shift);
        }
    }
}

/// Updates `h` by one round: `parts` are the sender, receiver and own parts of every node, `global` has a row per pad.
/// `scratch` has twice the size of `h`.
pub fn update_nodes(
    sizes: MessageSizes,
    layer: &NodeUpdate,
    edges: &IncomingEdges,
    parts: &[f32],
    global: &[f32],
    scratch: &mut [f32],
    h: &mut [f32],
) {
    let (n, s) = (sizes.nodes, sizes.stride());
    let pads = h
        .par_chunks_exact_mut(n * s)
        .zip(scratch.par_chunks_exact_mut(2 * n * s))
        .zip(parts.par_chunks_exact(3 * n * s).zip(global.par_chunks_exact(s)));
    pads.for_each(|((h, scratch), (parts, global))| {
        let blocks = h.par_chunks_mut(BLOCK * s).zip(scratch.par_chunks_mut(2 * BLOCK * s));
        blocks.enumerate().for_each(|(b, (h, scratch))| {
            let (messages, inner) = scratch.split_at_mut(h.len());
            let first = b * BLOCK;
            Arch::new().dispatch(ReceiveBlock { layer, edges, first, stride: s, parts, global, messages, inner, h });
        });
    });
}

struct ReceiveBlock<'a> {
    layer: &'a NodeUpdate,
    edges: &'a IncomingEdges,
    first: usize,
    stride: usize,
    parts: &'a [f32],
    global: &'a [f32],
    messages: &'a mut [f32],
    inner: &'a mut [f32],
    h: &'a mut [f32],
}

impl WithSimd for ReceiveBlock<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { layer, edges, first, stride: s, parts, global, messages, inner, h } = self;
        let count = h.len() / s;
        let mut gather = Gather { layer, edges, first, s, parts, messages: &mut *messages, start: 0 };
        // As many columns at once as possible while the weights of the features stay in registers.
        while gather.start < s {
            let left = (s - gather.start) / LANES;
            match (S::F32_LANES, left) {
                (16, 3..) => gather.run::<S, 3>(simd, count),
                (16, _) => gather.run::<S, 1>(simd, count),
                (8, _) => gather.run::<S, 2>(simd, count),
                (4, _) => gather.run::<S, 4>(simd, count),
                _ => gather.run::<S, 16>(simd, count),
            }
        }
        for (i, row) in inner.chunks_exact_mut(s).enumerate() {
            row.copy_from_slice(&parts[(first + i) * 3 * s + 2 * s..][..s]);
        }
        let rows = |data| RowsView { data, stride: s, count };
        let (a, w, bias) = (rows(&*messages), &layer.messages, Some(global));
        product(simd, Product { a, w, keep: true, bias, act: Act::Gated, out: inner, stride: s });
        let (a, w, bias) = (rows(&*inner), &layer.out, Some(layer.out_bias.as_slice()));
        product(simd, Product { a, w, keep: true, bias, act: Act::None, out: h, stride: s });
    }
}

/// Sums of the messages of a block, for a range of columns that begins at `start`.
struct Gather<'a, 'b> {
    layer: &'a NodeUpdate,
    edges: &'a IncomingEdges,
    first: usize,
    s: usize,
    parts: &'a [f32],
    messages: &'b mut [f32],
    start: usize,
}

impl Gather<'_, '_> {
    #[inline(always)]
    fn run<S: Simd, const N: usize>(&mut self, simd: S, count: usize) {
        let Self { layer, edges, first, s, parts, start, .. } = *self;
        let width = N * S::F32_LANES;
        let load =
            |from: &[f32]| -> [S::f32s; N] { *S::as_simd_f32s(&from[..width]).0.first_chunk().expect("N registers") };
        // Four features per edge.
        let weights: [[S::f32s; N]; 4] = std::array::from_fn(|c| load(&layer.edge[c * s + start..]));
        let usual = simd.splat_f32s(edges.usual);
        for i in 0..count {
            let node = first + i;
            let own = load(&parts[node * 3 * s + s + start..]);
            let mut sum = [simd.splat_f32s(0.0); N];
            for e in edges.start[node] as usize..edges.start[node + 1] as usize {
                let from = load(&parts[edges.sender[e] as usize * 3 * s + start..]);
                let features = &edges.features[4 * e..4 * e + 4];
                let mut z: [S::f32s; N] = std::array::from_fn(|j| simd.add_f32s(own[j], from[j]));
                for c in 0..4 {
                    let feature = simd.splat_f32s(features[c]);
                    for j in 0..N {
                        z[j] = simd.mul_add_e_f32s(feature, weights[c][j], z[j]);
                    }
                }
                for j in 0..N {
                    sum[j] = simd.add_f32s(sum[j], gated(simd, z[j]));
                }
            }
            let out = &mut self.messages[i * s + start..][..width];
            for (out, sum) in S::as_mut_simd_f32s(out).0.iter_mut().zip(sum) {
                *out = simd.mul_f32s(sum, usual);
            }
        }
        self.start += width;
    }
}
