//! gmsh `.msh`, versions 2, 4.0 and 4.1, ASCII and binary: tetrahedra of first and second order. Tags may be sparse.
//!
//! Layout of the sections: gmsh reference manual, "MSH file format" and its legacy versions.

mod ascii;
mod binary;
mod collect;
mod cursor;
mod groups;

use std::path::Path;

use super::{convert, text};
use crate::mesh::TetMesh;
use base::error::{Error, Result};

/// Version of the format, which determines the order and width of the numbers in a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Version {
    V2,
    V40,
    V41,
}

impl Version {
    /// Parses the first word after `$MeshFormat`; the error states the allowed versions.
    fn of(word: &str) -> std::result::Result<Self, String> {
        match word {
            "2" | "2.0" | "2.1" | "2.2" => Ok(Self::V2),
            "4" | "4.0" => Ok(Self::V40),
            "4.1" => Ok(Self::V41),
            other => {
                let found = text::quote(other);
                Err(format!("gmsh format {found}; allowed: 2.2, 4.0 or 4.1 (gmsh -format msh41 writes 4.1)"))
            }
        }
    }
}

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

/// Error message for nodes with geometric parameters, which version 2 stores in a separate section.
const PARAMETRIC: &str = "the nodes are in `$ParametricNodes`; save them without parameters (Mesh.SaveParametric = 0)";

/// Returns the error message for a section whose number of `what` differs from the declared one.
fn declared(total: usize, found: usize, what: &str) -> String {
    format!("{total} {what} declared, but the blocks contain {found}: the file is truncated or changed; write it again")
}

/// Returns true if the second word after `$MeshFormat` is the 1 of a binary file.
fn is_binary(bytes: &[u8]) -> bool {
    let Some(start) = find(bytes, b"$MeshFormat") else { return false };
    let line = bytes[start..].split(|b| *b == b'\n').nth(1).unwrap_or_default();
    line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty()).nth(1) == Some(b"1")
}

/// Returns the first position of `wanted`.
fn find(bytes: &[u8], wanted: &[u8]) -> Option<usize> {
    bytes.windows(wanted.len()).position(|w| w == wanted)
}
