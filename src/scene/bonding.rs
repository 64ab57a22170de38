//! Selection of the nodes of a pad from a file that are bonded to the finger.

use super::leaf::{Depth, Finite};
use super::vector::Vec3;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Selection of the nodes that are bonded to the finger. Directions and positions are in the axes of the pad file,
/// lengths in metres.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum BondingRule {
    /// Nodes on or behind a plane, or within a distance in front of it.
    Plane(BondingPlane),
    /// Nodes within a distance of the surface of the part that carries the gel, or inside it.
    NearMesh(BondingMesh),
    /// Nodes with these indices in the order of the file, from 0.
    Nodes(Vec<usize>),
    /// Nodes listed in a text file: either their indices, from 0, or a 0 or 1 for each node of the mesh.
    NodesFile(PathBuf),
}

impl Default for BondingRule {
    fn default() -> Self {
        BondingRule::Plane(BondingPlane::default())
    }
}

/// Plane at which the pad is bonded.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BondingPlane {
    /// Normal of the plane, towards the finger; any nonzero length. None is the opposite of `outward`.
    #[serde(default)]
    pub normal: Option<Vec3>,
    /// Position of the plane along its normal, m. None places it through the node farthest along the normal.
    #[serde(default)]
    pub offset: Option<Finite>,
    /// Distance in front of the plane within which nodes are bonded, m. None bonds only the nodes on the plane and
    /// behind it.
    #[serde(default)]
    pub within: Option<Depth>,
}

/// Surface that the pad is bonded to, such as the core of a fingertip.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BondingMesh {
    /// Path of the surface mesh (`.obj`, `.stl`, `.ply`), in the axes and unit of the pad file; it may be open.
    pub path: PathBuf,
    /// Distance from the surface within which nodes are bonded, m; nodes inside a closed surface are bonded, too.
    pub within: Depth,
}
