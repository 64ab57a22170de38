//! `*_grasps.h5` of DefGraspSim and DefGraspNets: dataset `poses`, (N, 7), f64, [px, py, pz, qw, qx, qy, qz].

use super::pose::GraspPose;
use crate::error::{Error, Result};
use crate::record::files::replace;
use hdf5_pure::{File, FileBuilder};
use std::path::Path;

/// The dataset's name.
const POSES: &str = "poses";
/// How far from 1 the length of a quaternion may be: f32 files pass, wrong columns do not.
const UNIT_SLACK: f64 = 1e-5;
/// Largest file that is read, bytes; a million grasps take 56 MB.
const SIZE_LIMIT: u64 = 256 * 1024 * 1024;

/// Reads all grasps of a file; quaternions are brought to length 1 exactly. Errors name the file and the row.
pub fn read_grasps_h5(path: impl AsRef<Path>) -> Result<Vec<GraspPose>> {
    let path = path.as_ref();
    let fail = |message: String| Error::file(path, message);
    let meta = path.metadata().map_err(|e| fail(format!("cannot be opened: {e}")))?;
    if meta.is_dir() {
        return Err(fail("is a directory, not a grasp file".into()));
    }
    if meta.len() > SIZE_LIMIT {
        return Err(fail(format!("is larger than {} MiB, the limit for a grasp file", SIZE_LIMIT >> 20)));
    }
    let bytes = std::fs::read(path).map_err(|e| fail(format!("cannot be read: {e}")))?;
    if !hdf5_pure::is_hdf5_bytes(&bytes) {
        return Err(fail("is not an HDF5 file; a grasp file is HDF5 with a dataset `poses` of shape (N, 7)".into()));
    }
    let file = File::from_bytes(bytes).map_err(|e| fail(format!("is not a readable HDF5 file: {e}")))?;
    let dataset = file.dataset(POSES).map_err(|e| {
        let names = file.root().datasets().unwrap_or_default();
        fail(format!(
            "has no dataset `{POSES}` ({e}); it has: {}",
            if names.is_empty() { "none".into() } else { names.join(", ") }
        ))
    })?;
    let shape = dataset.shape().map_err(|e| fail(format!("dataset `{POSES}`: {e}")))?;
    if shape.len() != 2 || shape[1] != 7 {
        return Err(fail(format!("dataset `{POSES}` has shape {shape:?}; it must be (N, 7): px py pz qw qx qy qz")));
    }
    // a file cannot hold more numbers than bytes, whatever its header says
    if shape[0] > SIZE_LIMIT / 7 {
        return Err(fail(format!("dataset `{POSES}` claims {} rows, more than the file can hold", shape[0])));
    }
    let values = dataset.read_f64().map_err(|e| fail(format!("dataset `{POSES}`: {e}")))?;
    if values.len() as u64 != shape[0] * 7 {
        return Err(fail(format!("dataset `{POSES}` holds {} numbers instead of {} x 7", values.len(), shape[0])));
    }
    values
        .chunks_exact(7)
        .enumerate()
        .map(|(row, v)| pose(v).map_err(|m| fail(format!("`{POSES}` row {row}: {m}"))))
        .collect()
}

fn pose(v: &[f64]) -> std::result::Result<GraspPose, String> {
    if let Some(column) = v.iter().position(|x| !x.is_finite()) {
        return Err(format!("column {column} is {}; all numbers must be finite", v[column]));
    }
    let GraspPose { position, rotation } = GraspPose::from_row(v);
    let length = rotation.length();
    if (length - 1.0).abs() > UNIT_SLACK {
        return Err(format!("quaternion (columns 3..6: w x y z) has length {length}; it must be 1"));
    }
    let rotation = if (length - 1.0).abs() < 1e-15 { rotation } else { rotation.normalize() };
    Ok(GraspPose { position, rotation })
}

/// Writes grasps in the same format, whole or not at all.
pub fn write_grasps_h5(path: impl AsRef<Path>, poses: &[GraspPose]) -> Result<()> {
    let path = path.as_ref();
    let values: Vec<f64> = poses
        .iter()
        .flat_map(|p| {
            let (x, q) = (p.position, p.rotation);
            [x.x, x.y, x.z, q.w, q.x, q.y, q.z]
        })
        .collect();
    let mut builder = FileBuilder::new();
    builder.create_dataset(POSES).with_f64_data(&values).with_shape(&[poses.len() as u64, 7]);
    replace(path, |temporary| builder.write(temporary).map_err(std::io::Error::other))
}
