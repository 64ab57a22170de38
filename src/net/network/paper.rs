//! Network of the tactile paper (DefGraspNets, Huang et al. 2023): message passing through the full pads, once per
//! load.
//!
//! ```text
//! encode  h, e, c = MLP(node), MLP(mesh edge), MLP(contact edge with its part of the force)
//!         15 rounds, one block:  e += MLP(e, h_sender, h_receiver);  c += MLP(c, h_sender, h_receiver)
//!                                h += MLP(h, sum e, sum c)
//! decode  displacement = MLP(h), stress = ReLU(MLP(h))          per pad node
//! ```
//! MLPs have two hidden layers with ReLU, followed by a LayerNorm. A solver backend needs outputs beyond those of the
//! paper: travel and motion of the object come from a head on the mean of `h` near the contact, contact forces from a
//! layer on the face.

use super::layers::{LayerNorm, LinearLayer, force_fractions};
use super::{Forward, Inputs, Network, NetworkOutput, VolumeNormalisers, repeat};
use crate::autodiff::ops::{Activation, sparse_product};
use crate::autodiff::tensor::{Matrix, Real, Tape};
use crate::features::loads::LoadFeatures;
use crate::features::volume::{CONTACT_EDGE, MESH_EDGE, VOLUME_NODE, VolumeGraph};
use crate::linear_response::edges::Edges;
use crate::linear_response::pad_graph::Layout;
use crate::network::parameters::{ParameterBuilder, Parameters};
use crate::network::spec::Paper;
use dfdx::prelude::{HasShape, ReshapeTo};

/// Two hidden layers and a LayerNorm. The first layer has separate weights per input, so that products instead of
/// inputs are gathered at the edges.
#[derive(Debug)]
struct Mlp {
    inputs: Vec<LinearLayer>,
    hidden: LinearLayer,
    out: LinearLayer,
    norm: LayerNorm,
}

impl Mlp {
    fn new<E: Real>(maker: &mut ParameterBuilder<E>, name: &str, inputs: &[usize], h: usize) -> Self {
        let gain = 2.0 / inputs.len() as f64;
        let [first, bias] = ["input0", "bias"].map(|part| format!("{name}.{part}"));
        let mut all = vec![LinearLayer::named(maker, [&first, &bias], (inputs[0], h), gain, 0.0)];
        let others = inputs.iter().enumerate().skip(1);
        all.extend(others.map(|(i, n)| LinearLayer::without_bias(maker, &format!("{name}.input{i}"), (*n, h), gain)));
        Self {
            inputs: all,
            hidden: LinearLayer::new(maker, &format!("{name}.hidden"), (h, h), 2.0, 0.0),
            out: LinearLayer::new(maker, &format!("{name}.out"), (h, h), 1.0, 0.0),
            norm: LayerNorm::new(maker, name, h),
        }
    }

    /// Computes the output for x, the first input, and the contributions of the others to the first layer.
    fn apply_with_terms<E: Real, T: Tape<E>>(
        &self,
        p: &Parameters<E>,
        x: Matrix<E, T>,
        others: Vec<Matrix<E, T>>,
    ) -> Matrix<E, T> {
        let x = self.inputs[0].apply_with_terms(p, x, others, Activation::Relu);
        let x = self.hidden.apply_activated(p, x, Activation::Relu);
        self.norm.apply(p, self.out.apply(p, x))
    }

    /// Computes the output for a single input.
    fn apply<E: Real, T: Tape<E>>(&self, p: &Parameters<E>, x: Matrix<E, T>) -> Matrix<E, T> {
        self.apply_with_terms(p, x, Vec::new())
    }
}

/// Parameters of the network.
#[derive(Debug)]
pub struct PaperNetwork {
    rounds: usize,
    encode: [Mlp; 3],
    messages: [Mlp; 2],
    update: Mlp,
    decode: Mlp,
    displacement: LinearLayer,
    stress: LinearLayer,
    contact: LinearLayer,
    pooled: Mlp,
    travel: LinearLayer,
    motion: LinearLayer,
}

impl PaperNetwork {
    /// Creates the network with initial values from `maker`.
    pub fn new<E: Real>(sizes: &Paper, maker: &mut ParameterBuilder<E>) -> Self {
        let h = sizes.latent.get();
        let inputs = [("node", VOLUME_NODE.len()), ("mesh", MESH_EDGE.len()), ("contact", CONTACT_EDGE.len())];
        Self {
            rounds: sizes.rounds.get(),
            encode: inputs.map(|(name, n)| Mlp::new(maker, &format!("encode.{name}"), &[n], h)),
            messages: ["mesh", "contact"].map(|name| Mlp::new(maker, &format!("block.{name}"), &[h; 3], h)),
            update: Mlp::new(maker, "block.node", &[h; 3], h),
            decode: Mlp::new(maker, "decode", &[h], h),
            displacement: LinearLayer::new(maker, "displacement", (h, 3), 0.1, 0.0),
            // Stress is positive almost everywhere: a positive initial bias keeps its ReLU active.
            stress: LinearLayer::new(maker, "stress", (h, 1), 0.1, 1.0),
            contact: LinearLayer::new(maker, "contact", (h, 3), 0.1, 0.0),
            pooled: Mlp::new(maker, "pooled", &[h], h),
            travel: LinearLayer::new(maker, "travel", (h, 1), 0.1, 0.0),
            motion: LinearLayer::new(maker, "motion", (h, 6), 0.1, 0.0),
        }
    }

    /// Computes the new state of `edges` from their state e and that of the nodes.
    fn update_edges<E: Real, T: Tape<E>>(
        p: &Parameters<E>,
        mlp: &Mlp,
        edges: &Edges,
        e: Matrix<E, T>,
        h: &Matrix<E, T>,
    ) -> Matrix<E, T> {
        let from = sparse_product(&edges.senders, mlp.inputs[1].apply(p, h.clone()));
        let to = sparse_product(&edges.receivers, mlp.inputs[2].apply(p, h.clone()));
        let new = mlp.apply_with_terms(p, e.clone(), vec![from, to]);
        e + new
    }
}

/// Returns the graph of the full pads and its statistics, which always exist for this network.
fn volume_inputs<'a, T>(inputs: &'a Inputs<T>) -> (&'a VolumeGraph, &'a VolumeNormalisers) {
    let volume = inputs.features.volume.as_deref();
    volume.zip(inputs.normalisers.volume.as_ref()).expect("features have the layout of the network")
}

impl<E: Real> Network<E> for PaperNetwork {
    fn layout(&self) -> Layout {
        Layout::Volume
    }
}

impl<E: Real, T: Tape<E>> Forward<E, T> for PaperNetwork {
    fn encode(&self, p: &Parameters<E>, inputs: &Inputs<T>) -> Vec<Matrix<E, T>> {
        let (volume, norms) = volume_inputs(inputs);
        let node = inputs.matrix(&volume.node, &norms.node, &VOLUME_NODE);
        let mesh = inputs.matrix(&volume.mesh_edge, &norms.mesh, &MESH_EDGE);
        vec![self.encode[0].apply(p, node), self.encode[1].apply(p, mesh)]
    }

    fn decode(
        &self,
        p: &Parameters<E>,
        inputs: &Inputs<T>,
        code: &[Matrix<E, T>],
        loads: &LoadFeatures,
    ) -> NetworkOutput<E, T> {
        let ((volume, norms), f) = (volume_inputs(inputs), inputs.features);
        let levels = loads.load.len();
        let contact: Vec<f32> = loads.load.iter().flat_map(|load| volume.contact_edge(load.force)).collect();
        let mut c = self.encode[2].apply(p, inputs.matrix(&contact, &norms.contact, &CONTACT_EDGE));
        let [mut h, mut e] = [0, 1].map(|k| sparse_product(&repeat(levels, code[k].shape().0), code[k].clone()));
        for _ in 0..self.rounds {
            e = Self::update_edges(p, &self.messages[0], &volume.mesh, e, &h);
            c = Self::update_edges(p, &self.messages[1], &volume.contact, c, &h);
            let mesh = self.update.inputs[1].apply(p, sparse_product(&volume.mesh.gather, e.clone()));
            let contact = self.update.inputs[2].apply(p, sparse_product(&volume.contact.gather, c.clone()));
            h = h.clone() + self.update.apply_with_terms(p, h, vec![mesh, contact]);
        }
        let z = self.decode.apply(p, h);
        let face = sparse_product(&volume.face, z.clone());
        let pooled = self.pooled.apply(p, sparse_product(&f.near, face.clone()));
        let (displacement, rows) = (self.displacement.apply(p, z.clone()), 3 * z.shape().0);
        let components = sparse_product(&volume.turned, displacement.reshape_like(&(rows, 1)));
        let rows = components.shape().0 / 3;
        NetworkOutput {
            displacement: components.reshape_like(&(rows, 3)),
            stress: sparse_product(&volume.pads, self.stress.apply_activated(p, z, Activation::Relu)),
            contact: force_fractions(self.contact.apply(p, face), f.graph.face.len()),
            travel: self.travel.apply(p, pooled.clone()),
            motion: self.motion.apply(p, pooled),
        }
    }
}
