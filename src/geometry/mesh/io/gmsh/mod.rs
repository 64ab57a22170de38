//! gmsh `.msh`, versions 2, 4.0 and 4.1, ASCII and binary: tetrahedra of first and second order. Tags may be sparse.
//!
//! Layout of the sections: gmsh reference manual, "MSH file format" and its legacy versions.

mod ascii;
mod binary;
mod collect;
mod cursor;
mod groups;
mod version;

use std::path::Path;

use super::convert::convert;
use super::text;
use crate::mesh::TetMesh;
use base::error::{Error, Result};
use cursor::find;

/// Parses an ASCII or binary gmsh file; `path` is for messages. Keeps the tetrahedra of the physical volume with the
/// name or tag `group`; None keeps all.
///
/// # Errors
/// Fails for an unknown version, declared counts that exceed the cap or differ from the content, repeated or unknown
/// tags, bad numbers, an unknown group and no tetrahedra. The error states line and column of a text file, the byte
/// offset of a binary file.
pub(crate) fn parse(path: &Path, bytes: Vec<u8>, group: Option<&str>) -> Result<(TetMesh, Vec<String>)> {
    // Files of ANSYS have the same extension and start with a parenthesis.
    if bytes.trim_ascii_start().starts_with(b"(") {
        return Err(Error::file(path, format!("a file of ANSYS, not of gmsh; {}", convert(path))));
    }
    if is_binary(&bytes) {
        return binary::parse(path, &bytes, group);
    }
    ascii::parse(path, &text::decode(path, bytes)?, group)
}

/// Returns true if the second word after `$MeshFormat` is the 1 of a binary file.
fn is_binary(bytes: &[u8]) -> bool {
    let Some(start) = find(bytes, b"$MeshFormat") else { return false };
    let line = bytes[start..].split(|b| *b == b'\n').nth(1).unwrap_or_default();
    line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty()).nth(1) == Some(b"1")
}
