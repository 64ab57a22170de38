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

use super::layers::{LayerNorm, LinearLayer, force_fractions};
use super::{Forward, Inputs, Network, NetworkOutput, repeat};
use crate::autodiff::ops::{
    Activation, balance_contact_forces, deviatoric_stress, free_displacement, scatter_to_nodes, sparse_product,
    von_mises,
};
use crate::autodiff::tensor::{Matrix, Real, Tape, row};
use crate::features::loads::{LoadFeatures, NODE_LOAD, PAD_LOAD};
use crate::features::{EDGE, NODE, PAD};
use crate::linear_response::pad_graph::Layout;
use crate::matrix::Sparse;
use crate::network::parameters::{ParameterBuilder, Parameters};
use crate::network::spec::Face;
use dfdx::prelude::{Axis, BroadcastTo, HasShape, ReshapeTo};
use std::sync::Arc;

/// Parameters of the network.
#[derive(Debug)]
pub struct FaceNetwork {
    depths: usize,
    start: LinearLayer,
    start_pad: LinearLayer,
    rounds: Vec<Round>,
    last: LayerNorm,
    pools: Pools,
    node: [LinearLayer; 3],
    inner: LinearLayer,
    outer: LinearLayer,
    displacement: LinearLayer,
    scale: LinearLayer,
    stress: LinearLayer,
    factor: LinearLayer,
    contact: LinearLayer,
    pad: [LinearLayer; 2],
    middle: LinearLayer,
    travel: LinearLayer,
    motion: LinearLayer,
}

/// Parameters of one round of message passing.
#[derive(Debug)]
struct Round {
    norm: LayerNorm,
    edge: LinearLayer,
    sender: LinearLayer,
    receiver: LinearLayer,
    pools: Pools,
    own: LinearLayer,
    messages: LinearLayer,
    global: LinearLayer,
    out: LinearLayer,
}

/// Layer on pooled features of a pad and of the other pad.
#[derive(Debug)]
struct Pools {
    weights: [LinearLayer; 4],
}

impl Pools {
    fn new<E: Real>(maker: &mut ParameterBuilder<E>, name: &str, latent: usize) -> Self {
        let [mean, bias] = ["mean", "bias"].map(|part| format!("{name}.{part}"));
        let own = LinearLayer::named(maker, [&mean, &bias], (latent, latent), 0.5, 0.0);
        let [near, other_mean, other_near] = ["near", "other_mean", "other_near"]
            .map(|part| LinearLayer::without_bias(maker, &format!("{name}.{part}"), (latent, latent), 0.5));
        Self { weights: [own, near, other_mean, other_near] }
    }

    /// Pools node values (pads * nodes, latent) to pads (pads, latent).
    fn apply<E: Real, T: Tape<E>>(&self, p: &Parameters<E>, inputs: &Inputs<T>, h: &Matrix<E, T>) -> Matrix<E, T> {
        let f = inputs.features;
        // With one finger there is no other pad: its row is empty, which yields zero.
        let other = (0..f.pads).map(|i| if f.pads == 2 { vec![(1 - i as u32, 1.0)] } else { Vec::new() });
        let other = Sparse::new(&other.collect::<Vec<_>>(), f.pads);
        let (mean, near) = (sparse_product(&f.mean, h.clone()), sparse_product(&f.near, h.clone()));
        let [a, b, c, d] = self.weights;
        let others = vec![
            b.apply(p, near.clone()),
            c.apply(p, sparse_product(&other, mean.clone())),
            d.apply(p, sparse_product(&other, near)),
        ];
        a.apply_with_terms(p, mean, others, Activation::Gated)
    }
}

impl FaceNetwork {
    /// Creates the network with initial values from `maker`.
    pub fn new<E: Real>(sizes: &Face, maker: &mut ParameterBuilder<E>) -> Self {
        let (h, d, depths) = (sizes.latent.get(), sizes.decoder.get(), sizes.depths.get());
        let start = LinearLayer::new(maker, "start.node", (NODE.len(), h), 1.0, 0.0);
        let start_pad = LinearLayer::without_bias(maker, "start.pad", (PAD.len(), h), 0.5);
        let rounds = (0..sizes.rounds.get()).map(|r| {
            let name = |part: &str| format!("round{r}.{part}");
            Round {
                norm: LayerNorm::new(maker, &name("norm"), h),
                edge: LinearLayer::new(maker, &name("edge"), (EDGE.len(), h), 0.7, 0.0),
                sender: LinearLayer::without_bias(maker, &name("sender"), (h, h), 0.7),
                receiver: LinearLayer::without_bias(maker, &name("receiver"), (h, h), 0.7),
                pools: Pools::new(maker, &name("pool"), h),
                own: LinearLayer::new(maker, &name("own"), (h, h), 0.7, 0.0),
                messages: LinearLayer::without_bias(maker, &name("messages"), (h, h), 0.7),
                global: LinearLayer::without_bias(maker, &name("global"), (h, h), 0.7),
                out: LinearLayer::new(maker, &name("out"), (h, h), 0.5, 0.0),
            }
        });
        Self {
            depths,
            start,
            start_pad,
            rounds: rounds.collect(),
            last: LayerNorm::new(maker, "last.norm", h),
            pools: Pools::new(maker, "last.pool", h),
            node: [
                LinearLayer::named(maker, ["node.latent", "node.bias"], (h, d), 1.0, 0.0),
                LinearLayer::without_bias(maker, "node.load", (NODE_LOAD.len(), d), 1.0),
                LinearLayer::without_bias(maker, "node.pad_load", (PAD_LOAD.len(), d), 1.0),
            ],
            inner: LinearLayer::new(maker, "node.inner", (d, d), 1.0, 0.0),
            outer: LinearLayer::new(maker, "node.outer", (d, d), 0.5, 0.0),
            displacement: LinearLayer::new(maker, "displacement", (d, 3 * depths), 0.01, 0.0),
            scale: LinearLayer::new(maker, "scale", (d, 3 * depths), 0.01, 1.0),
            // Initially the stress is almost that of the linear response: a small offset, and a factor of one.
            stress: LinearLayer::new(maker, "stress", (d, depths), 0.01, -2.0),
            factor: LinearLayer::new(maker, "factor", (d, depths), 0.01, 0.75),
            contact: LinearLayer::new(maker, "contact", (d, 3), 0.01, 0.0),
            pad: [
                LinearLayer::named(maker, ["pad.latent", "pad.bias"], (h, d), 1.0, 0.0),
                LinearLayer::without_bias(maker, "pad.load", (PAD_LOAD.len(), d), 1.0),
            ],
            middle: LinearLayer::new(maker, "pad.middle", (d, d), 1.0, 0.0),
            travel: LinearLayer::new(maker, "travel", (d, 1), 0.01, 0.0),
            motion: LinearLayer::new(maker, "motion", (d, 6), 0.01, 0.0),
        }
    }

    /// Computes one round of message passing on the node values h.
    fn message_passing_round<E: Real, T: Tape<E>>(
        p: &Parameters<E>,
        inputs: &Inputs<T>,
        round: &Round,
        h: Matrix<E, T>,
        edge: &Matrix<E, T>,
    ) -> Matrix<E, T> {
        let graph = &inputs.features.graph;
        let x = round.norm.apply(p, h.clone());
        let sent = sparse_product(&graph.edges.senders, round.sender.apply(p, x.clone()));
        let received = sparse_product(&graph.edges.receivers, round.receiver.apply(p, x.clone()));
        let message = round.edge.apply_with_terms(p, edge.clone(), vec![sent, received], Activation::Gated);
        let messages = round.messages.apply(p, sparse_product(&graph.edges.gather, message));
        let pooled = repeat_rows(round.global.apply(p, round.pools.apply(p, inputs, &x)), graph.face.len());
        let inner = round.own.apply_with_terms(p, x, vec![messages, pooled], Activation::Gated);
        round.out.apply_with_terms(p, inner, vec![h], Activation::None)
    }
}

impl<E: Real> Network<E> for FaceNetwork {
    fn layout(&self) -> Layout {
        Layout::Face { depths: self.depths }
    }
}

impl<E: Real, T: Tape<E>> Forward<E, T> for FaceNetwork {
    fn encode(&self, p: &Parameters<E>, inputs: &Inputs<T>) -> Vec<Matrix<E, T>> {
        let (f, n) = (inputs.features, inputs.normalisers);
        let edge = inputs.matrix(&f.edge, &n.edge, &EDGE);
        let pad = self.start_pad.apply(p, inputs.matrix(&f.pad, &n.pad, &PAD));
        let pad = repeat_rows(pad, f.graph.face.len());
        let mut h = self.start.apply_with_terms(p, inputs.matrix(&f.node, &n.node, &NODE), vec![pad], Activation::None);
        for round in &self.rounds {
            h = Self::message_passing_round(p, inputs, round, h, &edge);
        }
        let h = self.last.apply(p, h);
        let pooled = self.pools.apply(p, inputs, &h);
        // Load-independent part of the first decoder layer.
        vec![self.node[0].apply(p, h), self.pad[0].apply(p, pooled)]
    }

    fn decode(
        &self,
        p: &Parameters<E>,
        inputs: &Inputs<T>,
        code: &[Matrix<E, T>],
        loads: &LoadFeatures,
    ) -> NetworkOutput<E, T> {
        let (f, n, graph) = (inputs.features, inputs.normalisers, &inputs.features.graph);
        let (pads, face, levels) = (f.pads, graph.face.len(), loads.load.len());
        let gated = Activation::Gated;
        let at_node = inputs.matrix(&loads.node, &n.node_load, &NODE_LOAD);
        let at_pad = inputs.matrix(&loads.pad, &n.pad_load, &PAD_LOAD);
        let [node, pad] =
            [(0, pads * face), (1, pads)].map(|(k, n)| sparse_product(&repeat(levels, n), code[k].clone()));
        let pad_load = repeat_rows(self.node[2].apply(p, at_pad.clone()), face);
        let z = self.node[1].apply_with_terms(p, at_node, vec![node, pad_load], gated);
        let z =
            self.outer.apply_with_terms(p, self.inner.apply_activated(p, z.clone(), gated), vec![z], Activation::None);
        let y = self.middle.apply_activated(p, self.pad[1].apply_with_terms(p, at_pad, vec![pad], gated), gated);

        let contact = self.contact.apply(p, z.clone()) + projected_contact_rows(inputs, loads);
        let contact = balance_contact_forces(force_fractions(contact, face), &loads.balance, inputs.signs());
        let (given, bare) = linear_response(inputs, loads, contact.clone());
        // Interpolates the depth channels of the face to all nodes of the pads.
        let channels = levels * pads * face * self.depths;
        let field = |map: &Arc<Sparse>, layer: LinearLayer, act| {
            let x = layer.apply_activated(p, z.clone(), act);
            let width = x.shape().1 / self.depths;
            sparse_product(map, x.reshape_like(&(channels, width)))
        };
        // Additive and multiplicative corrections of the linear response; factor and offset of the stress are positive.
        let beyond = field(&graph.interpolate_free, self.displacement, Activation::None);
        let scale = field(&graph.interpolate, self.scale, Activation::None);
        let factor = field(&graph.interpolate, self.factor, Activation::Positive);
        let more = field(&graph.interpolate, self.stress, Activation::Positive);
        NetworkOutput {
            displacement: given * scale + beyond,
            stress: bare * factor + more,
            contact,
            travel: self.travel.apply(p, y.clone()),
            motion: self.motion.apply(p, y),
        }
    }
}

/// Computes the linear response of the pads to contact forces: displacement and von Mises stress, in the network's
/// units.
fn linear_response<E: Real, T: Tape<E>>(
    inputs: &Inputs<T>,
    loads: &LoadFeatures,
    contact: Matrix<E, T>,
) -> (Matrix<E, T>, Matrix<E, T>) {
    let (f, norms) = (inputs.features, inputs.normalisers);
    let (pad, rows) = (&f.graph.compliance, loads.depth.len());
    let [x, y] = inputs.signs();
    // From (against the closing direction, x, y) to (x, y, z) of the pad without the mirror.
    let turn = Sparse::new(&[vec![(1, x)], vec![(2, y)], vec![(0, -1.0)]], 3);
    let components = contact.shape().0 * 3;
    let force = sparse_product(&turn, contact.reshape_like(&(components, 1))).reshape_like(&(rows, components / rows));
    let scale = row(loads.scale(f).iter().map(|s| s / norms.stress));
    let force = force * scale.broadcast_like::<_, Axis<1>>(&(rows, components / rows));
    let moved = free_displacement(pad, force);
    let unit = norms.stress / norms.displacement;
    let given = scatter_to_nodes(pad, moved.clone());
    let shape = *given.shape();
    let given = given * row([x * unit, y * unit, unit]).broadcast_like::<_, Axis<0>>(&shape);
    // The von Mises norm is invariant under mirrors.
    (given, von_mises(deviatoric_stress(pad, moved)))
}

/// Returns the projected contact on each node: the logarithm of its fraction of the force, and tangential over normal
/// force.
fn projected_contact_rows<E: Real, T: Tape<E>>(inputs: &Inputs<T>, loads: &LoadFeatures) -> Matrix<E, T> {
    let [x, y] = inputs.signs();
    let rows = loads.node.chunks_exact(NODE_LOAD.len());
    inputs.constant(3, rows.flat_map(|row| [(row[6] + MIN_FORCE_FRACTION).ln(), x * row[7], y * row[8]]).collect())
}

/// Fraction added to that of every node, so that the logarithm is finite for a node without force.
pub const MIN_FORCE_FRACTION: f32 = 1e-4;

/// Repeats every row `times` times consecutively.
fn repeat_rows<E: Real, T: Tape<E>>(x: Matrix<E, T>, times: usize) -> Matrix<E, T> {
    let rows = x.shape().0;
    let map: Arc<Sparse> = Sparse::gather((0..rows).flat_map(|r| std::iter::repeat_n(r, times)), rows);
    sparse_product(&map, x)
}
