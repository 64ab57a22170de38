//! Collector for both forms of a gmsh file: nodes by tag, tetrahedra by the tags of their nodes.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use glam::DVec3;

use super::groups::Groups;
use crate::mesh::{MAX_COUNT, TetMesh};
use base::error::{Error, Result};

/// Element type of the 4-node tetrahedron in gmsh.
const LINEAR: u64 = 4;
/// Element type of the 10-node tetrahedron in gmsh.
const QUADRATIC: u64 = 11;
/// Edges of the 10-node tetrahedron in the order of their mid-edge nodes in gmsh.
const MID_EDGE_NODES: [(usize, usize); 6] = [(0, 1), (1, 2), (0, 2), (0, 3), (2, 3), (1, 3)];
/// Distance of the mid-edge node from the midpoint, over the edge length, up to which an edge counts as straight: the
/// rounding of files with few digits stays below.
const STRAIGHT: f64 = 1e-3;
/// Distance, over the edge length, above which a node is not the mid-edge node: the file has another node order.
const MISPLACED: f64 = 0.25;

/// Rejected element: index of the node (0-based) and reason.
pub(crate) type ElementError = (usize, String);

/// Content collected while reading.
#[derive(Default)]
pub(crate) struct MeshBuilder {
    mesh: TetMesh,
    /// Index by node tag; only queried, never iterated.
    index_of: HashMap<u64, u32>,
    /// Number of omitted elements, by element type.
    skipped: BTreeMap<u64, usize>,
    /// Number of tetrahedra of second order.
    quadratic: usize,
    /// Groups of the tetrahedra.
    pub groups: Groups,
    /// Largest distance of a mid-edge node from the midpoint of its edge, m, and over the edge length.
    bulge: (f64, f64),
}

/// Returns the number of nodes of a supported tetrahedron; None for other element types.
pub(crate) fn tetrahedron_nodes(kind: u64) -> Option<usize> {
    match kind {
        LINEAR => Some(4),
        QUADRATIC => Some(10),
        _ => None,
    }
}

impl MeshBuilder {
    /// Returns the number of nodes so far.
    pub fn nodes(&self) -> usize {
        self.mesh.nodes.len()
    }

    /// Adds a node; its position is the origin until [`Self::set_position`] sets it.
    ///
    /// # Errors
    /// Fails if there are too many nodes or the tag is used twice.
    pub fn add_node(&mut self, tag: u64) -> std::result::Result<(), String> {
        if self.nodes() >= MAX_COUNT {
            return Err(format!("more than the {MAX_COUNT} nodes allowed"));
        }
        if self.index_of.insert(tag, self.nodes() as u32).is_some() {
            return Err(format!("node tag {tag} is used twice; tags must be unique"));
        }
        self.mesh.nodes.push(DVec3::ZERO);
        Ok(())
    }

    /// Sets the position of a node by its index, m.
    pub fn set_position(&mut self, index: usize, position: DVec3) {
        self.mesh.nodes[index] = position;
    }

    /// Counts an omitted element.
    pub fn count_omitted(&mut self, kind: u64) {
        *self.skipped.entry(kind).or_default() += 1;
    }

    /// Stores the corners of a tetrahedron of [`tetrahedron_nodes`]; its mid-edge nodes are only checked. `volume` is
    /// the tag of its volume, in version 2 that of its group.
    ///
    /// # Errors
    /// Fails if there are too many tetrahedra, a tag is unknown or a mid-edge node is far from the midpoint of its
    /// edge.
    pub fn add_tetrahedron(&mut self, volume: u64, tags: &[u64]) -> std::result::Result<(), ElementError> {
        let element = self.mesh.tets.len();
        if element >= MAX_COUNT {
            return Err((0, format!("more than the {MAX_COUNT} tetrahedra allowed")));
        }
        let mut indices = [0; 10];
        for (k, tag) in tags.iter().enumerate() {
            indices[k] = *self.index_of.get(tag).ok_or_else(|| {
                let n = self.nodes();
                (k, format!("tetrahedron {element} refers to node tag {tag}, which is not among the {n} nodes"))
            })?;
        }
        let [a, b, c, d, middles @ ..] = indices;
        if tags.len() > 4 {
            self.quadratic += 1;
            for (k, (middle, (i, j))) in middles.iter().zip(MID_EDGE_NODES).enumerate() {
                let [p, q, m] = [indices[i], indices[j], *middle].map(|n| self.mesh.nodes[n as usize]);
                let (off, length) = ((m - 0.5 * (p + q)).length(), (q - p).length());
                if off > MISPLACED * length {
                    let message = format!(
                        "tetrahedron {element}: node tag {} lies {off:.3e} m from the midpoint of its edge of \
                         {length:.3e} m; the nodes are not in the order of gmsh, or the edge is too curved: use a mesh \
                         of first order",
                        tags[k + 4]
                    );
                    return Err((k + 4, message));
                }
                let part = if length > 0.0 { off / length } else { 0.0 };
                self.bulge = (self.bulge.0.max(off), self.bulge.1.max(part));
            }
        }
        self.mesh.tets.push([a, b, c, d]);
        self.groups.tetrahedron(volume);
        Ok(())
    }

    /// Returns the mesh of the tetrahedra of a group, or of all if `group` is None, and the notices about it.
    ///
    /// # Errors
    /// Fails if there is no tetrahedron.
    pub fn finish(mut self, path: &Path, group: Option<&str>) -> Result<(TetMesh, Vec<String>)> {
        let list: Vec<String> = self.skipped.iter().map(|(kind, n)| format!("{n} of type {kind}")).collect();
        if self.mesh.tets.is_empty() {
            let found = if list.is_empty() { "no elements".into() } else { list.join(", ") };
            return Err(Error::file(
                path,
                format!(
                    "the mesh is empty: no tetrahedra of 4 or 10 nodes (types 4, 11), found {found}; mesh the volume \
                     (gmsh -3) to first or second order"
                ),
            ));
        }
        let mut notices = Vec::new();
        if self.quadratic > 0 {
            let (off, part) = self.bulge;
            let edges = if part <= STRAIGHT {
                "their mid-edge nodes are at the midpoints of straight edges".to_string()
            } else {
                format!(
                    "their mid-edge nodes are up to {off:.2e} m ({:.2} % of the edge) from the midpoints, but edges \
                     are treated as straight",
                    100.0 * part
                )
            };
            notices.push(format!(
                "{}: only the 4 corners of {} tetrahedra of 10 nodes are read; {edges}; quadratic elements get new \
                 mid-edge nodes",
                path.display(),
                self.quadratic
            ));
        }
        if !list.is_empty() {
            let list = list.join(", ");
            notices.push(format!("{}: ignored elements {list}; only types 4 and 11 are used", path.display()));
        }
        let several = self.groups.select(path, &mut self.mesh.tets, group)?;
        notices.extend(several.map(|text| format!("{}: {text}", path.display())));
        Ok((self.mesh, notices))
    }
}
