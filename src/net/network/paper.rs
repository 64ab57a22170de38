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

use super::{Inputs, Network, NetworkOutput, VolumeNormalisers, repeat};
use crate::autodiff::ops::{Activation, apply, layer_norm, linear, reshape, share, sum};
use crate::autodiff::real::Real;
use crate::autodiff::tape::{Matrix, Tape};
use crate::features::loads::LoadFeatures;
use crate::features::volume::{CONTACT_EDGE, MESH_EDGE, VOLUME_NODE, Volume};
use crate::linear_response::edges::Edges;
use crate::linear_response::pad_graph::Layout;
use crate::network::parameters::{Id, ParameterBuilder, Parameters};
use crate::network::spec::Paper;

/// Weights and bias of a layer.
#[derive(Debug, Clone, Copy)]
struct Layer(Id, Id);

impl Layer {
    fn new<T: Real>(maker: &mut ParameterBuilder<T>, name: &str, rows: usize, cols: usize, gain: f64) -> Self {
        let weight = maker.weight(&format!("{name}.weight"), rows, cols, gain);
        Self(weight, maker.row(&format!("{name}.bias"), cols, 0.0))
    }

    fn apply<T: Real>(self, tape: &Tape<T>, p: &Parameters<T>, x: &Matrix<T>, act: Activation) -> Matrix<T> {
        linear(tape, x, p.get(self.0), Some(p.get(self.1)), act)
    }
}

/// Two hidden layers and a LayerNorm. The first layer has separate weights per input, so that products instead of
/// inputs are gathered at the edges.
#[derive(Debug)]
struct Mlp {
    inputs: Vec<Id>,
    bias: Id,
    hidden: Layer,
    out: Layer,
    norm: (Id, Id),
}

impl Mlp {
    fn new<T: Real>(maker: &mut ParameterBuilder<T>, name: &str, inputs: &[usize], h: usize) -> Self {
        let gain = 2.0 / inputs.len() as f64;
        let first = |(i, n): (usize, &usize)| (format!("{name}.input{i}"), *n);
        Self {
            inputs: inputs.iter().enumerate().map(first).map(|(name, n)| maker.weight(&name, n, h, gain)).collect(),
            bias: maker.row(&format!("{name}.bias"), h, 0.0),
            hidden: Layer::new(maker, &format!("{name}.hidden"), h, h, 2.0),
            out: Layer::new(maker, &format!("{name}.out"), h, h, 1.0),
            norm: (maker.row(&format!("{name}.gain"), h, 1.0), maker.row(&format!("{name}.shift"), h, 0.0)),
        }
    }

    /// Computes the contribution of input `i` to the first layer.
    fn input<T: Real>(&self, tape: &Tape<T>, p: &Parameters<T>, i: usize, x: &Matrix<T>) -> Matrix<T> {
        linear(tape, x, p.get(self.inputs[i]), (i == 0).then(|| p.get(self.bias)), Activation::None)
    }

    /// Computes the output from the contributions of all inputs.
    fn finish<T: Real>(&self, tape: &Tape<T>, p: &Parameters<T>, terms: &[&Matrix<T>]) -> Matrix<T> {
        let x = sum(tape, terms, Activation::Relu);
        let x = self.hidden.apply(tape, p, &x, Activation::Relu);
        let x = self.out.apply(tape, p, &x, Activation::None);
        layer_norm(tape, &x, p.get(self.norm.0), p.get(self.norm.1))
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
    displacement: Layer,
    stress: Layer,
    contact: Layer,
    pooled: Mlp,
    travel: Layer,
    motion: Layer,
}

impl PaperNetwork {
    /// Creates the network with initial values from `maker`.
    pub fn new<T: Real>(sizes: &Paper, maker: &mut ParameterBuilder<T>) -> Self {
        let h = sizes.latent.get();
        let inputs = [("node", VOLUME_NODE.len()), ("mesh", MESH_EDGE.len()), ("contact", CONTACT_EDGE.len())];
        Self {
            rounds: sizes.rounds.get(),
            encode: inputs.map(|(name, n)| Mlp::new(maker, &format!("encode.{name}"), &[n], h)),
            messages: ["mesh", "contact"].map(|name| Mlp::new(maker, &format!("block.{name}"), &[h; 3], h)),
            update: Mlp::new(maker, "block.node", &[h; 3], h),
            decode: Mlp::new(maker, "decode", &[h], h),
            displacement: Layer::new(maker, "displacement", h, 3, 0.1),
            // Stress is positive almost everywhere: a positive initial bias keeps its ReLU active.
            stress: Layer(maker.weight("stress.weight", h, 1, 0.1), maker.row("stress.bias", 1, 1.0)),
            contact: Layer::new(maker, "contact", h, 3, 0.1),
            pooled: Mlp::new(maker, "pooled", &[h], h),
            travel: Layer::new(maker, "travel", h, 1, 0.1),
            motion: Layer::new(maker, "motion", h, 6, 0.1),
        }
    }

    fn whole<T: Real>(&self, tape: &Tape<T>, p: &Parameters<T>, mlp: &Mlp, x: &Matrix<T>) -> Matrix<T> {
        mlp.finish(tape, p, &[&mlp.input(tape, p, 0, x)])
    }

    /// Computes the messages along `edges` with the state `e`.
    fn pass<T: Real>(
        tape: &Tape<T>,
        p: &Parameters<T>,
        mlp: &Mlp,
        edges: &Edges,
        e: &Matrix<T>,
        h: &Matrix<T>,
    ) -> Matrix<T> {
        let from = apply(tape, &edges.senders, &mlp.input(tape, p, 1, h));
        let to = apply(tape, &edges.receivers, &mlp.input(tape, p, 2, h));
        let new = mlp.finish(tape, p, &[&mlp.input(tape, p, 0, e), &from, &to]);
        sum(tape, &[e, &new], Activation::None)
    }
}

/// Returns the graph of the full pads and its statistics, which always exist for this network.
fn seen<'a>(inputs: &'a Inputs) -> (&'a Volume, &'a VolumeNormalisers) {
    let volume = inputs.features.volume.as_deref();
    volume.zip(inputs.normalisers.volume.as_ref()).expect("features are made for the layout of the network")
}

impl<T: Real> Network<T> for PaperNetwork {
    fn layout(&self) -> Layout {
        Layout::Volume
    }

    fn encode(&self, tape: &Tape<T>, p: &Parameters<T>, inputs: &Inputs) -> Vec<Matrix<T>> {
        let (volume, norms) = seen(inputs);
        let node = inputs.matrix(&volume.node, &norms.node, &VOLUME_NODE);
        let mesh = inputs.matrix(&volume.mesh_edge, &norms.mesh, &MESH_EDGE);
        vec![self.whole(tape, p, &self.encode[0], &node), self.whole(tape, p, &self.encode[1], &mesh)]
    }

    fn decode(
        &self,
        tape: &Tape<T>,
        p: &Parameters<T>,
        inputs: &Inputs,
        code: &[Matrix<T>],
        loads: &LoadFeatures,
    ) -> NetworkOutput<T> {
        let ((volume, norms), f) = (seen(inputs), inputs.features);
        let levels = loads.load.len();
        let contact: Vec<f32> = loads.load.iter().flat_map(|load| volume.contact_edge(load.force)).collect();
        let contact = inputs.matrix(&contact, &norms.contact, &CONTACT_EDGE);
        let mut c = self.whole(tape, p, &self.encode[2], &contact);
        let [mut h, mut e] = [0, 1].map(|k| apply(tape, &repeat(levels, code[k].rows), &code[k]));
        for _ in 0..self.rounds {
            e = Self::pass(tape, p, &self.messages[0], &volume.mesh, &e, &h);
            c = Self::pass(tape, p, &self.messages[1], &volume.contact, &c, &h);
            let terms = [
                self.update.input(tape, p, 0, &h),
                self.update.input(tape, p, 1, &apply(tape, &volume.mesh.gather, &e)),
                self.update.input(tape, p, 2, &apply(tape, &volume.contact.gather, &c)),
            ];
            h = sum(tape, &[&h, &self.update.finish(tape, p, &terms.each_ref())], Activation::None);
        }
        let z = self.whole(tape, p, &self.decode, &h);
        let face = apply(tape, &volume.face, &z);
        let pooled = self.whole(tape, p, &self.pooled, &apply(tape, &f.near, &face));
        let none = Activation::None;
        let displacement = self.displacement.apply(tape, p, &z, none);
        let components = apply(tape, &volume.turned, &reshape(tape, &displacement, 3 * z.rows));
        let rows = components.rows / 3;
        NetworkOutput {
            displacement: reshape(tape, &components, rows),
            stress: apply(tape, &volume.pads, &self.stress.apply(tape, p, &z, Activation::Relu)),
            contact: share(tape, &self.contact.apply(tape, p, &face, none), f.graph.face.len()),
            travel: self.travel.apply(tape, p, &pooled, none),
            motion: self.motion.apply(tape, p, &pooled, none),
        }
    }
}
