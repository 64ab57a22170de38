//! Networks, one per file, each an implementation of [`Network`].
//!
//! To add a network, implement [`Network`] in a new file, and add its sizes to [`NetworkSpec`] and a line to [`build`].

pub mod card;
pub mod face;
pub mod interval;
pub mod layers;
pub mod paper;
pub mod parameters;
pub mod shipped;
pub mod slip_interval;
pub mod spec;

use self::parameters::{ParameterBuilder, Parameters};
use self::spec::NetworkSpec;
use super::autodiff::tensor::{Matrix, NoneTape, Real, SharedTape, Tape, matrix};
use super::features::loads::{LoadFeatures, NODE_LOAD, PAD_LOAD};
use super::features::normalise::MOST;
use super::features::normalise::Normaliser;
use super::features::volume::{CONTACT_EDGE, MESH_EDGE, VOLUME_NODE};
use super::features::{self, GraspFeatures, VECTOR};
use crate::linear_response::pad_graph::Layout;
use crate::matrix::Sparse;
use dfdx::prelude::PutTape;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Statistics of the training set.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Normalisers {
    /// Statistics of [`features::NODE`].
    pub node: Normaliser,
    /// Statistics of [`features::EDGE`].
    pub edge: Normaliser,
    /// Statistics of [`features::PAD`].
    pub pad: Normaliser,
    /// Statistics of [`super::features::loads::NODE_LOAD`].
    pub node_load: Normaliser,
    /// Statistics of [`super::features::loads::PAD_LOAD`].
    pub pad_load: Normaliser,
    /// Statistics for a network on the full pads.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volume: Option<VolumeNormalisers>,
    /// Root mean square of the displacement beyond the linear response to the contact, over the depth.
    pub displacement: f32,
    /// Root mean square stress over Young's modulus times depth over thickness.
    pub stress: f32,
    /// Mean and standard deviation of the travel beyond that of the equilibrium, over the depth.
    pub travel: [f32; 2],
    /// Root mean square of the object's translation beyond that of the equilibrium, over the depth, and of its rotation
    /// beyond that of the equilibrium, over depth over thickness.
    pub motion: [f32; 2],
}

impl Normalisers {
    /// Extends the bounds of the features to those of other statistics; everything else remains.
    pub fn with_bounds_from(&self, other: &Self) -> Self {
        let join = |own: &Normaliser, other: &Normaliser| own.clone().with_bounds_from(other);
        let volume = self.volume.as_ref().zip(other.volume.as_ref()).map(|(own, other)| VolumeNormalisers {
            node: join(&own.node, &other.node),
            mesh: join(&own.mesh, &other.mesh),
            contact: join(&own.contact, &other.contact),
        });
        Self {
            node: join(&self.node, &other.node),
            edge: join(&self.edge, &other.edge),
            pad: join(&self.pad, &other.pad),
            node_load: join(&self.node_load, &other.node_load),
            pad_load: join(&self.pad_load, &other.pad_load),
            volume,
            ..self.clone()
        }
    }

    /// Checks that the statistics are valid, including those of the full pads if the network uses `whole` pads. The
    /// error states what is wrong.
    pub(crate) fn check(&self, whole: bool) -> Result<(), String> {
        self.node.check("node", features::NODE.len())?;
        self.edge.check("edge", features::EDGE.len())?;
        self.pad.check("pad", features::PAD.len())?;
        self.node_load.check("node_load", NODE_LOAD.len())?;
        self.pad_load.check("pad_load", PAD_LOAD.len())?;
        match &self.volume {
            Some(volume) if whole => {
                volume.node.check("volume.node", VOLUME_NODE.len())?;
                volume.mesh.check("volume.mesh", MESH_EDGE.len())?;
                volume.contact.check("volume.contact", CONTACT_EDGE.len())?;
            }
            None if !whole => {}
            _ => return Err("`normalisers.volume` does not belong to this `spec.network`".into()),
        }
        let [mean, deviation] = self.travel;
        for (name, value) in [
            ("displacement", self.displacement),
            ("stress", self.stress),
            ("travel", deviation),
            ("motion", self.motion[0]),
            ("motion", self.motion[1]),
        ] {
            if !(value > 0.0 && f64::from(value) <= MOST) {
                return Err(format!("`normalisers.{name}` is {value}; allowed: above 0, to {MOST:e}"));
            }
        }
        if !(mean.is_finite() && f64::from(mean.abs()) <= MOST) {
            return Err(format!("`normalisers.travel` is {mean}; allowed: up to {MOST:e}"));
        }
        Ok(())
    }
}

/// Statistics of [`super::features::volume`].
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct VolumeNormalisers {
    /// Statistics of [`super::features::volume::VOLUME_NODE`].
    pub node: Normaliser,
    /// Statistics of [`super::features::volume::MESH_EDGE`].
    pub mesh: Normaliser,
    /// Statistics of [`super::features::volume::CONTACT_EDGE`].
    pub contact: Normaliser,
}

/// Inputs of a pass: features of a grasp, their normalisation, and the tape that records the pass.
pub struct Inputs<'a, T = NoneTape> {
    /// Features of the grasp.
    pub features: &'a GraspFeatures,
    /// Statistics of the training set.
    pub normalisers: &'a Normalisers,
    /// Flags: mirrored along x, and along y.
    pub mirror: (bool, bool),
    /// Tape of the pass.
    pub tape: T,
}

impl<T> Inputs<'_, T> {
    /// Returns the signs of the x and y components of a vector under the mirror.
    pub(crate) fn signs(&self) -> [f32; 2] {
        [VECTOR[0], VECTOR[1]].map(|parity| parity.sign(self.mirror))
    }

    /// Returns normalised features, (n, parity.len()).
    pub(crate) fn matrix<E: Real>(
        &self,
        rows: &[f32],
        normaliser: &Normaliser,
        parity: &[features::Parity],
    ) -> Matrix<E, T>
    where
        T: Tape<E>,
    {
        self.constant(parity.len(), normaliser.apply(rows, parity, self.mirror))
    }

    /// Returns a constant matrix with `cols` columns.
    fn constant<E: Real>(&self, cols: usize, rows: Vec<f32>) -> Matrix<E, T>
    where
        T: Tape<E>,
    {
        matrix(rows.len() / cols, cols, rows.into_iter().map(E::of).collect()).put_tape(self.tape.clone())
    }
}

/// Returns the map from `rows` rows to `times` copies of all of them, one copy after the other.
fn repeat(times: usize, rows: usize) -> Arc<Sparse> {
    Sparse::gather((0..times).flat_map(|_| 0..rows), rows)
}

/// Prediction of a network at some load levels, in units of [`Normalisers`]; rows are ordered by level, then pad, then
/// node.
#[derive(Debug, Clone)]
pub struct NetworkOutput<E: Real = f32, T = NoneTape> {
    /// Displacement (levels * pads * nodes, 3).
    pub displacement: Matrix<E, T>,
    /// Stress (levels * pads * nodes, 1), non-negative.
    pub stress: Matrix<E, T>,
    /// Contact force (levels * pads * face nodes, 3): fraction of the finger's force, and friction along x and y over
    /// that force.
    pub contact: Matrix<E, T>,
    /// Travel (levels * pads, 1).
    pub travel: Matrix<E, T>,
    /// Motion (levels * pads, 6): translation and rotation vector of the object in the frame of each pad.
    pub motion: Matrix<E, T>,
}

/// Forward pass of a network: an encoder per grasp and a decoder per load. `T` is the tape that records it.
pub trait Forward<E: Real = f32, T = NoneTape> {
    /// Encodes a grasp, once per grasp. Only [`Forward::decode`] uses the result.
    fn encode(&self, parameters: &Parameters<E>, inputs: &Inputs<T>) -> Vec<Matrix<E, T>>;
    /// Computes the outputs at some load levels.
    fn decode(
        &self,
        parameters: &Parameters<E>,
        inputs: &Inputs<T>,
        code: &[Matrix<E, T>],
        loads: &LoadFeatures,
    ) -> NetworkOutput<E, T>;
}

/// Network: its forward pass is recorded for training, and not for inference.
pub trait Network<E: Real = f32>:
    Forward<E, NoneTape> + Forward<E, SharedTape<E>> + Send + Sync + std::fmt::Debug
{
    /// Returns the layout of the graph on which it passes messages.
    fn layout(&self) -> Layout;
}

/// Builds the network of a description and its initial values; without a seed all weights are zero.
pub fn build<E: Real>(spec: &NetworkSpec, seed: Option<u64>) -> (Box<dyn Network<E>>, Parameters<E>) {
    let mut maker = ParameterBuilder::new(seed);
    let network: Box<dyn Network<E>> = match spec {
        NetworkSpec::Face(sizes) => Box::new(face::FaceNetwork::new(sizes, &mut maker)),
        NetworkSpec::Paper(sizes) => Box::new(paper::PaperNetwork::new(sizes, &mut maker)),
    };
    (network, maker.finish())
}
