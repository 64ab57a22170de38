//! Inputs and outputs of a network for one grasp, as plain arrays (`.npz`), to check a second implementation against.
//!
//! The arrays of the face network are those of [`crate::infer::inputs`]. Those of the paper's network have the
//! rows of [`crate::features::volume`]; a sparse map NAME is stored as `NAME_at` (entries, 2: row, column) and
//! `NAME_weight`, edges as (edges, 2: sender, receiver). Outputs are in the network's units, with the rows of
//! [`crate::network::NetworkOutput`].

use crate::autodiff::tensor::{Matrix, NoneTape, values};
use crate::features::volume::{CONTACT_EDGE, MESH_EDGE, VOLUME_NODE, VolumeGraph};
use crate::infer::inputs::{Array, grasp_inputs, pad_inputs};
use crate::infer::predict::Predictor;
use crate::matrix::Sparse;
use crate::network::spec::{NetworkSpec, Paper};
use crate::network::{Forward, Inputs, VolumeNormalisers};
use crate::train::sample::Sample;
use base::error::Result;
use base::files::atomic::replace;
use dfdx::prelude::HasShape;
use ndarray::{Array2, ArrayD};
use ndarray_npy::NpzWriter;
use std::io;
use std::path::Path;

/// Named arrays of a file.
#[derive(Default)]
struct Arrays {
    numbers: Vec<(String, ArrayD<f32>)>,
    indices: Vec<(String, ArrayD<u32>)>,
}

/// Appends `arrays` to `to`.
fn extend<T>(to: &mut Vec<(String, ArrayD<T>)>, arrays: Vec<Array<T>>) {
    let shaped =
        |array: Array<T>| Some((array.name.to_string(), ArrayD::from_shape_vec(array.shape, array.numbers).ok()?));
    to.extend(arrays.into_iter().filter_map(shaped));
}

impl Arrays {
    fn matrix(&mut self, name: &str, matrix: &Matrix) {
        self.array(name, *matrix.shape(), values(matrix));
    }

    fn array(&mut self, name: &str, shape: (usize, usize), numbers: Vec<f32>) {
        let array = Array2::from_shape_vec(shape, numbers);
        self.numbers.extend(array.map(|a| (name.to_string(), a.into_dyn())));
    }

    fn pairs(&mut self, name: &str, pairs: &[(u32, u32)]) {
        let flat: Vec<u32> = pairs.iter().flat_map(|(a, b)| [*a, *b]).collect();
        let array = Array2::from_shape_vec((pairs.len(), 2), flat);
        self.indices.extend(array.map(|a| (name.to_string(), a.into_dyn())));
    }

    fn sparse(&mut self, name: &str, map: &Sparse) {
        let (at, weight): (Vec<(u32, u32)>, Vec<f32>) = map.entries().unzip();
        self.pairs(&format!("{name}_at"), &at);
        self.array(&format!("{name}_weight"), (1, weight.len()), weight);
    }

    /// Adds the inputs of the paper's network.
    fn paper(
        &mut self,
        inputs: &Inputs,
        sample: &Sample,
        volume: &VolumeGraph,
        norms: &VolumeNormalisers,
        sizes: &Paper,
    ) {
        // The weights, which all rounds share, do not contain the number of rounds.
        self.array("rounds", (1, 1), vec![sizes.rounds.get() as f32]);
        let contact: Vec<f32> = sample.loads.load.iter().flat_map(|load| volume.contact_edge(load.force)).collect();
        self.matrix("node", &inputs.matrix(&volume.node, &norms.node, &VOLUME_NODE));
        self.matrix("mesh_edge", &inputs.matrix(&volume.mesh_edge, &norms.mesh, &MESH_EDGE));
        self.matrix("contact_edge", &inputs.matrix(&contact, &norms.contact, &CONTACT_EDGE));
        self.pairs("mesh", &volume.mesh.list);
        self.pairs("contact", &volume.contact.list);
        self.sparse("pads", &volume.pads);
        self.sparse("face", &volume.face);
        self.sparse("turned", &volume.turned);
        self.sparse("near", &sample.features.near);
    }
}

/// Writes the inputs and outputs of `predictor` for the grasp of `sample` at its forces.
///
/// # Errors
/// Fails if the file cannot be written.
pub fn write(path: &Path, predictor: &Predictor, sample: &Sample) -> Result<()> {
    let (f, n) = (&sample.features, &predictor.card.normalisers);
    let inputs = Inputs { features: f, normalisers: n, mirror: (false, false), tape: NoneTape };
    let loads = &sample.loads;
    let mut arrays = Arrays::default();
    if let (Some(volume), Some(norms), NetworkSpec::Paper(sizes)) = (&f.volume, &n.volume, predictor.card.spec.network)
    {
        arrays.paper(&inputs, sample, volume, norms, &sizes);
    } else {
        let pad = pad_inputs(&f.graph, f.young, n);
        extend(&mut arrays.indices, pad.indices);
        extend(&mut arrays.numbers, pad.numbers);
        extend(&mut arrays.numbers, grasp_inputs(f, loads, n));
    }
    let network: &dyn Forward = predictor.network.as_ref();
    let code = network.encode(&predictor.parameters, &inputs);
    let out = network.decode(&predictor.parameters, &inputs, &code, loads);
    arrays.matrix("out_displacement", &out.displacement);
    arrays.matrix("out_stress", &out.stress);
    arrays.matrix("out_contact", &out.contact);
    arrays.matrix("out_travel", &out.travel);
    arrays.matrix("out_motion", &out.motion);
    replace(path, |temporary| {
        let mut npz = NpzWriter::new(std::fs::File::create(temporary)?);
        arrays.numbers.iter().try_for_each(|(name, a)| npz.add_array(name.as_str(), a)).map_err(io::Error::other)?;
        arrays.indices.iter().try_for_each(|(name, a)| npz.add_array(name.as_str(), a)).map_err(io::Error::other)?;
        npz.finish().map(|_| ()).map_err(io::Error::other)
    })
}
