//! Conversion of tactus data to named NumPy arrays.

use crate::refusal::refused;
use numpy::{Element, PyArrayMethods, PyReadonlyArray2, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use tactus::geometry::Pose;
use tactus::geometry::mesh::TriMesh;
use tactus::model::Model;
use tactus::record::{PadTopology, TactileArray, names};

/// Adds the leading `numbers` to the dictionary as an array of this shape.
pub fn put<T: Element + Copy>(to: &Bound<'_, PyDict>, name: &str, numbers: &[T], shape: &[usize]) -> PyResult<()> {
    let whole: usize = shape.iter().product();
    if numbers.len() < whole {
        return Err(refused(format!("{name}: {} numbers for {shape:?}", numbers.len())));
    }
    to.set_item(name, numbers[..whole].to_pyarray(to.py()).reshape(shape.to_vec())?)
}

/// Returns the arrays of tactile sensors by name, each with the frames as first dimension; `frames` holds the arrays of
/// each frame.
pub fn tactile<'py>(py: Python<'py>, frames: &[&[TactileArray]]) -> PyResult<Bound<'py, PyDict>> {
    let to = PyDict::new(py);
    for (k, array) in frames.first().into_iter().flat_map(|first| first.iter().enumerate()) {
        let numbers: Vec<f32> = frames.iter().flat_map(|frame| &frame[k].values).copied().collect();
        let shape: Vec<usize> = std::iter::once(frames.len()).chain(array.shape.iter().copied()).collect();
        put(&to, &array.name, &numbers, &shape)?;
    }
    Ok(to)
}

/// Returns the coordinates of vectors as a flat list.
pub fn flat(vectors: &[glam::DVec3]) -> Vec<f64> {
    vectors.iter().flat_map(|x| x.to_array()).collect()
}

/// Parses hand poses from the rows of an array; normalises the quaternions.
pub fn hands(rows: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<Pose>> {
    let hand = |row: Vec<f64>| {
        let sound = row.len() == 7 && row.iter().all(|v| v.is_finite()) && row[3..] != [0.0; 4];
        let Pose { position, rotation } = sound.then(|| Pose::from_row(&row))?;
        Some(Pose { position, rotation: rotation.normalize() })
    };
    let what = "poses: rows of 7 finite numbers are needed: px py pz qw qx qy qz of the hand in the object frame, no quaternion zero";
    let hands: Option<_> = rows.as_array().rows().into_iter().map(|row| hand(row.to_vec())).collect();
    hands.ok_or_else(|| refused(what))
}

/// Returns mesh and pose of each pad of a model, left first.
pub fn pads<'py>(py: Python<'py>, model: &Model) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let pad = |finger: &tactus::model::part::FingerModel| {
        pad(py, &finger.topology, &finger.placement.pose(), finger.placement.closing)
    };
    model.fingers.iter().map(pad).collect()
}

/// Returns mesh and pose of a pad.
pub fn pad<'py>(
    py: Python<'py>,
    topology: &PadTopology,
    pose: &Pose,
    closing: glam::DVec3,
) -> PyResult<Bound<'py, PyDict>> {
    let (to, pad) = (PyDict::new(py), topology);
    put(&to, names::REST, &flat(&pad.rest), &[pad.rest.len(), 3])?;
    put(&to, names::TETS, &whole(pad.elements.nodes()), &[pad.elements.len(), pad.elements.width()])?;
    put(&to, names::SURFACE, &whole(pad.surface.as_flattened()), &[pad.surface.len(), 3])?;
    put(&to, names::SENSING, &whole(pad.sensing.as_flattened()), &[pad.sensing.len(), 3])?;
    put(&to, names::BONDED, &pad.bonded, &[pad.bonded.len()])?;
    put(&to, names::PAD_POSE, &pose.row(), &[7])?;
    put(&to, names::CLOSING, &closing.to_array(), &[3])?;
    Ok(to)
}

/// Returns the surface of an object.
pub fn surface<'py>(py: Python<'py>, mesh: &TriMesh) -> PyResult<Bound<'py, PyDict>> {
    let to = PyDict::new(py);
    put(&to, names::VERTICES, &flat(&mesh.vertices), &[mesh.vertices.len(), 3])?;
    put(&to, names::TRIANGLES, &whole(mesh.triangles.as_flattened()), &[mesh.triangles.len(), 3])?;
    Ok(to)
}

/// Converts indices to the integer type of NumPy.
fn whole(indices: &[u32]) -> Vec<i64> {
    indices.iter().map(|i| i64::from(*i)).collect()
}
