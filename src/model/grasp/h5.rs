//! Grasp files in HDF5: `*_grasps.h5` of DefGraspSim and DefGraspNets, and files with other conventions.

use base::error::{Error, Result};
use base::files::atomic::replace;
use base::files::regular;
use geometry::Pose;
use glam::{DMat3, DQuat, DVec3};
use hdf5_pure::{Dataset, File, FileBuilder, Group};
use scene::leaf::Positive;
use scene::{GraspFile, QuaternionOrder};
use std::path::Path;

/// Name of the dataset, unless the scene gives another.
const POSES: &str = "poses";
/// Name of the dataset with the factor on the lengths of the object, in files of ACRONYM.
const OBJECT_SCALE: &str = "object/scale";
/// Largest deviation from 1 of the length of a quaternion or of a matrix column: accepts f32 rounding, refuses wrong
/// columns.
const UNIT_SLACK: f64 = 1e-5;
/// Largest file that is read, and largest chunk that is decompressed, bytes; a million grasps take 56 MB.
const MAX_FILE_SIZE: u64 = 256 * 1024 * 1024;
/// Largest number of grasps of a file.
const MAX_ROWS: u64 = 1_000_000;
/// Advice for a file that h5py reads but this reader does not.
const REWRITE: &str =
    "write it again with `h5py.File(name, \"w\", libver=\"earliest\")`, plain or with compression=\"gzip\"";
/// Largest number of groups that are searched for datasets.
const MAX_GROUPS: usize = 64;

/// Reads all grasps of a file in the format of DefGraspSim; quaternions are normalised.
///
/// # Errors
/// Fails as [`read_grasp_file`] does.
pub fn read_grasps_h5(path: impl AsRef<Path>) -> Result<Vec<Pose>> {
    read_grasp_file(&GraspFile::new(path.as_ref().to_path_buf()))
}

/// Reads all grasps of a file, regardless of its selection, in its convention.
///
/// # Errors
/// Fails if the file cannot be read, is not HDF5, is too large, lacks the dataset, if the dataset has a wrong shape or
/// number type, or if a row is not a pose. The message names the file and, for an invalid pose, the row.
pub fn read_grasp_file(file: &GraspFile) -> Result<Vec<Pose>> {
    let path = file.path.as_path();
    let name = file.dataset.as_deref().unwrap_or(POSES);
    let fail = |message: String| Error::file(path, message);
    let h5 = open(path)?;
    let unreadable = |e: hdf5_pure::Error| fail(format!("dataset `{name}` cannot be read: {e}; {REWRITE}"));
    let names = datasets(&h5);
    let dataset = match h5.dataset(name) {
        Ok(dataset) => dataset,
        Err(e) if names.iter().any(|n| n == name.trim_start_matches('/')) => return Err(unreadable(e)),
        Err(_) => return Err(fail(missing(&h5, name, &names))),
    };
    let shape = dataset.shape().map_err(unreadable)?;
    let Some(width) = width(&shape) else {
        return Err(fail(format!(
            "dataset `{name}` has shape {shape:?}; it must be (N, 7), position and quaternion, or (N, 4, 4), matrices"
        )));
    };
    let rows = shape[0];
    if rows > MAX_ROWS {
        return Err(fail(format!("dataset `{name}` declares {rows} grasps; at most {MAX_ROWS} are allowed")));
    }
    if let Some(chunk) = chunk_bytes(&dataset).filter(|bytes| *bytes > MAX_FILE_SIZE) {
        let most = MAX_FILE_SIZE >> 20;
        return Err(fail(format!("dataset `{name}` has chunks of {} MiB; at most {most} are allowed", chunk >> 20)));
    }
    let values = dataset.read_f64().map_err(unreadable)?;
    if values.is_empty() && rows > 0 {
        return Err(fail(format!("dataset `{name}` has numbers of an unsupported type; allowed: float64, float32")));
    }
    if values.len() as u64 != rows * width {
        return Err(fail(format!("dataset `{name}` contains {} numbers instead of {rows} x {width}", values.len())));
    }
    let turn = DQuat::from_mat3(&file.convention.from_hand());
    let read = |row: &[f64]| -> std::result::Result<Pose, String> {
        let pose = if width == 7 { from_row(row, file.convention.quaternion)? } else { from_matrix(row)? };
        // Rotations in the hand frame of tactus are kept bit by bit.
        let turned = if turn == DQuat::IDENTITY { pose.rotation } else { (pose.rotation * turn).normalize() };
        Ok(Pose { rotation: turned, ..pose })
    };
    let rows = values.chunks_exact(width as usize).enumerate();
    rows.map(|(row, v)| read(v).map_err(|m| fail(format!("`{name}` row {row}: {m}")))).collect()
}

/// Opens a grasp file.
fn open(path: &Path) -> Result<File> {
    let bytes = regular::read(path, MAX_FILE_SIZE)?;
    if !hdf5_pure::is_hdf5_bytes(&bytes) {
        let message = "is not an HDF5 file; a grasp file is HDF5 with a dataset `poses` of shape (N, 7)";
        return Err(Error::file(path, message));
    }
    File::from_bytes(bytes).map_err(|e| Error::file(path, format!("is not a readable HDF5 file: {e}; {REWRITE}")))
}

/// Reads the factor on the lengths of the object for which the grasps of an ACRONYM file are made, the number
/// `object/scale`; None if the file has none. (Eppner et al. 2021, "ACRONYM: a large-scale grasp dataset based on
/// simulation".)
///
/// # Errors
/// Fails if the file cannot be read, or the factor is not a number above zero.
pub fn object_scale(path: &Path) -> Result<Option<Positive>> {
    let h5 = open(path)?;
    let Ok(dataset) = h5.dataset(OBJECT_SCALE) else { return Ok(None) };
    let fail = |message: String| Error::file(path, format!("dataset `{OBJECT_SCALE}`: {message}"));
    if dataset.shape().is_ok_and(|shape| shape.iter().product::<u64>() != 1) {
        return Err(fail("one number is needed, the factor on the lengths of the object".into()));
    }
    let values = dataset.read_f64().map_err(|e| fail(format!("cannot be read: {e}; {REWRITE}")))?;
    let [value] = values[..] else {
        return Err(fail("is a number of an unsupported type; allowed: float64, float32".into()));
    };
    Positive::new(value).map(Some).map_err(fail)
}

/// Returns the decompressed size of one chunk, bytes (saturating); None if the dataset is contiguous.
fn chunk_bytes(dataset: &Dataset) -> Option<u64> {
    let shape = dataset.chunk_shape().ok()??;
    let size = dataset.element_size().unwrap_or(8);
    Some(shape.iter().fold(size, |n, c| n.saturating_mul(*c)))
}

/// Returns the number of values per grasp in a dataset of this shape (position and quaternion, or matrix); None for
/// other shapes.
fn width(shape: &[u64]) -> Option<u64> {
    match shape {
        [_, 7] => Some(7),
        [_, 4, 4] => Some(16),
        _ => None,
    }
}

/// Returns the message that the file has no dataset `name`, with the datasets that it has. Datasets behind a soft link
/// in old files cannot be listed, only accessed by path.
fn missing(file: &File, name: &str, names: &[String]) -> String {
    let fits = |name: &&String| file.dataset(name).and_then(|d| d.shape()).is_ok_and(|shape| width(&shape).is_some());
    let choice = names.iter().find(fits).map_or("group/name", String::as_str);
    let has = if names.is_empty() { "none that can be listed".into() } else { names.join(", ") };
    format!(
        "has no dataset `{name}`; it has: {has}; soft and external links are not followed: name the dataset itself in the scene, \
         `grasps: File(path: \"...\", dataset: {choice:?})`"
    )
}

/// Returns the paths of the datasets in a file, breadth first.
fn datasets(file: &File) -> Vec<String> {
    let mut found = Vec::new();
    let mut groups: Vec<(String, Group)> = vec![(String::new(), file.root())];
    let mut at = 0;
    while let Some((path, group)) = groups.get(at) {
        let mut names = group.datasets().unwrap_or_default();
        names.sort();
        found.extend(names.iter().map(|name| format!("{path}{name}")));
        let mut inner = group.groups().unwrap_or_default();
        inner.sort();
        let room = MAX_GROUPS.saturating_sub(groups.len());
        let deeper: Vec<_> = inner
            .iter()
            .take(room)
            .filter_map(|name| Some((format!("{path}{name}/"), group.group(name).ok()?)))
            .collect();
        groups.extend(deeper);
        at += 1;
    }
    found.truncate(MAX_GROUPS);
    found
}

fn finite(v: &[f64]) -> std::result::Result<(), String> {
    match v.iter().position(|x| !x.is_finite()) {
        Some(column) => Err(format!("column {column} is {}; all numbers must be finite", v[column])),
        None => Ok(()),
    }
}

/// Reads a pose from position and quaternion.
fn from_row(v: &[f64], order: QuaternionOrder) -> std::result::Result<Pose, String> {
    finite(v)?;
    let (rotation, names) = match order {
        QuaternionOrder::Wxyz => (Pose::from_row(v).rotation, "w x y z"),
        QuaternionOrder::Xyzw => (DQuat::from_slice(&v[3..7]), "x y z w"),
    };
    let length = rotation.length();
    if (length - 1.0).abs() > UNIT_SLACK {
        return Err(format!("quaternion (columns 3..6: {names}) has length {length:.6}; it must be 1"));
    }
    let rotation = if (length - 1.0).abs() < 1e-15 { rotation } else { rotation.normalize() };
    Ok(Pose { position: DVec3::from_slice(v), rotation })
}

/// Reads a pose from a 4 x 4 matrix [R p; 0 1] in row-major order.
fn from_matrix(v: &[f64]) -> std::result::Result<Pose, String> {
    finite(v)?;
    if v[12..] != [0.0, 0.0, 0.0, 1.0] {
        let last = &v[12..];
        return Err(format!("the matrix's last row is {last:?}; it must be 0 0 0 1 (not transposed: [R p; 0 1])"));
    }
    let rotation = DMat3::from_cols_array(&std::array::from_fn(|k| v[4 * (k % 3) + k / 3]));
    let off = (rotation.transpose() * rotation - DMat3::IDENTITY)
        .to_cols_array()
        .iter()
        .fold(0.0, |m: f64, x| m.max(x.abs()));
    if off > 2.0 * UNIT_SLACK {
        return Err(format!(
            "the matrix's rotation is not orthonormal: its error is {off:.2e}, at most {:e} is allowed",
            2.0 * UNIT_SLACK
        ));
    }
    if rotation.determinant() < 0.0 {
        return Err("the matrix's rotation has determinant -1, a mirror image; it must be +1".into());
    }
    Ok(Pose { position: DVec3::new(v[3], v[7], v[11]), rotation: DQuat::from_mat3(&rotation).normalize() })
}

/// Writes grasps in the format of DefGraspSim, atomically.
///
/// # Errors
/// Fails if the file cannot be written.
pub fn write_grasps_h5(path: impl AsRef<Path>, poses: &[Pose]) -> Result<()> {
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
