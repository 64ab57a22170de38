//! Version of the gmsh format, and messages that its readers share.

use crate::mesh::io::text;

/// Version of the format, which determines the order and width of the numbers in a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Version {
    V2,
    V40,
    V41,
}

impl Version {
    /// Parses the first word after `$MeshFormat`; the error states the allowed versions.
    pub fn of(word: &str) -> std::result::Result<Self, String> {
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

/// Error message for nodes with geometric parameters, which version 2 stores in a separate section.
pub(super) const PARAMETRIC: &str =
    "the nodes are in `$ParametricNodes`; save them without parameters (Mesh.SaveParametric = 0)";

/// Returns the error message for a section whose number of `what` differs from the declared one.
pub(super) fn declared(total: usize, found: usize, what: &str) -> String {
    format!("{total} {what} declared, but the blocks contain {found}: the file is truncated or changed; write it again")
}
