//! Inputs and answers of a network for one grasp, as plain arrays (`.npz`), against which a second implementation can be checked.
//!
//! Inputs are normalised, answers in the network's units; rows as in [`crate::net::features`] and [`crate::net::network::NetworkOutput`].
//! A sparse map NAME is `NAME_at` (entries, 2: row, column) and `NAME_weight`; edges are (edges, 2: sender, receiver).

use crate::error::Result;
use crate::files::atomic::replace;
use crate::kernel::Sparse;
use crate::linear::balance::{EQUATIONS, ObjectBalance};
use crate::net::autodiff::ops::{deviated, displaced, reshape, respond};
use crate::net::autodiff::tape::{Matrix, Tape};
use crate::net::features::loads::{NODE_LOAD, PAD_LOAD};
use crate::net::features::volume::{CONTACT_EDGE, MESH_EDGE, VOLUME_NODE};
use crate::net::features::{EDGE, NODE, PAD};
use crate::net::infer::predict::Predictor;
use crate::net::network::Inputs;
use crate::net::network::spec::NetworkSpec;
use crate::net::train::sample::Sample;
use ndarray::Array2;
use ndarray_npy::NpzWriter;
use std::io;
use std::path::Path;
use std::sync::Arc;

/// Named arrays on their way to a file.
#[derive(Default)]
struct Arrays {
    numbers: Vec<(String, Array2<f32>)>,
    indices: Vec<(String, Array2<u32>)>,
}

impl Arrays {
    fn matrix(&mut self, name: &str, matrix: &Matrix) {
        let array = Array2::from_shape_vec((matrix.rows, matrix.cols), matrix.value().to_vec());
        self.numbers.extend(array.map(|a| (name.to_string(), a)));
    }

    fn pairs(&mut self, name: &str, pairs: &[(u32, u32)]) {
        let flat: Vec<u32> = pairs.iter().flat_map(|(a, b)| [*a, *b]).collect();
        self.indices.extend(Array2::from_shape_vec((pairs.len(), 2), flat).map(|a| (name.to_string(), a)));
    }

    /// Adds the balance of every level: force and moment of each component of contact and the contribution of each pull and twist
    /// to it (levels * 6, contact), the inverse from what is out of balance to these (levels * 6, 6), and the load carried (levels,
    /// 6).
    fn balances(&mut self, balances: &[Arc<ObjectBalance>]) {
        let by_component = |of: &dyn Fn(&ObjectBalance, usize) -> [[f32; EQUATIONS]; 3]| {
            let row =
                |b: &ObjectBalance, k: usize| (0..b.nodes()).flat_map(|i| of(b, i).map(|c| c[k])).collect::<Vec<_>>();
            balances.iter().flat_map(|b| (0..EQUATIONS).flat_map(|k| row(b, k)).collect::<Vec<_>>()).collect::<Vec<_>>()
        };
        let pulls = |b: &ObjectBalance, i: usize| {
            let [x, y] = b.pulls(i);
            [[0.0; EQUATIONS], x, y]
        };
        let rows = EQUATIONS * balances.len();
        for (name, numbers) in [("wrench", by_component(&ObjectBalance::wrenches)), ("pull", by_component(&pulls))] {
            self.matrix(&format!("balance_{name}"), &Matrix::constant(rows, numbers.len() / rows.max(1), numbers));
        }
        let inverse = balances.iter().flat_map(|b| b.solution().0.concat()).collect();
        self.matrix("balance_inverse", &Matrix::constant(rows, EQUATIONS, inverse));
        let load = balances.iter().flat_map(|b| *b.solution().1).collect();
        self.matrix("balance_load", &Matrix::constant(balances.len(), EQUATIONS, load));
    }

    fn sparse(&mut self, name: &str, map: &Sparse) {
        let (at, weight): (Vec<(u32, u32)>, Vec<f32>) = map.entries().unzip();
        self.pairs(&format!("{name}_at"), &at);
        self.matrix(&format!("{name}_weight"), &Matrix::constant(1, weight.len(), weight));
    }
}

/// Writes the inputs and answers of `predictor` for the grasp of `sample` at its forces.
///
/// # Errors
/// Fails if the file cannot be written.
pub fn write(path: &Path, predictor: &Predictor, sample: &Sample) -> Result<()> {
    let (f, n) = (&sample.features, &predictor.card.normalisers);
    let inputs = Inputs { features: f, normalisers: n, mirror: (false, false) };
    let loads = &sample.loads;
    let mut arrays = Arrays::default();
    arrays.sparse("near", &f.near);
    if let (Some(volume), Some(norms), NetworkSpec::Paper(sizes)) = (&f.volume, &n.volume, predictor.card.spec.network)
    {
        // The shared block cannot tell how often it is passed.
        arrays.matrix("rounds", &Matrix::constant(1, 1, vec![sizes.rounds.get() as f32]));
        let contact: Vec<f32> = loads.load.iter().flat_map(|load| volume.contact_edge(load.force)).collect();
        arrays.matrix("node", &inputs.matrix(&volume.node, &norms.node, &VOLUME_NODE));
        arrays.matrix("mesh_edge", &inputs.matrix(&volume.mesh_edge, &norms.mesh, &MESH_EDGE));
        arrays.matrix("contact_edge", &inputs.matrix(&contact, &norms.contact, &CONTACT_EDGE));
        arrays.pairs("mesh", &volume.mesh.list);
        arrays.pairs("contact", &volume.contact.list);
        arrays.sparse("pads", &volume.pads);
        arrays.sparse("face", &volume.face);
        arrays.sparse("turned", &volume.turned);
    } else {
        arrays.matrix("node", &inputs.matrix(&f.node, &n.node, &NODE));
        arrays.matrix("edge", &inputs.matrix(&f.edge, &n.edge, &EDGE));
        arrays.matrix("pad", &inputs.matrix(&f.pad, &n.pad, &PAD));
        arrays.matrix("node_load", &inputs.matrix(&loads.node, &n.node_load, &NODE_LOAD));
        arrays.matrix("pad_load", &inputs.matrix(&loads.pad, &n.pad_load, &PAD_LOAD));
        let carried = loads.node.chunks_exact(NODE_LOAD.len()).flat_map(|row| [row[6], row[7], row[8]]);
        let carried: Vec<f32> = carried.collect();
        arrays.matrix("carried", &Matrix::constant(carried.len() / 3, 3, carried));
        let pad = &f.graph.compliance;
        let unit = |i: usize| (0..pad.forces).map(move |j| f32::from(u8::from(i == j)));
        let units = Matrix::constant(pad.forces, pad.forces, (0..pad.forces).flat_map(unit).collect());
        let silent = Tape::silent();
        let moved = respond(&silent, pad, &units);
        arrays.matrix("response", &reshape(&silent, &displaced(&silent, pad, &moved), pad.forces));
        arrays.matrix("stress_response", &reshape(&silent, &deviated(&silent, pad, &moved), pad.forces));
        arrays.balances(&loads.balance);
        let scale = loads.scale(f);
        arrays.matrix("scale", &Matrix::constant(scale.len(), 1, scale));
        arrays.matrix("units", &Matrix::constant(1, 2, vec![n.displacement, n.stress]));
        arrays.pairs("edges", &f.graph.edges.list);
        arrays.sparse("mean", &f.mean);
        arrays.sparse("interpolate", &f.graph.interpolate);
        arrays.sparse("interpolate_free", &f.graph.interpolate_free);
    }
    let tape = Tape::silent();
    let code = predictor.network.encode(&tape, &predictor.parameters, &inputs);
    let out = predictor.network.decode(&tape, &predictor.parameters, &inputs, &code, loads);
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
