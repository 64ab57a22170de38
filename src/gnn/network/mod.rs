//! The networks: one per file, each behind [`Network`].
//!
//! To add one: a file that implements [`Network`], its sizes in [`NetworkSpec`], a line in [`build`].

pub mod face;

use super::features::{self, Features, Loads};
use super::normalise::Normaliser;
use super::parameters::{Maker, Parameters};
use super::spec::NetworkSpec;
use super::tape::{Matrix, Tape};
use serde::{Deserialize, Serialize};

/// Statistics of the training set.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Normalisers {
    /// Of [`features::NODE`].
    pub node: Normaliser,
    /// Of [`features::EDGE`].
    pub edge: Normaliser,
    /// Of [`features::PAD`].
    pub pad: Normaliser,
    /// Of [`features::NODE_LOAD`].
    pub node_load: Normaliser,
    /// Of [`features::PAD_LOAD`].
    pub pad_load: Normaliser,
    /// Root mean square displacement over the depth of the bed of springs.
    pub displacement: f32,
    /// Root mean square stress over Young's modulus times depth over thickness.
    pub stress: f32,
    /// Mean and deviation of the travel over that depth.
    pub travel: [f32; 2],
    /// Root mean square of the object's translation over the depth, and of its rotation over depth over thickness.
    pub motion: [f32; 2],
}

/// The inputs of a pass: features, normalised the same way everywhere.
pub struct Inputs<'a> {
    /// The grasp.
    pub features: &'a Features,
    /// Statistics.
    pub normalisers: &'a Normalisers,
    /// Mirrored along x, y.
    pub mirror: (bool, bool),
}

impl Inputs<'_> {
    fn matrix(&self, rows: &[f32], normaliser: &Normaliser, parity: &[features::Parity]) -> Matrix {
        Matrix::constant(rows.len() / parity.len(), parity.len(), normaliser.apply(rows, parity, self.mirror))
    }
}

/// What a network predicts at some load levels, in units of [`Normalisers`]; rows are levels, then pads, then nodes.
#[derive(Debug, Clone)]
pub struct Output {
    /// (levels * pads * nodes, 3).
    pub displacement: Matrix,
    /// (levels * pads * nodes, 1), non-negative.
    pub stress: Matrix,
    /// (levels * pads * face nodes, 3): share of the finger's force, and friction along x and y in that unit.
    pub contact: Matrix,
    /// (levels * pads, 1).
    pub travel: Matrix,
    /// (levels * pads, 6): translation and rotation vector of the object in the frame of each pad.
    pub motion: Matrix,
}

/// A network.
pub trait Network: Send + Sync + std::fmt::Debug {
    /// Depth channels that its graph of a pad has.
    fn depths(&self) -> usize;
    /// The pass that happens once per grasp. What it returns is for [`Network::decode`] alone.
    fn encode(&self, tape: &Tape, parameters: &Parameters, inputs: &Inputs) -> Vec<Matrix>;
    /// The pass for some load levels.
    fn decode(&self, tape: &Tape, parameters: &Parameters, inputs: &Inputs, code: &[Matrix], loads: &Loads) -> Output;
}

/// The network of a description and its start values.
pub fn build(spec: &NetworkSpec, seed: u64) -> (Box<dyn Network>, Parameters) {
    let mut maker = Maker::new(seed);
    let network: Box<dyn Network> = match spec {
        NetworkSpec::Face(sizes) => Box::new(face::FaceNetwork::new(sizes, &mut maker)),
    };
    (network, maker.finish())
}
