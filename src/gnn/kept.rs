//! The linear response of a pad, kept beside the weights of a model: solving for it takes far longer than a prediction.
//!
//! `pad-KEY.safetensors` is made by who needs it first and can be deleted at any time; KEY says for which mesh, gel and
//! version. A folder that cannot be written, or a file that does not fit, costs time and nothing else.

use super::compliance::Compliance;
use super::deviator::{Deviator, PARTS};
use crate::model::FingerModel;
use crate::record::files::write_atomic;
use safetensors::tensor::{Dtype, Metadata, TensorView, serialize};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// Bonded nodes have no slot.
const NONE: u32 = u32::MAX;
/// A head of a file is shorter than this, bytes.
const MOST: usize = 1 << 20;

/// The file for the pad of `finger`, whose mesh has this hash.
pub fn path(dir: &Path, finger: &FingerModel, mesh: &str) -> PathBuf {
    let material = &finger.body.material;
    let what = format!("{mesh} {} {} {}", material.name(), material.moduli().poisson, env!("CARGO_PKG_VERSION"));
    dir.join(format!("pad-{}.safetensors", &blake3::hash(what.as_bytes()).to_hex()[..16]))
}

/// Reads a response; None if there is none that is whole.
pub fn read(path: &Path) -> Option<Compliance> {
    let mut file = File::open(path).ok()?;
    let mut size = [0; 8];
    file.read_exact(&mut size).ok()?;
    let size = usize::try_from(u64::from_le_bytes(size)).ok().filter(|n| *n < MOST)?;
    let mut head = vec![0; size];
    file.read_exact(&mut head).ok()?;
    let names: Metadata = serde_json::from_slice(&head).ok()?;
    let start = 8 + size as u64;
    // Straight to where the numbers stay: the response is all but the whole file.
    let at = |file: &mut File, name: &str, kind: Dtype| {
        let info = names.info(name).filter(|i| i.dtype == kind)?;
        file.seek(SeekFrom::Start(start + info.data_offsets.0 as u64)).ok()?;
        Some(info.shape.clone())
    };
    let shape = at(&mut file, "response", Dtype::F32).filter(|shape| shape.len() == 2)?;
    let response = floats(&mut file, shape[0] * shape[1])?;
    let count = at(&mut file, "deviator", Dtype::F32)?;
    let parts = floats(&mut file, count.iter().product())?;
    let mut numbers = |name: &str| {
        let count = at(&mut file, name, Dtype::U32)?;
        Some(floats(&mut file, count.iter().product())?.into_iter().map(f32::to_bits).collect::<Vec<u32>>())
    };
    let [slot, start, neighbour] = [numbers("slot")?, numbers("start")?, numbers("neighbour")?];
    let moving = (shape[0] / 3) as u32;
    let slot: Vec<Option<u32>> = slot.into_iter().map(|s| (s != NONE).then_some(s)).collect();
    let whole = parts.len() == PARTS * neighbour.len()
        && start.len() == slot.len() + 1
        && start.is_sorted()
        && start.last().is_some_and(|n| *n as usize == neighbour.len())
        && slot.iter().flatten().chain(&neighbour).all(|s| *s < moving);
    let neighbour = neighbour.into_iter().zip(parts.as_chunks::<PARTS>().0.iter().copied()).collect();
    whole.then(|| Compliance::from_parts(slot, response, shape[1], Deviator { start, neighbour }))
}

/// The next `count` numbers of a file.
fn floats(file: &mut File, count: usize) -> Option<Vec<f32>> {
    // A file that says it holds more than it does is not believed.
    (4 * count as u64 <= file.metadata().ok()?.len()).then_some(())?;
    let mut numbers = vec![0.0_f32; count];
    file.read_exact(pulp::bytemuck::cast_slice_mut(&mut numbers)).ok()?;
    if cfg!(target_endian = "big") {
        numbers.iter_mut().for_each(|v| *v = f32::from_bits(v.to_bits().swap_bytes()));
    }
    Some(numbers)
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
    let views =
        all.iter().map(|(name, kind, shape, data)| Some((*name, TensorView::new(*kind, shape.clone(), data).ok()?)));
    let done = views.collect::<Option<Vec<_>>>().and_then(|views| serialize(views, None).ok());
    // Who cannot keep it solves again next time.
    let _ = done.map(|bytes| write_atomic(path, &bytes));
}
