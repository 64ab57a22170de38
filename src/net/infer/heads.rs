//! Decoder at the face nodes: combines a load with the code of a grasp.
//!
//! One product computes all channels of a node: contact force, then factor and offset of the stress at each depth, then
//! offset and factor of the displacement at each depth.

use super::latent_code::LatentCode;
use super::message::BLOCK;
use super::padded_rows::{concatenate_columns, multiply, padded_row};
use crate::features::loads::{LoadFeatures, NODE_LOAD, PAD_LOAD};
use crate::matrix::activation::{Act, squareplus};
use crate::matrix::product::{PackedMatrix, Product, RowsView, padded, product};
use crate::network::Normalisers;
use crate::network::face::MIN_FORCE_FRACTION;
use crate::network::parameters::Parameters;
use crate::network::spec::Face;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

/// Weights of the decoder.
#[derive(Debug)]
pub struct Heads {
    depths: usize,
    load: PackedMatrix,
    pad_load: PackedMatrix,
    inner: PackedMatrix,
    inner_bias: Vec<f32>,
    outer: PackedMatrix,
    outer_bias: Vec<f32>,
    node: PackedMatrix,
    node_bias: Vec<f32>,
    /// Number of channels of a node before those of the displacement, padded.
    first: usize,
    own_pad_load: PackedMatrix,
    middle: PackedMatrix,
    middle_bias: Vec<f32>,
    pad: PackedMatrix,
    pad_bias: Vec<f32>,
}

/// Output of the decoder; rows are ordered by level, then pad, then face node.
#[derive(Debug, Clone, Default)]
pub struct Channels {
    /// Contact forces over the force of the finger (items * face nodes, 3).
    pub contact: Vec<f32>,
    /// Channels at all depths (items * face nodes, width).
    channels: Vec<f32>,
    width: usize,
    first: usize,
    depths: usize,
    /// Travel (items).
    pub travel: Vec<f32>,
    /// Motion of the object (items, 6).
    pub motion: Vec<f32>,
}

/// Channel of a node at one depth.
#[derive(Debug, Clone, Copy)]
pub struct Channel<'a> {
    /// Factor and offset of the linear-response stress.
    pub stress: [f32; 2],
    /// Offset (3) and factor (3) of the linear-response displacement.
    pub displacement: &'a [f32; 6],
}

impl Channels {
    /// Returns the channels of one item (one pad at one level): (face nodes, width).
    pub fn item(&self, item: usize, nodes: usize) -> &[f32] {
        &self.channels[item * nodes * self.width..(item + 1) * nodes * self.width]
    }

    /// Returns channel `at` (node * depths + depth) of [`Self::item`].
    #[inline(always)]
    pub fn channel<'a>(&self, item: &'a [f32], at: usize) -> Channel<'a> {
        let (node, k) = (at / self.depths, at % self.depths);
        let row = &item[node * self.width..(node + 1) * self.width];
        let displacement = row[self.first + 6 * k..].first_chunk().expect("six numbers per depth");
        Channel { stress: [row[3 + k], row[3 + self.depths + k]], displacement }
    }
}

impl Heads {
    /// Creates the decoder from the parameters of the network.
    pub fn new(sizes: &Face, parameters: &Parameters) -> Self {
        let (d, depths) = (sizes.decoder.get(), sizes.depths.get());
        let packed = |name: &str| parameters.packed(name);
        let both = |name: &str| {
            [("weight", d), ("bias", 1)].map(|(k, rows)| (parameters.entries(&format!("{name}.{k}")), rows))
        };
        // Concatenates columns of the layers in the order of the channels, of the weights (part 0) or the biases (part
        // 1).
        let [contact, factor, stress, displacement, scale] =
            ["contact", "factor", "stress", "displacement", "scale"].map(both);
        let side = |part: usize| {
            let (w, rows) = (|l: &[(Vec<f32>, usize); 2]| l[part].0.clone(), contact[part].1);
            let cut = |m: Vec<f32>, r: usize, from: usize, n: usize| {
                let cols = m.len() / rows;
                m[r * cols + from..r * cols + from + n].to_vec()
            };
            let mut all = Vec::new();
            for r in 0..rows {
                let first = [cut(w(&contact), r, 0, 3), cut(w(&factor), r, 0, depths), cut(w(&stress), r, 0, depths)];
                all.extend(padded_row(first.concat()));
                let deep = (0..depths)
                    .flat_map(|k| [cut(w(&displacement), r, 3 * k, 3), cut(w(&scale), r, 3 * k, 3)].concat());
                all.extend(padded_row(deep.collect()));
            }
            let cols = all.len() / rows;
            (all, cols)
        };
        let (weights, width) = side(0);
        let [travel, motion] = ["travel", "motion"].map(both);
        let (pad, pad_width) = concatenate_columns(&[(travel[0].0.clone(), 1), (motion[0].0.clone(), 6)]);
        Self {
            depths,
            load: packed("node.load"),
            pad_load: packed("node.pad_load"),
            inner: packed("node.inner.weight"),
            inner_bias: padded_row(parameters.entries("node.inner.bias")),
            outer: packed("node.outer.weight"),
            outer_bias: padded_row(parameters.entries("node.outer.bias")),
            node: PackedMatrix::new(&weights, width),
            node_bias: side(1).0,
            first: padded(3 + 2 * depths),
            own_pad_load: packed("pad.load"),
            middle: packed("pad.middle.weight"),
            middle_bias: padded_row(parameters.entries("pad.middle.bias")),
            pad: PackedMatrix::new(&pad, pad_width),
            pad_bias: concatenate_columns(&[(travel[1].0.clone(), 1), (motion[1].0.clone(), 6)]).0,
        }
    }

    /// Counts multiplications and additions at one node under one load, including those with padding zeros, without
    /// activations.
    pub(crate) fn operations(&self) -> f64 {
        let product = |weights: &PackedMatrix| 2.0 * (weights.rows * weights.cols) as f64;
        [&self.load, &self.inner, &self.outer, &self.node].into_iter().map(product).sum()
    }

    /// Computes all channels at some loads, for `nodes` nodes of a face and `pads` pads of a grasp. The memory of
    /// `channels` is reused.
    pub fn run(
        &self,
        nodes: usize,
        pads: usize,
        norms: &Normalisers,
        code: &LatentCode,
        loads: &LoadFeatures,
        channels: &mut Channels,
    ) {
        let items = loads.depth.len();
        let (width, d) = (self.node.cols, self.load.cols);
        let even = (false, false);
        let at_pad = norms.pad_load.apply(&loads.pad, &PAD_LOAD, even);
        let pad_rows = RowsView { data: &at_pad, stride: PAD_LOAD.len(), count: items };
        let mut bias = vec![0.0; items * d];
        multiply(pad_rows, &self.pad_load, false, None, Act::None, &mut bias);

        let mut y = vec![0.0; items * d];
        y.chunks_exact_mut(code.pad.len()).for_each(|y| y.copy_from_slice(&code.pad));
        multiply(pad_rows, &self.own_pad_load, true, None, Act::Gated, &mut y);
        let mut inner = vec![0.0; items * self.middle.cols];
        let rows = |data, stride| RowsView { data, stride, count: items };
        multiply(rows(&y, d), &self.middle, false, Some(&self.middle_bias), Act::Gated, &mut inner);
        let mut out = vec![0.0; items * self.pad.cols];
        multiply(rows(&inner, self.middle.cols), &self.pad, false, Some(&self.pad_bias), Act::None, &mut out);
        let of_pad = out.chunks_exact(self.pad.cols);
        // The columns of each layer are padded separately.
        let motion_at = padded(1);

        let mut numbers = std::mem::take(&mut channels.channels);
        numbers.resize(items * nodes * width, 0.0);
        *channels = Channels {
            contact: vec![0.0; items * nodes * 3],
            channels: numbers,
            width,
            first: self.first,
            depths: self.depths,
            travel: of_pad.clone().map(|row| row[0]).collect(),
            motion: of_pad.flat_map(|row| &row[motion_at..motion_at + 6]).copied().collect(),
        };
        let each = channels
            .contact
            .par_chunks_exact_mut(3 * nodes)
            .zip(channels.channels.par_chunks_exact_mut(width * nodes))
            .zip(bias.par_chunks_exact(d).zip(loads.node.par_chunks_exact(NODE_LOAD.len() * nodes)));
        each.enumerate().for_each_init(
            || vec![0.0; BLOCK * (2 * d + padded(NODE_LOAD.len()))],
            |memory, (item, ((contact, out), (bias, load)))| {
                let code = &code.node[item % pads * nodes * d..][..nodes * d];
                for (b, out) in out.chunks_mut(BLOCK * width).enumerate() {
                    let rows = b * BLOCK..b * BLOCK + out.len() / width;
                    let load = &load[rows.start * NODE_LOAD.len()..rows.end * NODE_LOAD.len()];
                    let code = &code[rows.start * d..rows.end * d];
                    Arch::new().dispatch(NodeBlock { heads: self, norms, load, code, bias, memory, out });
                }
                force_fractions(out, width, load, contact);
            },
        );
    }
}

struct NodeBlock<'a> {
    heads: &'a Heads,
    norms: &'a Normalisers,
    load: &'a [f32],
    code: &'a [f32],
    bias: &'a [f32],
    memory: &'a mut [f32],
    out: &'a mut [f32],
}

impl WithSimd for NodeBlock<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { heads, norms, load, code, bias, memory, out } = self;
        let (d, width, wide) = (heads.load.cols, heads.node.cols, padded(NODE_LOAD.len()));
        let count = out.len() / width;
        let (z, rest) = memory.split_at_mut(BLOCK * d);
        let (inner, features) = rest.split_at_mut(BLOCK * d);
        let (z, inner, features) = (&mut z[..count * d], &mut inner[..count * d], &mut features[..count * wide]);
        norms.node_load.apply_to(load, features, wide);
        z.copy_from_slice(code);
        let rows = |data, stride| RowsView { data, stride, count };
        let (a, w) = (rows(&*features, wide), &heads.load);
        product(simd, Product { a, w, keep: true, bias: Some(bias), act: Act::Gated, out: &mut *z, stride: d });
        let a = RowsView { data: &*z, stride: d, count };
        let (w, bias) = (&heads.inner, Some(heads.inner_bias.as_slice()));
        product(simd, Product { a, w, keep: false, bias, act: Act::Gated, out: &mut *inner, stride: d });
        let (a, w, bias) = (rows(&*inner, d), &heads.outer, Some(heads.outer_bias.as_slice()));
        product(simd, Product { a, w, keep: true, bias, act: Act::None, out: &mut *z, stride: d });
        let (a, w, bias) = (rows(&*z, d), &heads.node, Some(heads.node_bias.as_slice()));
        product(simd, Product { a, w, keep: false, bias, act: Act::None, out: &mut *out, stride: width });
        for row in out.chunks_exact_mut(width) {
            let contact = [row[0], row[1], row[2]];
            for v in S::as_mut_simd_f32s(&mut row[..heads.first]).0 {
                *v = squareplus(simd, *v);
            }
            row[..3].copy_from_slice(&contact);
        }
    }
}

/// Computes the contact forces of a pad from its channels, as corrections of the projected contact:
/// [`crate::network::layers::force_fractions`].
fn force_fractions(channels: &[f32], width: usize, load: &[f32], contact: &mut [f32]) {
    let rows = channels.chunks_exact(width).zip(load.chunks_exact(NODE_LOAD.len()));
    let mut top = f32::NEG_INFINITY;
    for (out, (row, load)) in contact.chunks_exact_mut(3).zip(rows) {
        out[0] = row[0] + (load[6] + MIN_FORCE_FRACTION).ln();
        (out[1], out[2]) = (row[1] + load[7], row[2] + load[8]);
        top = top.max(out[0]);
    }
    let mut total = 0.0;
    for out in contact.chunks_exact_mut(3) {
        out[0] = (out[0] - top).exp();
        total += out[0];
    }
    for out in contact.chunks_exact_mut(3) {
        out[0] /= total;
        out[1] *= out[0];
        out[2] *= out[0];
    }
}
