//! Reading of a run: `run.json`, and the frames in `arrays.npz`.

use super::frame::{DynamicState, Frame, PadFrame};
use super::names;
use super::report::RunReport;
use base::error::{Error, Result};
use geometry::Pose;
use geometry::Wrench;
use glam::DVec3;
use ndarray::{Array, Dimension, Ix1, Ix2, Ix3};
use ndarray_npy::{NpzReader, ReadNpzError};
use std::fs::File;
use std::path::Path;

/// Reads the report of the run in `dir`.
///
/// # Errors
/// Fails if the file cannot be read or is not a `run.json`.
pub fn run_report(dir: &Path) -> Result<RunReport> {
    let path = dir.join("run.json");
    let bytes = std::fs::read(&path).map_err(|e| Error::system(&path, format!("cannot be read: {e}"), e.kind()))?;
    serde_json::from_slice(&bytes).map_err(|e| Error::file(&path, format!("is not a report of a run: {e}")))
}

/// Reads the frames of a grasp from `arrays.npz`; `nodes` holds the number of nodes of each pad. Frames contain the
/// arrays of the file (of the dynamic state the hand pose alone) but not the numbers of `frames.csv`.
///
/// # Errors
/// Fails if the file is missing, damaged or belongs to other pads.
pub fn frames(path: &Path, nodes: &[usize]) -> Result<Vec<Frame>> {
    let fail = |message: String| Error::file(path, message);
    let file = File::open(path).map_err(|e| fail(format!("cannot be read: {e}")))?;
    let mut npz = NpzReader::new(file).map_err(|e| fail(format!("is not an archive of arrays: {e}")))?;
    let position = required_array::<Ix3>(path, &mut npz, names::POSITION)?;
    let displacement = required_array::<Ix3>(path, &mut npz, names::DISPLACEMENT)?;
    let (force, time) =
        (required_array::<Ix1>(path, &mut npz, names::FORCE)?, required_array::<Ix1>(path, &mut npz, names::TIME)?);
    let travel = required_array::<Ix2>(path, &mut npz, names::TRAVEL)?;
    let pose = required_array::<Ix2>(path, &mut npz, names::OBJECT_POSE)?;
    let load = optional::<Ix2>(path, &mut npz, names::OBJECT_LOAD)?;
    let wrench = required_array::<Ix3>(path, &mut npz, names::WRENCH)?;
    let contact = optional::<Ix3>(path, &mut npz, names::CONTACT_FORCE)?;
    let stress = optional::<Ix2>(path, &mut npz, names::VON_MISES)?;
    let gap = optional::<Ix2>(path, &mut npz, names::GAP)?;
    let hand = optional::<Ix2>(path, &mut npz, names::HAND_POSE)?;
    let (count, pads, all) = (force.len(), nodes.len(), nodes.iter().sum::<usize>());
    let vectors = [Some(&position), Some(&displacement), contact.as_ref()];
    let numbers = [stress.as_ref(), gap.as_ref()];
    let fits = vectors.into_iter().flatten().all(|a| a.shape() == [count, all, 3])
        && numbers.into_iter().flatten().all(|a| a.shape() == [count, all])
        && [Some(&pose), hand.as_ref()].into_iter().flatten().all(|a| a.shape() == [count, 7])
        && load.as_ref().is_none_or(|a| a.shape() == [count, 6])
        && travel.shape() == [count, pads]
        && wrench.shape() == [count, pads, 6]
        && time.len() == count;
    if !fits {
        return Err(fail(format!("its arrays are inconsistent, or are not those of {pads} pads with {nodes:?} nodes")));
    }
    let own = |pad: usize| {
        let first: usize = nodes[..pad].iter().sum();
        first..first + nodes[pad]
    };
    let vectors = |all: &Array<f64, Ix3>, k: usize, pad: usize| -> Vec<DVec3> {
        own(pad).map(|i| DVec3::new(all[[k, i, 0]], all[[k, i, 1]], all[[k, i, 2]])).collect()
    };
    let numbers = |all: &Array<f64, Ix2>, k: usize, pad: usize| -> Vec<f64> { own(pad).map(|i| all[[k, i]]).collect() };
    let placed = |all: &Array<f64, Ix2>, k: usize| Pose::from_row(&all.row(k).to_vec());
    let frame = |k: usize| {
        let pad = |pad: usize| {
            let part = |at: usize| DVec3::from_array([0, 1, 2].map(|i| wrench[[k, pad, at + i]]));
            PadFrame {
                position: vectors(&position, k, pad),
                displacement: vectors(&displacement, k, pad),
                contact_force: contact.as_ref().map_or(Vec::new(), |a| vectors(a, k, pad)),
                von_mises_node: stress.as_ref().map_or(Vec::new(), |a| numbers(a, k, pad)),
                gap: gap.as_ref().map_or(Vec::new(), |a| numbers(a, k, pad)),
                wrench: Wrench { force: part(0), torque: part(3) },
                ..PadFrame::default()
            }
        };
        let object = placed(&pose, k);
        let moving = hand.as_ref().map(|hand| {
            let hand = placed(hand, k);
            DynamicState { hand_position: hand.position, hand_rotation: hand.rotation, ..DynamicState::default() }
        });
        Frame {
            index: k,
            applied_force: force[k],
            time: time[k],
            travel: travel.row(k).to_vec(),
            object_position: object.position,
            object_rotation: object.rotation,
            object_load: load.as_ref().map_or_else(Wrench::default, |load| {
                let part = |at: usize| DVec3::from_array([0, 1, 2].map(|i| load[[k, at + i]]));
                Wrench { force: part(0), torque: part(3) }
            }),
            pads: (0..pads).map(pad).collect(),
            moving,
            ..Frame::default()
        }
    };
    Ok((0..count).map(frame).collect())
}

fn required_array<D: Dimension>(path: &Path, npz: &mut NpzReader<File>, name: &str) -> Result<Array<f64, D>> {
    optional(path, npz, name)?.ok_or_else(|| Error::file(path, format!("has no array `{name}`")))
}

/// Reads the array `name`; returns None if it was not recorded.
fn optional<D: Dimension>(path: &Path, npz: &mut NpzReader<File>, name: &str) -> Result<Option<Array<f64, D>>> {
    let fail = |e: ReadNpzError| Error::file(path, format!("array `{name}` cannot be read: {e}"));
    let names = npz.names().map_err(fail)?;
    match names.iter().find(|n| n.trim_end_matches(".npy") == name) {
        Some(name) => npz.by_name(name).map(Some).map_err(fail),
        None => Ok(None),
    }
}
