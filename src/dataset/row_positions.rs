//! Positions of the rows in a file, and checksums. The rows of a grasp have a checksum in the file, and all other bytes
//! have one in the manifest, so that a reader verifies what it reads without reading the whole file.

use super::arrays::{FileSizes, RowLayout, RowName};
use base::error::{Error, Result};
use hdf5_pure::{File, Layout};
use serde::{Deserialize, Serialize};
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

/// Start of the rows of each array, bytes from the start of the file, and length of a row, in the order of
/// [`FileSizes::rows`].
#[derive(Debug, Clone)]
pub struct RowPositions {
    grasps: usize,
    rows: Vec<(u64, usize)>,
}

impl RowPositions {
    /// Finds the rows of the file at `path`.
    ///
    /// # Errors
    /// Fails if the file does not have the layout for `sizes`; the error names the array.
    pub fn find(path: &Path, file: &File, sizes: &FileSizes) -> Result<Self> {
        let place = |array: RowLayout| {
            let fail = |message: String| Error::file(path, format!("array `{}`: {message}", array.name));
            let dataset = file.dataset(array.name).map_err(|e| fail(e.to_string()))?;
            let wanted = sizes.grasps as u64 * array.bytes() as u64;
            match dataset.layout().map_err(|e| fail(e.to_string()))? {
                Layout::Contiguous { address: Some(at), size } if size == wanted && at + size <= file.file_size() => {
                    Ok((at, array.bytes()))
                }
                Layout::Contiguous { size, .. } => Err(fail(format!("{size} bytes instead of {wanted}, or truncated"))),
                _ => Err(fail("is not contiguous; write the file with `tactus dataset`".into())),
            }
        };
        Ok(Self { grasps: sizes.grasps, rows: sizes.rows().map(place).collect::<Result<_>>()? })
    }

    /// Returns the first byte of the row of `grasp` in the array with this index, and its length.
    pub fn row(&self, array: usize, grasp: usize) -> (u64, usize) {
        let (start, length) = self.rows[array];
        (start + (grasp * length) as u64, length)
    }

    /// Reads all rows of a grasp from an open file.
    ///
    /// # Errors
    /// Fails if the file is too short.
    pub fn read(&self, file: &mut std::fs::File, grasp: usize) -> std::io::Result<Vec<Vec<u8>>> {
        let read = |array| {
            let (start, length) = self.row(array, grasp);
            let mut row = Vec::with_capacity(length);
            file.seek(SeekFrom::Start(start))?;
            (&mut *file).take(length as u64).read_to_end(&mut row)?;
            if row.len() == length { Ok(row) } else { Err(std::io::ErrorKind::UnexpectedEof.into()) }
        };
        (0..self.rows.len()).map(read).collect()
    }

    /// Returns the byte ranges (start, length) of the arrays for which `pick` holds, ascending; adjacent ranges are
    /// joined.
    pub fn ranges(&self, pick: impl Fn(usize) -> bool) -> Vec<[u64; 2]> {
        let picked = self.rows.iter().enumerate().filter(|(array, _)| pick(*array));
        let mut all: Vec<[u64; 2]> = picked.map(|(_, (start, row))| [*start, (self.grasps * row) as u64]).collect();
        all.sort_unstable();
        all.dedup_by(|next, last| {
            let joins = last[0] + last[1] == next[0];
            last[1] += if joins { next[1] } else { 0 };
            joins
        });
        all
    }
}

/// Returns true if rows of this array are verified by the checksum of the grasp whenever they are read. Status and
/// checksum are excluded: the status of all grasps is read without the other rows, and a checksum does not cover
/// itself.
pub fn is_row_verified(array: usize) -> bool {
    array != RowName::Status as usize && array != RowName::Checksum as usize
}

/// Checksum of the bytes of a file that are not covered by the checksums of its grasps; it is quick to verify.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RemainderChecksum {
    /// Byte ranges that are excluded (start, length; ascending).
    pub apart: Vec<[u64; 2]>,
    /// BLAKE3 of the other bytes.
    pub blake3: String,
}

impl RemainderChecksum {
    /// Computes the seal of the file at `path`, excluding the byte ranges `apart` (start, length; ascending).
    ///
    /// # Errors
    /// Fails if the file cannot be read or is too short for these ranges.
    pub fn of(path: &Path, apart: Vec<[u64; 2]>) -> Result<Self> {
        let hash = || {
            let mut file = std::fs::File::open(path)?;
            let (mut hasher, mut at) = (blake3::Hasher::new(), 0);
            for [start, length] in apart.iter().copied().chain([[file.metadata()?.len(), 0]]) {
                let gap = start.checked_sub(at).ok_or(std::io::ErrorKind::UnexpectedEof)?;
                file.seek(SeekFrom::Start(at))?;
                hasher.update_reader((&mut file).take(gap))?;
                at = start.checked_add(length).ok_or(std::io::ErrorKind::InvalidData)?;
            }
            Ok(hasher.finalize().to_hex().to_string())
        };
        let blake3 =
            hash().map_err(|e: std::io::Error| Error::system(path, format!("cannot be read: {e}"), e.kind()))?;
        Ok(Self { apart, blake3 })
    }

    /// Returns true if the file at `path` has this seal.
    ///
    /// # Errors
    /// Fails if the file cannot be read.
    pub fn matches(&self, path: &Path) -> Result<bool> {
        Ok(Self::of(path, self.apart.clone())?.blake3 == self.blake3)
    }
}
