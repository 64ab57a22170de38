//! Selection of the nodes of a pad that are bonded to the finger, by a rule.

use crate::mesh::{TetMesh, TriMesh};
use crate::shape::SurfaceDistance;
use base::error::{Error, Result};
use base::number::shown;
use glam::DVec3;
use std::sync::Arc;

/// Rule that selects the nodes that are bonded to the finger. Lengths and coordinates are in the frame and the unit of
/// the mesh.
#[derive(Debug, Clone, PartialEq)]
pub enum Bonding {
    /// Nodes on or behind a plane, or at most `within` in front of it.
    Plane {
        /// Unit normal of the plane, into the finger; None is the opposite of the outward direction.
        normal: Option<DVec3>,
        /// Position of the plane along its normal; None is that of the farthest node.
        offset: Option<f64>,
        /// Distance in front of the plane.
        within: f64,
    },
    /// Nodes at most `within` away from a surface, and all nodes inside it if it is closed.
    Surface {
        /// Surface of the body that carries the gel.
        surface: Arc<TriMesh>,
        /// Distance from the surface.
        within: f64,
    },
    /// Nodes with these indices, 0-based.
    Nodes(Vec<usize>),
}

impl Bonding {
    /// Returns the rule that bonds the nodes at most `within` (m) above the lowest node along the outward direction.
    pub const fn back(within: f64) -> Self {
        Bonding::Plane { normal: None, offset: None, within }
    }

    /// Returns a flag per node of a mesh whose sensing face points along the unit vector `outward`: true if the node is
    /// bonded.
    ///
    /// # Errors
    /// Fails for a negative distance, an index out of range, and if no node or every node is bonded.
    pub(super) fn choose(&self, mesh: &TetMesh, outward: DVec3) -> Result<Vec<bool>> {
        let bonded: Vec<bool> = match self {
            Bonding::Nodes(list) => listed(list, mesh.nodes.len())?,
            Bonding::Plane { within, .. } | Bonding::Surface { within, .. } => {
                if !(within.is_finite() && *within >= 0.0) {
                    let message =
                        format!("the attach distance is {} m; a length of 0 or more is needed", shown(*within));
                    return Err(Error::Mesh(message));
                }
                // Rounding must not exclude nodes on the plane or on the surface.
                let (beyond, size) = self.distances(mesh, outward);
                let reach = within + 1e-9 * size;
                let bonded: Vec<bool> = beyond.iter().map(|distance| *distance <= reach).collect();
                if !bonded.contains(&true) {
                    let nearest = beyond.iter().copied().fold(f64::INFINITY, f64::min);
                    let what = if matches!(self, Bonding::Plane { .. }) { "plane" } else { "surface" };
                    return Err(Error::Mesh(format!(
                        "no node of the pad is bonded to the finger: the nearest of its {} nodes is {} m from the \
                         {what}, and nodes within {} m are bonded",
                        mesh.nodes.len(),
                        shown(nearest),
                        shown(*within)
                    )));
                }
                bonded
            }
        };
        match bonded.iter().filter(|b| **b).count() {
            0 => Err(Error::Mesh(
                "no node of the pad is bonded to the finger; give a distance within which nodes are bonded, or a list \
                 of nodes"
                    .into(),
            )),
            n if n == bonded.len() => Err(Error::Mesh(format!(
                "all {n} nodes of the pad are bonded to the finger, so that it cannot deform; reduce the distance or \
                 the list"
            ))),
            _ => Ok(bonded),
        }
    }

    /// Returns the distance of each node in front of the plane or outside the surface, and the length that scales the
    /// tolerance for rounding; no distances for a list.
    fn distances(&self, mesh: &TetMesh, outward: DVec3) -> (Vec<f64>, f64) {
        match self {
            Bonding::Plane { normal, offset, .. } => {
                let normal = normal.unwrap_or(-outward);
                let along = || mesh.nodes.iter().map(|p| normal.dot(*p));
                let (low, high) = along().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
                let offset = offset.unwrap_or(high);
                (along().map(|v| offset - v).collect(), high - low)
            }
            Bonding::Surface { surface, .. } => {
                let distance = SurfaceDistance::new(surface);
                (mesh.nodes.iter().map(|p| distance.outside(*p)).collect(), distance.size())
            }
            Bonding::Nodes(_) => (Vec::new(), 0.0),
        }
    }
}

/// Returns a flag per node, true for those of the list.
fn listed(list: &[usize], count: usize) -> Result<Vec<bool>> {
    let mut bonded = vec![false; count];
    for i in list {
        let Some(flag) = bonded.get_mut(*i) else {
            let message = format!("bonded node index {i} is outside the mesh; allowed: 0..={}", count - 1);
            return Err(Error::Mesh(message));
        };
        *flag = true;
    }
    Ok(bonded)
}
