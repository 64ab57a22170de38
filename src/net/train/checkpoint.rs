//! State of a training run on disk, in one file that is replaced atomically.

use super::curves::Epoch;
use super::training_state::TrainingState;
use crate::autodiff::tensor::values;
use crate::network::parameters::Parameters;
use base::error::{Error, Result};
use base::files::atomic::write_durable;
use dfdx::prelude::{HasShape, Shape};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Name of the file; it is removed when the model is finished.
const CHECKPOINT: &str = "checkpoint.bin";

/// Header before the values.
#[derive(Serialize, Deserialize)]
struct Header {
    plan: String,
    step: u64,
    epochs: Vec<Epoch>,
    /// Length of each parameter.
    lengths: Vec<usize>,
}

/// Returns the number of values of each parameter.
fn lengths(parameters: &Parameters) -> Vec<usize> {
    parameters.matrices.iter().map(|m| m.shape().num_elements()).collect()
}

fn path(dir: &Path) -> PathBuf {
    dir.join(CHECKPOINT)
}

/// Writes the state: a line of RON (which restores numbers exactly), then weights, best weights and both moments, f32,
/// little-endian, and a checksum.
///
/// # Errors
/// Fails if the header cannot be serialised or the file cannot be written.
pub fn write(dir: &Path, plan: &str, state: &TrainingState) -> Result<()> {
    let header = Header {
        plan: plan.into(),
        step: state.adam.step,
        epochs: state.epochs.clone(),
        lengths: lengths(&state.parameters),
    };
    let mut bytes = ron::to_string(&header).map_err(|e| Error::file(path(dir), e.to_string()))?.into_bytes();
    bytes.push(b'\n');
    let weights = [&state.parameters, &state.best].into_iter().flat_map(|p| &p.matrices).map(values);
    let moments = [&state.adam.first, &state.adam.second].into_iter().flatten().map(|m| m.to_vec());
    weights.chain(moments).flatten().for_each(|v| bytes.extend(v.to_le_bytes()));
    bytes.extend(blake3::hash(&bytes).as_bytes());
    write_durable(&path(dir), &bytes)
}

/// State of an earlier run found on disk.
pub enum StoredCheckpoint {
    /// No file.
    Nothing,
    /// File whose checksum or layout is wrong.
    Damaged(PathBuf),
    /// State of the earlier run.
    State(Box<TrainingState>),
}

/// Reads the state of an earlier run of the same plan. `like` defines the shapes.
///
/// # Errors
/// Fails for a file of another plan, and for one that cannot be read.
pub fn read(dir: &Path, plan: &str, like: &TrainingState) -> Result<StoredCheckpoint> {
    let path = path(dir);
    let fail = |message: &str| Error::file(&path, message);
    let bytes = match std::fs::read(&path) {
        Ok(bytes) => bytes,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(StoredCheckpoint::Nothing),
        Err(e) => return Err(fail(&format!("cannot be read: {e}"))),
    };
    let whole = bytes.split_last_chunk::<32>().filter(|(body, sum)| blake3::hash(body).as_bytes() == *sum);
    let header = |body: &[u8]| {
        let end = body.iter().position(|b| *b == b'\n')?;
        Some((ron::de::from_bytes::<Header>(&body[..end]).ok()?, end))
    };
    let Some((body, (header, end))) = whole.and_then(|(body, _)| Some((body, header(body)?))) else {
        return Ok(StoredCheckpoint::Damaged(path));
    };
    if header.plan != plan {
        return Err(fail(
            "belongs to another training (data, split, model file or version differ); choose another folder",
        ));
    }
    let lengths = lengths(&like.parameters);
    let numbers: Vec<f32> = body[end + 1..].as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
    let total: usize = lengths.iter().sum();
    if header.lengths != lengths || numbers.len() != 4 * total {
        return Ok(StoredCheckpoint::Damaged(path));
    }
    let mut state = like.clone();
    let mut rest = numbers.as_slice();
    let mut next = |n: usize| {
        let (own, tail) = rest.split_at(n);
        rest = tail;
        own
    };
    for parameters in [&mut state.parameters, &mut state.best] {
        parameters.matrices.iter_mut().zip(&lengths).for_each(|(m, n)| m.copy_from(next(*n)));
    }
    for moments in [&mut state.adam.first, &mut state.adam.second] {
        moments.iter_mut().zip(&lengths).for_each(|(m, n)| m.copy_from_slice(next(*n)));
    }
    (state.adam.step, state.epochs) = (header.step, header.epochs);
    Ok(StoredCheckpoint::State(Box::new(state)))
}

/// Removes the file of a finished run.
///
/// # Errors
/// Fails if the file exists and cannot be removed.
pub fn remove(dir: &Path) -> Result<()> {
    match std::fs::remove_file(path(dir)) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => {
            Err(Error::file(path(dir), format!("cannot be removed: {e}")))
        }
        _ => Ok(()),
    }
}
