//! Check that a pad from a file does not overlap itself, and that no part of it has a free rigid-body motion.

use glam::DVec3;

use crate::Aabb;
use crate::mesh::shells::orient;
use crate::mesh::{TetMesh, format_point, surface};
use crate::shape::overlap::find_overlaps;
use base::error::{Error, Result};
use base::number::format_count;

/// Root-mean-square distance of the held nodes of a part from their best-fit line, over the size of the part, below
/// which the part can rotate about that line.
const COLLINEAR_RATIO: f64 = 1e-3;

/// Rejects a mesh that overlaps itself, or has a part with a free rigid-body motion. Indices must be valid, volumes
/// positive and no face shared by more than two tetrahedra; `bonded` is a flag per node.
///
/// # Errors
/// Returns [`Error::Mesh`] with the first such part and its position.
pub(super) fn check(mesh: &TetMesh, bonded: &[bool]) -> Result<()> {
    check_constrained(mesh, bonded)?;
    let (mut boundary, _) = surface::boundary_mesh(mesh);
    if let Some(fault) = find_overlaps(&boundary).error_message(&boundary) {
        return Err(Error::Mesh(format!("the pad overlaps itself: {fault}, or remove duplicates from the file")));
    }
    // Every shell bounds gel from outside or a cavity from inside; one with the wrong orientation lies inside other
    // gel.
    if orient(&mut boundary).any() {
        return Err(Error::Mesh(
            "the pad overlaps itself: a part of it lies inside another; remove duplicates from the file".into(),
        ));
    }
    Ok(())
}

/// Part of a pad that is connected across faces, and statistics of its held nodes.
struct Part {
    /// Number of tetrahedra.
    tets: usize,
    bounds: Aabb,
    /// Number of held nodes, the sum of their positions relative to the centre of the bounds, and the sums of the
    /// products of these coordinates.
    count: usize,
    sum: DVec3,
    squares: DVec3,
    products: DVec3,
}

impl Part {
    /// Adds a held node.
    fn add_fixed_node(&mut self, node: DVec3) {
        let p = node - self.bounds.center();
        self.count += 1;
        self.sum += p;
        self.squares += p * p;
        self.products += DVec3::new(p.y * p.z, p.z * p.x, p.x * p.y);
    }

    /// Returns true if the held nodes are not on a line. Their covariance has the eigenvalues `a >= b >= c`; the ratio
    /// of its second to its first invariant lies between `(b + c) / 2` and `b + c`, the mean square of the distance
    /// from the best-fit line.
    fn is_constrained(&self) -> bool {
        let n = (self.count as f64).max(1.0);
        let mean = self.sum / n;
        let (s, p) = (
            self.squares / n - mean * mean,
            self.products / n - DVec3::new(mean.y * mean.z, mean.z * mean.x, mean.x * mean.y),
        );
        let trace = s.element_sum();
        let second = s.x * s.y + s.y * s.z + s.z * s.x - p.length_squared();
        self.count > 2 && second > (COLLINEAR_RATIO * self.bounds.size().max_element()).powi(2) * trace
    }
}

/// Rejects a part that can move as a rigid body. A part is held if those of its nodes that are bonded, or belong to a
/// part that is held, do not lie on a line.
fn check_constrained(mesh: &TetMesh, bonded: &[bool]) -> Result<()> {
    let (part_of, count) = surface::connected_components(mesh);
    let empty = || Part {
        tets: 0,
        bounds: Aabb::EMPTY,
        count: 0,
        sum: DVec3::ZERO,
        squares: DVec3::ZERO,
        products: DVec3::ZERO,
    };
    let mut parts: Vec<Part> = (0..count).map(|_| empty()).collect();
    let mut parts_at = vec![Vec::new(); mesh.nodes.len()];
    for (tet, part) in mesh.tets.iter().zip(&part_of) {
        parts[*part as usize].tets += 1;
        for node in tet {
            parts[*part as usize].bounds.include(mesh.nodes[*node as usize]);
            parts_at[*node as usize].push(*part);
        }
    }
    let mut nodes_of = vec![Vec::new(); count];
    for (node, at) in parts_at.iter_mut().enumerate() {
        at.sort_unstable();
        at.dedup();
        for part in at {
            nodes_of[*part as usize].push(node as u32);
            if bonded[node] {
                parts[*part as usize].add_fixed_node(mesh.nodes[node]);
            }
        }
    }
    let mut fixed = bonded.to_vec();
    let mut open: Vec<usize> = (0..count).filter(|part| parts[*part].is_constrained()).collect();
    while let Some(part) = open.pop() {
        for node in std::mem::take(&mut nodes_of[part]) {
            if !std::mem::replace(&mut fixed[node as usize], true) {
                for other in &parts_at[node as usize] {
                    let other = *other as usize;
                    let before = parts[other].is_constrained();
                    parts[other].add_fixed_node(mesh.nodes[node as usize]);
                    if !before && parts[other].is_constrained() {
                        open.push(other);
                    }
                }
            }
        }
    }
    let Some(loose) = parts.iter().find(|part| !part.is_constrained()) else { return Ok(()) };
    let place = format_point(loose.bounds.center());
    let tets = format_count(loose.tets, "tetrahedron");
    let what = if count == 1 {
        format!("the pad of {tets} about {place}")
    } else {
        format!("a part of {tets} of {} about {place}", mesh.tets.len())
    };
    let (how, cure) = match loose.count {
        0 => ("is not connected to the finger: it could move freely", "remove it, or join or bond it"),
        1 => (
            "is held at one node and can rotate about it",
            "bond at least three nodes off a line, such as all of its back",
        ),
        _ => ("is held along a line and can rotate about it", "bond nodes off that line, such as all of its back"),
    };
    Err(Error::Mesh(format!("{what} {how}; {cure}")))
}
