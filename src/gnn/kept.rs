//! The linear response of a pad, kept beside the weights of a model: solving for it takes far longer than a prediction.
//!
//! `pad-KEY.safetensors` is made by who needs it first and can be deleted at any time; KEY says for which mesh, gel and
//! version. A folder that cannot be written, or a file that does not fit, costs time and nothing else.

use super::compliance::Compliance;
use super::deviator::{Deviator, PARTS};
use crate::model::FingerModel;
use crate::record::files::write_atomic;
use safetensors::tensor::{Dtype, SafeTensors, TensorView, serialize};
use std::path::{Path, PathBuf};

/// Bonded nodes have no slot.
const NONE: u32 = u32::MAX;

/// The file for the pad of `finger`, whose mesh has this hash.
pub fn path(dir: &Path, finger: &FingerModel, mesh: &str) -> PathBuf {
    let material = &finger.body.material;
    let what = format!("{mesh} {} {} {}", material.name(), material.moduli().poisson, env!("CARGO_PKG_VERSION"));
    dir.join(format!("pad-{}.safetensors", &blake3::hash(what.as_bytes()).to_hex()[..16]))
}

/// Reads a response; None if there is none that is whole.
pub fn read(path: &Path) -> Option<Compliance> {
    let bytes = std::fs::read(path).ok()?;
    let file = SafeTensors::deserialize(&bytes).ok()?;
    let floats = |name: &str| -> Option<(Vec<f32>, Vec<usize>)> {
        let view = file.tensor(name).ok().filter(|v| v.dtype() == Dtype::F32)?;
        Some((view.data().as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect(), view.shape().to_vec()))
    };
    let numbers = |name: &str| -> Option<Vec<u32>> {
        let view = file.tensor(name).ok().filter(|v| v.dtype() == Dtype::U32)?;
        Some(view.data().as_chunks().0.iter().map(|b| u32::from_le_bytes(*b)).collect())
    };
    let (response, shape) = floats("response").filter(|(_, shape)| shape.len() == 2)?;
    let (parts, _) = floats("deviator")?;
    let [slot, start, neighbour] = [numbers("slot")?, numbers("start")?, numbers("neighbour")?];
    let moving = (shape[0] / 3) as u32;
    let slot: Vec<Option<u32>> = slot.into_iter().map(|s| (s != NONE).then_some(s)).collect();
    let whole = parts.len() == PARTS * neighbour.len()
        && start.len() == slot.len() + 1
        && start.is_sorted()
        && start.last().is_some_and(|n| *n as usize == neighbour.len())
        && slot.iter().flatten().chain(&neighbour).all(|s| *s < moving)
        && response.iter().all(|v| v.is_finite());
    let neighbour = neighbour.into_iter().zip(parts.as_chunks::<PARTS>().0.iter().copied()).collect();
    whole.then(|| Compliance::from_parts(slot, response, shape[1], Deviator { start, neighbour }))
}

/// Keeps a response, whole or not at all.
pub fn write(path: &Path, compliance: &Compliance) {
    let bytes = |v: &mut dyn Iterator<Item = [u8; 4]>| v.flatten().collect::<Vec<u8>>();
    let Deviator { start, neighbour } = &compliance.deviator;
    let (forces, rows) = (compliance.forces, compliance.response.len() / compliance.forces.max(1));
    let slots = compliance.slot.iter().map(|s| s.unwrap_or(NONE).to_le_bytes());
    let all = [
        ("response", Dtype::F32, vec![rows, forces], bytes(&mut compliance.response.iter().map(|v| v.to_le_bytes()))),
        ("slot", Dtype::U32, vec![compliance.slot.len()], bytes(&mut slots.into_iter())),
        ("start", Dtype::U32, vec![start.len()], bytes(&mut start.iter().map(|v| v.to_le_bytes()))),
        ("neighbour", Dtype::U32, vec![neighbour.len()], bytes(&mut neighbour.iter().map(|n| n.0.to_le_bytes()))),
        (
            "deviator",
            Dtype::F32,
            vec![neighbour.len(), PARTS],
            bytes(&mut neighbour.iter().flat_map(|n| n.1).map(f32::to_le_bytes)),
        ),
    ];
    let views = all.iter().map(|(name, kind, shape, data)| Some((*name, TensorView::new(*kind, shape.clone(), data).ok()?)));
    let done = views.collect::<Option<Vec<_>>>().and_then(|views| serialize(views, None).ok());
    // Who cannot keep it solves again next time.
    let _ = done.map(|bytes| write_atomic(path, &bytes));
}
