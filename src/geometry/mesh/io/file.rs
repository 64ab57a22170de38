//! Content of mesh files.

use super::text;
use base::error::Result;
use base::files::regular;
use std::path::Path;

/// Size of the largest file that is read, bytes.
const MAX_BYTES: u64 = 1 << 31;

/// Returns all bytes of a mesh file.
pub(super) fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    regular::read(path, MAX_BYTES)
}

/// Reads a text file, see [`text::decode`].
pub(crate) fn read_text(path: &Path) -> Result<String> {
    text::decode(path, read_bytes(path)?)
}
