//! Cache of the linear responses of pads in the user's cache folder: computing one takes far longer than a prediction.
//!
//! `KEY.pad` is created when it is first needed and can be deleted at any time; KEY identifies mesh, gel and version. A
//! file consists of a safetensors file and its BLAKE3 hash. Two processes may create the same file at once: both write
//! the same content. A folder that cannot be written only costs time; a damaged file is removed and created again.

use super::compliance::Compliance;
use super::deviator::{DeviatoricStressMap, PARTS};
use crate::matrix::numbers::MappedFile;
use base::files::atomic::{create_dir, write_atomic};
use etcetera::BaseStrategy;
use model::part::FingerModel;
use pulp::bytemuck::{AnyBitPattern, NoUninit, cast_slice};
use safetensors::tensor::{Dtype, Metadata, TensorView, serialize};
use std::borrow::Cow;
use std::collections::HashMap;
use std::fs::File;
use std::path::PathBuf;
use std::time::SystemTime;

/// Version of the responses; those of other versions are recomputed.
const VERSION: u32 = 3;

/// Largest total size of the cached files, bytes: enough for the pads of a universe. The least recently used files are
/// removed first.
pub const MOST: u64 = 6 << 30;

/// Slot in a file for a bonded node, which has none.
const NONE: u32 = u32::MAX;
/// Number of bytes of the hash at the end of a file.
const SUM: usize = blake3::OUT_LEN;
/// Name of the key in the metadata of a file.
const KEY: &str = "key";

/// Folder of cached responses.
#[derive(Debug, Clone)]
pub struct ComplianceCache {
    dir: PathBuf,
}

/// Identity of a response: its mesh, gel and version.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ComplianceKey(String);

impl ComplianceKey {
    /// Creates the key for the pad of `finger` with the sensing nodes `face`, whose mesh has this hash.
    pub fn of(finger: &FingerModel, face: &[u32], mesh: &str) -> Self {
        let (body, material) = (&finger.body, &finger.body.material);
        let mut hasher = blake3::Hasher::new();
        let (law, poisson, dilatation) = (material.name(), material.moduli().poisson, body.mean_dilatation);
        hasher
            .update(format!("{mesh} {law} {poisson} {dilatation} {VERSION} {}", env!("CARGO_PKG_VERSION")).as_bytes());
        let fixed: Vec<u8> = body.fixed.iter().map(|f| u8::from(*f)).collect();
        Self(hasher.update(&fixed).update(&bytes(face)).finalize().to_hex().to_string())
    }
}

impl ComplianceCache {
    /// Returns the cache of the user: `tactus` in `$XDG_CACHE_HOME` (`~/.cache`), `~/Library/Caches` or
    /// `%LOCALAPPDATA%`. None if there is no such folder.
    pub fn of_user() -> Option<Self> {
        let base = etcetera::base_strategy::choose_native_strategy().ok()?;
        Some(Self::at(base.cache_dir().join("tactus")))
    }

    /// Returns the cache in the folder `dir`, which need not exist.
    pub fn at(dir: impl Into<PathBuf>) -> Self {
        Self { dir: dir.into() }
    }

    /// Returns the path of the file of a response.
    pub fn path(&self, key: &ComplianceKey) -> PathBuf {
        self.dir.join(format!("{:.32}.pad", key.0))
    }

    /// Reads the response for `key`; None if it is not there. A damaged file is removed.
    pub fn read(&self, key: &ComplianceKey) -> Option<Compliance> {
        let path = self.path(key);
        let file = File::open(&path).ok()?;
        // The modification time is that of the last use, for `make_room`; a folder of another user keeps its times.
        let _ = file.set_modified(SystemTime::now());
        let found = MappedFile::of(&file).and_then(|map| response(&map, key));
        if found.is_none() {
            let _ = std::fs::remove_file(&path);
        }
        found
    }

    /// Writes a response atomically.
    pub fn write(&self, key: &ComplianceKey, compliance: &Compliance) {
        let Some(content) = content(key, compliance) else { return };
        if create_dir(&self.dir).is_ok() && self.make_room(content.len() as u64) {
            // After a failure the response is computed again next time.
            let _ = write_atomic(&self.path(key), &content);
        }
    }

    /// Removes the least recently used files until there is room for `bytes` more; returns false if there is not enough
    /// room.
    fn make_room(&self, bytes: u64) -> bool {
        let entries = std::fs::read_dir(&self.dir).into_iter().flatten().flatten();
        // This includes temporary files that killed processes left.
        let of = |e: std::fs::DirEntry| Some((e.metadata().ok()?.modified().ok()?, e.metadata().ok()?.len(), e.path()));
        let mut files: Vec<(SystemTime, u64, PathBuf)> = entries.filter_map(of).collect();
        files.sort();
        let mut held: u64 = files.iter().map(|f| f.1).sum();
        for (_, size, path) in files {
            if held + bytes <= MOST {
                break;
            }
            held -= if std::fs::remove_file(path).is_ok() { size } else { 0 };
        }
        held + bytes <= MOST
    }
}

/// Returns the response in an undamaged file with this key.
fn response(map: &MappedFile, key: &ComplianceKey) -> Option<Compliance> {
    let (body, sum) = map.bytes().split_last_chunk::<SUM>()?;
    if blake3::hash(body).as_bytes() != sum {
        return None;
    }
    let (size, rest) = body.split_first_chunk::<8>()?;
    let size = usize::try_from(u64::from_le_bytes(*size)).ok()?;
    let names: Metadata = serde_json::from_slice(rest.get(..size)?).ok()?;
    if names.metadata().as_ref()?.get(KEY) != Some(&key.0) {
        return None;
    }
    // Floats are nearly the entire file: they stay memory-mapped where the system supports it.
    let numbers = |name: &str, kind: Dtype| {
        let info = names.info(name).filter(|i| i.dtype == kind)?;
        let count = info.shape.iter().try_fold(1, |n: usize, k| n.checked_mul(*k))?;
        let numbers = map.numbers(8 + size + info.data_offsets.0, count)?;
        Some((numbers, info.shape.last().copied().unwrap_or(1)))
    };
    let (response, forces) = numbers("response", Dtype::F32)?;
    let (parts, _) = numbers("deviator", Dtype::F32)?;
    let integers = |name: &str| Some(numbers(name, Dtype::U32)?.0.iter().map(|v| v.to_bits()).collect::<Vec<u32>>());
    let [slot, start, neighbour] = [integers("slot")?, integers("start")?, integers("neighbour")?];
    let slot = slot.into_iter().map(|s| (s != NONE).then_some(s)).collect();
    Some(Compliance::from_parts(slot, response, forces, DeviatoricStressMap { start, slot: neighbour, parts }))
}

/// Returns the content of the file of a response.
fn content(key: &ComplianceKey, compliance: &Compliance) -> Option<Vec<u8>> {
    let DeviatoricStressMap { start, slot, parts } = &compliance.deviator;
    let (forces, rows) = (compliance.forces, compliance.displacement_count());
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
    let views = views.collect::<Option<Vec<_>>>()?;
    let mut content = serialize(views, Some(HashMap::from([(KEY.into(), key.0.clone())]))).ok()?;
    let sum = blake3::hash(&content);
    content.extend(sum.as_bytes());
    Some(content)
}

/// Returns numbers of four bytes each in little-endian order, as in a file.
fn bytes<T: NoUninit + AnyBitPattern>(numbers: &[T]) -> Cow<'_, [u8]> {
    let native: &[u8] = cast_slice(numbers);
    if cfg!(target_endian = "little") {
        return native.into();
    }
    native.as_chunks::<4>().0.iter().flat_map(|[a, b, c, d]| [*d, *c, *b, *a]).collect()
}
