//! Selection of the nodes of a pad that are bonded to the finger, by a rule.

use crate::mesh::{TetMesh, TriMesh};
use crate::shape::SurfaceDistance;
use base::error::{Error, Result};
use base::number::format_number;
use glam::DVec3;
use std::sync::Arc;

/// Rule that selects the pad nodes that are bonded to the finger, i.e. whose displacement relative to the finger is
/// zero. Lengths and coordinates are in the frame and the unit of the pad mesh: m, except for a mesh that is read with
/// a scale.
#[derive(Debug, Clone, PartialEq)]
pub enum Bonding {
    /// Nodes whose signed distance in front of a plane is at most `within`. The front is the side opposite to `normal`,
    /// i.e. that of the sensing face; nodes on and behind the plane are included.
    Plane {
        /// Unit normal of the plane, pointing into the finger; None selects the opposite of the outward direction of
        /// the sensing face.
        normal: Option<DVec3>,
        /// Offset of the plane: its points x satisfy `normal . x = offset`. None places the plane at the node that is
        /// farthest along the normal.
        offset: Option<f64>,
        /// Largest distance of a bonded node in front of the plane, 0 or more.
        within: f64,
    },
    /// Nodes at most `within` away from a triangle surface, and all nodes inside it if it is closed.
    Surface {
        /// Surface of the rigid body on which the gel is mounted, in the frame and the unit of the pad mesh.
        surface: Arc<TriMesh>,
        /// Largest distance of a bonded node from the surface, 0 or more.
        within: f64,
    },
    /// Nodes of the pad mesh with these indices, 0-based.
    Nodes(Vec<usize>),
}

impl Bonding {
    /// Returns the rule for a pad with a flat back: it bonds the nodes that are at most `within` (unit of the mesh)
    /// from the back plane, which is normal to the outward direction of the sensing face and passes through the node
    /// farthest behind it.
    pub const fn back(within: f64) -> Self {
        Bonding::Plane { normal: None, offset: None, within }
    }

    /// Returns a flag per node of `mesh`: true if the node is bonded. `outward` is the outward unit normal of the
    /// sensing face, in the frame of the mesh.
    ///
    /// # Errors
    /// Fails with [`Error::Mesh`] for a distance that is negative or not finite, an index out of range, and if no node
    /// or every node is bonded.
    pub(super) fn bonded_nodes(&self, mesh: &TetMesh, outward: DVec3) -> Result<Vec<bool>> {
        let bonded: Vec<bool> = match self {
            Bonding::Nodes(list) => flags_of_list(list, mesh.nodes.len())?,
            Bonding::Plane { within, .. } | Bonding::Surface { within, .. } => {
                if !(within.is_finite() && *within >= 0.0) {
                    let message =
                        format!("the attach distance is {} m; a length of 0 or more is needed", format_number(*within));
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
                        format_number(nearest),
                        format_number(*within)
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
                (mesh.nodes.iter().map(|p| distance.distance(*p)).collect(), distance.size())
            }
            Bonding::Nodes(_) => (Vec::new(), 0.0),
        }
    }
}

/// Returns a flag per node, true for those of the list.
fn flags_of_list(list: &[usize], count: usize) -> Result<Vec<bool>> {
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
