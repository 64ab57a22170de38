//! The linear response of a pad, kept beside the weights of a model: solving for it takes far longer than a prediction.
//!
//! `pad-KEY.safetensors` is made by who needs it first and can be deleted at any time; KEY says for which mesh, gel and
//! version. A folder that cannot be written, or a file that does not fit, costs time and nothing else.

use super::compliance::Compliance;
use super::deviator::{Deviator, PARTS};
use super::numbers::{Map, Numbers};
use crate::model::FingerModel;
use crate::record::files::write_atomic;
use pulp::bytemuck::{AnyBitPattern, NoUninit, cast_slice, cast_slice_mut};
use safetensors::tensor::{Dtype, Metadata, TensorView, serialize};
use std::borrow::Cow;
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
    // Floats are nearly the whole file: they stay there, where the system can map it.
    let map = Map::of(&file);
    let mut numbers = |name: &str, kind: Dtype| {
        let info = names.info(name).filter(|i| i.dtype == kind)?;
        let count = info.shape.iter().try_fold(1, |n: usize, k| n.checked_mul(*k))?;
        let from = start + info.data_offsets.0 as u64;
        let mapped = map.as_ref().filter(|_| kind == Dtype::F32);
        let mapped = mapped.and_then(|map| map.numbers(usize::try_from(from).ok()?, count));
        let numbers = mapped.or_else(|| floats(&mut file, from, count).map(Numbers::from))?;
        Some((numbers, info.shape.last().copied().unwrap_or(1)))
    };
    let (response, forces) = numbers("response", Dtype::F32)?;
    let (parts, _) = numbers("deviator", Dtype::F32)?;
    let mut integers =
        |name: &str| Some(numbers(name, Dtype::U32)?.0.iter().map(|v| v.to_bits()).collect::<Vec<u32>>());
    let [slot, start, neighbour] = [integers("slot")?, integers("start")?, integers("neighbour")?];
    let moving = (response.len() / forces.max(1) / 3) as u32;
    let slot: Vec<Option<u32>> = slot.into_iter().map(|s| (s != NONE).then_some(s)).collect();
    let whole = parts.len() == PARTS * neighbour.len()
        && start.len() == slot.len() + 1
        && start.is_sorted()
        && start.last().is_some_and(|n| *n as usize == neighbour.len())
        && slot.iter().flatten().chain(&neighbour).all(|s| *s < moving);
    whole.then(|| Compliance::from_parts(slot, response, forces, Deviator { start, slot: neighbour, parts }))
}

/// The `count` numbers from byte `from` of a file on.
fn floats(file: &mut File, from: u64, count: usize) -> Option<Vec<f32>> {
    // A file that says it holds more than it does is not believed.
    (count as u64 <= file.metadata().ok()?.len() / 4).then_some(())?;
    file.seek(SeekFrom::Start(from)).ok()?;
    let mut numbers = vec![0.0_f32; count];
    file.read_exact(cast_slice_mut(&mut numbers)).ok()?;
    if cfg!(target_endian = "big") {
        numbers.iter_mut().for_each(|v| *v = f32::from_bits(v.to_bits().swap_bytes()));
    }
    Some(numbers)
}

/// Keeps a response, whole or not at all.
pub fn write(path: &Path, compliance: &Compliance) {
    let Deviator { start, slot, parts } = &compliance.deviator;
    let (forces, rows) = (compliance.forces, compliance.moving());
    let slots: Vec<u32> = compliance.slot.iter().map(|s| s.unwrap_or(NONE)).collect();
    let all = [
        ("response", Dtype::F32, vec![rows, forces], bytes(&compliance.response)),
        ("slot", Dtype::U32, vec![slots.len()], bytes(&slots)),
        ("start", Dtype::U32, vec![start.len()], bytes(start)),
        ("neighbour", Dtype::U32, vec![slot.len()], bytes(slot)),
        ("deviator", Dtype::F32, vec![slot.len(), PARTS], bytes(parts)),
    ];
    let views =
        all.iter().map(|(name, kind, shape, data)| Some((*name, TensorView::new(*kind, shape.clone(), data).ok()?)));
    let done = views.collect::<Option<Vec<_>>>().and_then(|views| serialize(views, None).ok());
    // Who cannot keep it solves again next time.
    let _ = done.map(|bytes| write_atomic(path, &bytes));
}

/// Numbers of four bytes each as they lie in a file, little endian.
fn bytes<T: NoUninit + AnyBitPattern>(numbers: &[T]) -> Cow<'_, [u8]> {
    let native: &[u8] = cast_slice(numbers);
    if cfg!(target_endian = "little") {
        return native.into();
    }
    native.as_chunks::<4>().0.iter().flat_map(|[a, b, c, d]| [*d, *c, *b, *a]).collect()
}
