//! Rules for the nodes of a pad from a file that are bonded to the finger.

use super::leaf::{Depth, Finite};
use super::vector::Vec3;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Rule for the nodes that are bonded to the finger. Directions and positions are in the axes of the pad's file, lengths in metres.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum BondingRule {
    /// Nodes on or behind a plane, or close in front of it.
    Plane(BondingPlane),
    /// Nodes close to the surface of what carries the gel, or inside it.
    NearMesh(BondingMesh),
    /// Nodes with these numbers, in the order of the file, from 0 on.
    Nodes(Vec<usize>),
    /// Nodes that a text file names: their numbers, from 0 on, or one 0 or 1 for each node of the mesh.
    NodesFile(PathBuf),
}

impl Default for BondingRule {
    fn default() -> Self {
        BondingRule::Plane(BondingPlane::default())
    }
}

/// Plane that the pad is bonded at.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BondingPlane {
    /// Normal of the plane, into the finger; any length except zero. None is the opposite of `outward`.
    #[serde(default)]
    pub normal: Option<Vec3>,
    /// Position of the plane along its normal, m. None puts it through the farthest node.
    #[serde(default)]
    pub offset: Option<Finite>,
    /// Distance in front of the plane within which nodes are bonded, m. None bonds the nodes on the plane and behind it only.
    #[serde(default)]
    pub within: Option<Depth>,
}

/// Surface that the pad is bonded to, such as the core of a fingertip.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BondingMesh {
    /// Path of the surface (`.obj`, `.stl`, `.ply`), in axes and unit of the pad's file; it may be open.
    pub path: PathBuf,
    /// Distance from the surface within which nodes are bonded, m; those inside are bonded, too.
    pub within: Depth,
}
