//! Large constant arrays of f32, owned by this process or memory-mapped from a file.
#![allow(unsafe_code, reason = "mapping a file is unsafe because another process may write to it")]

use memmap2::Mmap;
use pulp::bytemuck::try_cast_slice;
use std::fs::File;
use std::ops::{Deref, Range};
use std::sync::Arc;

/// Memory-mapped file; its pages are read on first access.
#[derive(Debug, Clone)]
pub struct MappedFile(Arc<Mmap>);

impl MappedFile {
    /// Maps a file. It must never be changed in place, only replaced as a whole, as this crate does when it writes.
    /// Returns None if the system cannot map it.
    pub fn of(file: &File) -> Option<Self> {
        // SAFETY: see above; truncating a mapped file ends this process (SIGBUS), as with any memory mapping.
        let map = unsafe { Mmap::map(file) }.ok()?;
        Some(Self(Arc::new(map)))
    }

    /// Returns all bytes of the file.
    pub fn bytes(&self) -> &[u8] {
        &self.0
    }

    /// Returns the `count` numbers (f32, little endian) from byte `start` on. Returns None if the file is too short or
    /// if this processor cannot read them in place (byte order or alignment).
    pub fn numbers(&self, start: usize, count: usize) -> Option<F32Array> {
        let range = start..start.checked_add(count.checked_mul(4)?)?;
        let bytes = self.0.get(range.clone())?;
        let fits = cfg!(target_endian = "little") && try_cast_slice::<u8, f32>(bytes).is_ok();
        fits.then(|| F32Array(Source::File(self.clone(), range)))
    }
}

/// Constant slice of f32, cheap to clone.
#[derive(Debug, Clone)]
pub struct F32Array(Source);

#[derive(Debug, Clone)]
enum Source {
    Own(Arc<Vec<f32>>),
    File(MappedFile, Range<usize>),
}

impl From<Vec<f32>> for F32Array {
    fn from(numbers: Vec<f32>) -> Self {
        Self(Source::Own(Arc::new(numbers)))
    }
}

impl Deref for F32Array {
    type Target = [f32];

    fn deref(&self) -> &[f32] {
        match &self.0 {
            Source::Own(numbers) => numbers,
            // `MappedFile::numbers` has checked range and alignment.
            Source::File(map, range) => try_cast_slice(&map.0[range.clone()]).unwrap_or_default(),
        }
    }
}
