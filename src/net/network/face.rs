//! Face network: message passing on the sensing faces once per grasp, and a small decoder for any load level.
//!
//! ```text
//! encode  h = W node                                    per face node, each pad in its own frame
//!         rounds x: m_e = act(W e + W h_sender + W h_receiver)         per edge
//!                   g   = act(W [mean h, near h, those of the other pad])   per pad
//!                   h  += W act(W h + W sum m + W g)                    per node
//! decode  z = act(W h + W node load + W pad load), z += W act(W z)
//!         contact force = the projected one, corrected by W z, in balance
//!         displacement = linear response to it x W z + W z            by depth
//!         stress = that of the response x act(W z) + act(W z)         by depth
//!         y = act(W g + W pad load)                -> travel, object motion
//! ```
//! The second layer of a message is linear, so it is applied after the sum: no matrix product is needed per edge.

use super::{Inputs, Network, NetworkOutput, constant, repeat};
use crate::autodiff::ops::{
    Activation, apply, balanced, deviatoric_stress, displaced, layer_norm, linear, product, reshape, respond, share,
    sum, von_mises,
};
use crate::autodiff::real::Real;
use crate::autodiff::tape::{Matrix, Tape};
use crate::features::loads::{LoadFeatures, NODE_LOAD, PAD_LOAD};
use crate::features::{EDGE, NODE, PAD};
use crate::linear_response::pad_graph::Layout;
use crate::matrix::Sparse;
use crate::network::parameters::{Id, ParameterBuilder, Parameters};
use crate::network::spec::Face;
use std::sync::Arc;

/// Weights and bias of a layer.
#[derive(Debug, Clone, Copy)]
struct Layer(Id, Id);

/// Parameters of the network.
#[derive(Debug)]
pub struct FaceNetwork {
    depths: usize,
    start: Layer,
    start_pad: Id,
    rounds: Vec<Round>,
    last: Layer,
    pools: Pools,
    node: [Id; 3],
    node_bias: Id,
    inner: Layer,
    outer: Layer,
    displacement: Layer,
    scale: Layer,
    stress: Layer,
    factor: Layer,
    contact: Layer,
    pad: [Id; 2],
    pad_bias: Id,
    middle: Layer,
    travel: Layer,
    motion: Layer,
}

/// Parameters of one round of message passing.
#[derive(Debug)]
struct Round {
    norm: Layer,
    edge: Layer,
    sender: Id,
    receiver: Id,
    pools: Pools,
    own: Layer,
    messages: Id,
    global: Id,
    out: Layer,
}

/// Layer on pooled features of a pad and of the other pad.
#[derive(Debug)]
struct Pools {
    weights: [Id; 4],
    bias: Id,
}

impl Pools {
    fn new<T: Real>(maker: &mut ParameterBuilder<T>, name: &str, latent: usize) -> Self {
        let weight =
            |maker: &mut ParameterBuilder<T>, part: &str| maker.weight(&format!("{name}.{part}"), latent, latent, 0.5);
        let weights = ["mean", "near", "other_mean", "other_near"].map(|part| weight(maker, part));
        Self { weights, bias: maker.row(&format!("{name}.bias"), latent, 0.0) }
    }

    /// Pools node values (pads * nodes, latent) to pads (pads, latent).
    fn apply<T: Real>(&self, tape: &Tape<T>, p: &Parameters<T>, inputs: &Inputs, h: &Matrix<T>) -> Matrix<T> {
        let f = inputs.features;
        let pads = f.pads;
        // With one finger there is no other pad: its row is empty, which yields zero.
        let other = (0..pads).map(|i| if pads == 2 { vec![(1 - i as u32, 1.0)] } else { Vec::new() });
        let other = Sparse::new(&other.collect::<Vec<_>>(), pads);
        let (mean, near) = (apply(tape, &f.mean, h), apply(tape, &f.near, h));
        let (other_mean, other_near) = (apply(tape, &other, &mean), apply(tape, &other, &near));
        let bias = Some(p.get(self.bias));
        let [a, b, c, d] = self.weights.map(|w| p.get(w));
        let terms = [
            linear(tape, &mean, a, bias, Activation::None),
            linear(tape, &near, b, None, Activation::None),
            linear(tape, &other_mean, c, None, Activation::None),
            linear(tape, &other_near, d, None, Activation::None),
        ];
        sum(tape, &terms.each_ref(), Activation::Gated)
    }
}

impl FaceNetwork {
    /// Creates the network with initial values from `maker`.
    pub fn new<T: Real>(sizes: &Face, maker: &mut ParameterBuilder<T>) -> Self {
        let (h, d, depths) = (sizes.latent.get(), sizes.decoder.get(), sizes.depths.get());
        let layer = |maker: &mut ParameterBuilder<T>, name: &str, rows: usize, cols: usize, gain: f64| {
            Layer(
                maker.weight(&format!("{name}.weight"), rows, cols, gain),
                maker.row(&format!("{name}.bias"), cols, 0.0),
            )
        };
        let norm = |maker: &mut ParameterBuilder<T>, name: &str| {
            Layer(maker.row(&format!("{name}.gain"), h, 1.0), maker.row(&format!("{name}.shift"), h, 0.0))
        };
        let start = layer(maker, "start.node", NODE.len(), h, 1.0);
        let start_pad = maker.weight("start.pad", PAD.len(), h, 0.5);
        let rounds = (0..sizes.rounds.get()).map(|r| Round {
            norm: norm(maker, &format!("round{r}.norm")),
            edge: layer(maker, &format!("round{r}.edge"), EDGE.len(), h, 0.7),
            sender: maker.weight(&format!("round{r}.sender"), h, h, 0.7),
            receiver: maker.weight(&format!("round{r}.receiver"), h, h, 0.7),
            pools: Pools::new(maker, &format!("round{r}.pool"), h),
            own: layer(maker, &format!("round{r}.own"), h, h, 0.7),
            messages: maker.weight(&format!("round{r}.messages"), h, h, 0.7),
            global: maker.weight(&format!("round{r}.global"), h, h, 0.7),
            out: layer(maker, &format!("round{r}.out"), h, h, 0.5),
        });
        Self {
            depths,
            start,
            start_pad,
            rounds: rounds.collect(),
            last: norm(maker, "last.norm"),
            pools: Pools::new(maker, "last.pool", h),
            node: [
                maker.weight("node.latent", h, d, 1.0),
                maker.weight("node.load", NODE_LOAD.len(), d, 1.0),
                maker.weight("node.pad_load", PAD_LOAD.len(), d, 1.0),
            ],
            node_bias: maker.row("node.bias", d, 0.0),
            inner: layer(maker, "node.inner", d, d, 1.0),
            outer: layer(maker, "node.outer", d, d, 0.5),
            displacement: layer(maker, "displacement", d, 3 * depths, 0.01),
            scale: Layer(maker.weight("scale.weight", d, 3 * depths, 0.01), maker.row("scale.bias", 3 * depths, 1.0)),
            // Initially the stress is almost that of the linear response: a small offset, and a factor of one.
            stress: Layer(maker.weight("stress.weight", d, depths, 0.01), maker.row("stress.bias", depths, -2.0)),
            factor: Layer(maker.weight("factor.weight", d, depths, 0.01), maker.row("factor.bias", depths, 0.75)),
            contact: layer(maker, "contact", d, 3, 0.01),
            pad: [maker.weight("pad.latent", h, d, 1.0), maker.weight("pad.load", PAD_LOAD.len(), d, 1.0)],
            pad_bias: maker.row("pad.bias", d, 0.0),
            middle: layer(maker, "pad.middle", d, d, 1.0),
            travel: layer(maker, "travel", d, 1, 0.01),
            motion: layer(maker, "motion", d, 6, 0.01),
        }
    }

    fn pass<T: Real>(
        &self,
        tape: &Tape<T>,
        p: &Parameters<T>,
        inputs: &Inputs,
        round: &Round,
        h: &Matrix<T>,
        edge: &Matrix<T>,
    ) -> Matrix<T> {
        let graph = &inputs.features.graph;
        let (none, gated) = (Activation::None, Activation::Gated);
        let x = layer_norm(tape, h, p.get(round.norm.0), p.get(round.norm.1));
        let from = apply(tape, &graph.edges.senders, &linear(tape, &x, p.get(round.sender), None, none));
        let to = apply(tape, &graph.edges.receivers, &linear(tape, &x, p.get(round.receiver), None, none));
        let own = linear(tape, edge, p.get(round.edge.0), Some(p.get(round.edge.1)), none);
        let messages = apply(tape, &graph.edges.gather, &sum(tape, &[&own, &from, &to], gated));
        let global = round.pools.apply(tape, p, inputs, &x);
        let global = spread(tape, &linear(tape, &global, p.get(round.global), None, none), graph.face.len());
        let inner = [
            linear(tape, &x, p.get(round.own.0), Some(p.get(round.own.1)), none),
            linear(tape, &messages, p.get(round.messages), None, none),
            global,
        ];
        let inner = sum(tape, &inner.each_ref(), gated);
        sum(tape, &[h, &linear(tape, &inner, p.get(round.out.0), Some(p.get(round.out.1)), none)], none)
    }
}

impl<T: Real> Network<T> for FaceNetwork {
    fn layout(&self) -> Layout {
        Layout::Face { depths: self.depths }
    }

    fn encode(&self, tape: &Tape<T>, p: &Parameters<T>, inputs: &Inputs) -> Vec<Matrix<T>> {
        let (f, n) = (inputs.features, inputs.normalisers);
        let node = inputs.matrix(&f.node, &n.node, &NODE);
        let edge = inputs.matrix(&f.edge, &n.edge, &EDGE);
        let pad = inputs.matrix(&f.pad, &n.pad, &PAD);
        let start = linear(tape, &node, p.get(self.start.0), Some(p.get(self.start.1)), Activation::None);
        let pad = linear(tape, &pad, p.get(self.start_pad), None, Activation::None);
        let mut h = sum(tape, &[&start, &spread(tape, &pad, f.graph.face.len())], Activation::None);
        for round in &self.rounds {
            h = self.pass(tape, p, inputs, round, &h, &edge);
        }
        let h = layer_norm(tape, &h, p.get(self.last.0), p.get(self.last.1));
        let pooled = self.pools.apply(tape, p, inputs, &h);
        // Load-independent part of the first decoder layer.
        let node = linear(tape, &h, p.get(self.node[0]), Some(p.get(self.node_bias)), Activation::None);
        let pad = linear(tape, &pooled, p.get(self.pad[0]), Some(p.get(self.pad_bias)), Activation::None);
        vec![node, pad]
    }

    fn decode(
        &self,
        tape: &Tape<T>,
        p: &Parameters<T>,
        inputs: &Inputs,
        code: &[Matrix<T>],
        loads: &LoadFeatures,
    ) -> NetworkOutput<T> {
        let (f, n, graph) = (inputs.features, inputs.normalisers, &inputs.features.graph);
        let (pads, face) = (f.pads, graph.face.len());
        let levels = loads.load.len();
        let (none, gated) = (Activation::None, Activation::Gated);
        let at_node = inputs.matrix(&loads.node, &n.node_load, &NODE_LOAD);
        let at_pad = inputs.matrix(&loads.pad, &n.pad_load, &PAD_LOAD);
        let node = [
            apply(tape, &repeat(levels, pads * face), &code[0]),
            linear(tape, &at_node, p.get(self.node[1]), None, none),
            spread(tape, &linear(tape, &at_pad, p.get(self.node[2]), None, none), face),
        ];
        let z = sum(tape, &node.each_ref(), gated);
        let inner = linear(tape, &z, p.get(self.inner.0), Some(p.get(self.inner.1)), gated);
        let z = sum(tape, &[&z, &linear(tape, &inner, p.get(self.outer.0), Some(p.get(self.outer.1)), none)], none);
        let pad = [apply(tape, &repeat(levels, pads), &code[1]), linear(tape, &at_pad, p.get(self.pad[1]), None, none)];
        let y = sum(tape, &pad.each_ref(), gated);
        let y = linear(tape, &y, p.get(self.middle.0), Some(p.get(self.middle.1)), gated);

        let head = |x: &Matrix<T>, layer: Layer, act| linear(tape, x, p.get(layer.0), Some(p.get(layer.1)), act);
        let channels = levels * pads * face * self.depths;
        let contact = sum(tape, &[&head(&z, self.contact, none), &carried(inputs, loads)], none);
        let contact = balanced(tape, &share(tape, &contact, face), &loads.balance, inputs.signs());
        let (given, bare) = linear_response(tape, inputs, loads, &contact);
        let channel = |layer: Layer, act| reshape(tape, &head(&z, layer, act), channels);
        // Additive and multiplicative corrections of the linear response.
        let beyond = apply(tape, &graph.interpolate_free, &channel(self.displacement, none));
        let scale = apply(tape, &graph.interpolate, &channel(self.scale, none));
        // Factor and offset of the stress are positive.
        let factor = apply(tape, &graph.interpolate, &channel(self.factor, Activation::Positive));
        let more = apply(tape, &graph.interpolate, &channel(self.stress, Activation::Positive));
        NetworkOutput {
            displacement: sum(tape, &[&beyond, &product(tape, &given, &scale)], none),
            stress: sum(tape, &[&product(tape, &bare, &factor), &more], none),
            contact,
            travel: head(&y, self.travel, none),
            motion: head(&y, self.motion, none),
        }
    }
}

/// Computes the linear response of the pads to contact forces: displacement and von Mises stress, in the network's
/// units.
fn linear_response<T: Real>(
    tape: &Tape<T>,
    inputs: &Inputs,
    loads: &LoadFeatures,
    contact: &Matrix<T>,
) -> (Matrix<T>, Matrix<T>) {
    let (f, norms) = (inputs.features, inputs.normalisers);
    let pad = &f.graph.compliance;
    let [x, y] = inputs.signs();
    let diagonal = |v: &[f32]| Sparse::new(&(0..).zip(v).map(|(i, v)| vec![(i, *v)]).collect::<Vec<_>>(), v.len());
    // From (against the closing direction, x, y) to (x, y, z) of the pad without the mirror.
    let turn = Sparse::new(&[vec![(1, x)], vec![(2, y)], vec![(0, -1.0)]], 3);
    let force = apply(tape, &turn, &reshape(tape, contact, 3 * contact.rows));
    let force = reshape(tape, &force, loads.depth.len());
    let scale: Vec<f32> = loads.scale(f).iter().map(|s| s / norms.stress).collect();
    let moved = respond(tape, pad, &apply(tape, &diagonal(&scale), &force));
    let unit = norms.stress / norms.displacement;
    let given = displaced(tape, pad, &moved);
    let mirrored = apply(tape, &diagonal(&[x * unit, y * unit, unit]), &reshape(tape, &given, 3 * given.rows));
    // The von Mises norm is invariant under mirrors.
    (reshape(tape, &mirrored, given.rows), von_mises(tape, &deviatoric_stress(tape, pad, &moved)))
}

/// Returns the projected contact on each node: the logarithm of its fraction of the force, and tangential over normal
/// force.
fn carried<T: Real>(inputs: &Inputs, loads: &LoadFeatures) -> Matrix<T> {
    let [x, y] = inputs.signs();
    let rows = loads.node.chunks_exact(NODE_LOAD.len());
    constant(3, rows.flat_map(|row| [(row[6] + LITTLE).ln(), x * row[7], y * row[8]]).collect())
}

/// Fraction added to that of every node, so that the logarithm is finite for a node without force.
pub const LITTLE: f32 = 1e-4;

/// Repeats every row `times` times consecutively.
fn spread<T: Real>(tape: &Tape<T>, x: &Matrix<T>, times: usize) -> Matrix<T> {
    let map: Arc<Sparse> = Sparse::gather((0..x.rows).flat_map(|r| std::iter::repeat_n(r, times)), x.rows);
    apply(tape, &map, x)
}
