//! Repair of a tetrahedral mesh for simulation: reports all changes and rejects faults without a unique remedy.

use crate::mesh::{MAX_COORDINATE, MAX_COUNT, TetMesh, format_point, is_out_of_range, quality, signed_volume, surface};
use base::error::{Error, Result};
use base::number::format_count;

/// Mean-ratio quality below which a tetrahedron is rejected as flat. (A sliver of this quality has a height of some
/// 1e-6 of its edge.)
pub const MIN_QUALITY: f64 = 1e-4;

/// Result of [`repair_mapped`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Repair {
    /// Notices, one sentence per kind of change.
    pub notices: Vec<String>,
    /// New index of each node of the mesh before the repair; None if the node was unused and removed.
    pub node_map: Vec<Option<u32>>,
}

/// Welds exactly equal nodes, removes unused ones, and reorients tetrahedra of negative volume; returns a notice for
/// each.
///
/// # Errors
/// Fails for an index out of range, a repeated node, a non-finite node, a flat tetrahedron (quality below
/// [`MIN_QUALITY`]), a face shared by three or more tetrahedra and an empty mesh. The error states the tetrahedron
/// (0-based), its position and its size.
pub fn repair(mesh: &mut TetMesh) -> Result<Vec<String>> {
    repair_mapped(mesh).map(|r| r.notices)
}

/// Repairs the mesh as [`repair`] does and also returns the new index of every node.
///
/// # Errors
/// Fails in the cases of [`repair`].
pub fn repair_mapped(mesh: &mut TetMesh) -> Result<Repair> {
    check_indices(mesh)?;
    let mut notices = Vec::new();
    let (node_map, welded, unused) = compact(mesh);
    if welded > 0 {
        notices.push(format!("welded {} (exactly equal coordinates)", format_count(welded, "duplicate node")));
    }
    if unused > 0 {
        notices.push(format!("removed {} that no tetrahedron uses", format_count(unused, "node")));
    }
    for (t, tet) in mesh.tets.iter().enumerate() {
        for i in 0..4 {
            if tet[..i].contains(&tet[i]) {
                let place = format_point(mesh.nodes[tet[i] as usize]);
                return Err(Error::Mesh(format!(
                    "tetrahedron {t} (0-based) uses node {} twice, at {place}; its four corners must be different points: \
                     remove it or mesh again",
                    tet[i]
                )));
            }
        }
    }
    let mut turned = 0;
    for t in 0..mesh.tets.len() {
        if signed_volume(mesh.corners(t)) < 0.0 {
            mesh.tets[t].swap(2, 3);
            turned += 1;
        }
    }
    if turned > 0 {
        notices.push(format!(
            "reoriented {turned} of {} that had negative volume",
            format_count(mesh.tets.len(), "tetrahedron")
        ));
    }
    refuse_flat(mesh)?;
    surface::check_manifold(mesh)?;
    Ok(Repair { notices, node_map })
}

/// Rejects an empty mesh, indices out of range and non-finite nodes.
///
/// # Errors
/// Returns [`Error::Mesh`] with the first fault.
pub fn check_indices(mesh: &TetMesh) -> Result<()> {
    let (n, m) = (mesh.nodes.len(), mesh.tets.len());
    if n == 0 || m == 0 {
        return Err(Error::Mesh(format!(
            "the mesh is empty: {} and {}",
            format_count(n, "node"),
            format_count(m, "tetrahedron")
        )));
    }
    if n.max(m) > MAX_COUNT {
        return Err(Error::Mesh(format!("{n} nodes and {m} tetrahedra; at most {MAX_COUNT} of each are allowed")));
    }
    if let Some((i, p)) = mesh.nodes.iter().enumerate().find(|(_, p)| is_out_of_range(**p)) {
        let message = format!("node {i} (0-based) is {p}; coordinates must be finite and within {MAX_COORDINATE:e}");
        return Err(Error::Mesh(message));
    }
    for (t, tet) in mesh.tets.iter().enumerate() {
        if let Some(i) = tet.iter().find(|i| **i as usize >= n) {
            return Err(Error::Mesh(format!("tetrahedron {t} (0-based) refers to node {i}; allowed: 0..={}", n - 1)));
        }
    }
    Ok(())
}

/// Welds equal nodes to the first of them and drops unused ones, keeping the order. Returns the map, the number of
/// welded and the number of dropped nodes.
fn compact(mesh: &mut TetMesh) -> (Vec<Option<u32>>, usize, usize) {
    let n = mesh.nodes.len();
    let representative = first_equal(&mesh.nodes);
    let mut used = vec![false; n];
    for i in mesh.tets.iter_mut().flatten() {
        *i = representative[*i as usize];
        used[*i as usize] = true;
    }
    let mut new_index = vec![None; n];
    let mut kept = Vec::new();
    for i in 0..n {
        if used[i] {
            new_index[i] = Some(kept.len() as u32);
            kept.push(mesh.nodes[i]);
        }
    }
    // A representative in use is always kept, so the default is never used.
    for i in mesh.tets.iter_mut().flatten() {
        *i = new_index[*i as usize].unwrap_or_default();
    }
    let map: Vec<Option<u32>> = representative.iter().map(|r| new_index[*r as usize]).collect();
    let welded = (0..n).filter(|i| representative[*i] as usize != *i && map[*i].is_some()).count();
    let unused = map.iter().filter(|m| m.is_none()).count();
    mesh.nodes = kept;
    (map, welded, unused)
}

/// Returns for each point the index of the first point with exactly the same coordinates (0.0 and -0.0 are the same).
pub(crate) fn first_equal(points: &[glam::DVec3]) -> Vec<u32> {
    let key = |i: u32| points[i as usize].to_array().map(|x| x + 0.0);
    let mut order: Vec<u32> = (0..points.len() as u32).collect();
    order.sort_by(|a, b| {
        let (p, q) = (key(*a), key(*b));
        p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])).then(p[2].total_cmp(&q[2])).then(a.cmp(b))
    });
    let mut first: Vec<u32> = (0..points.len() as u32).collect();
    for pair in order.windows(2) {
        if key(pair[0]) == key(pair[1]) {
            first[pair[1] as usize] = first[pair[0] as usize];
        }
    }
    first
}

fn refuse_flat(mesh: &TetMesh) -> Result<()> {
    for t in 0..mesh.tets.len() {
        let corners = mesh.corners(t);
        let ratio = quality::mean_ratio(corners);
        if ratio < MIN_QUALITY || ratio.is_nan() {
            let centre = corners.iter().sum::<glam::DVec3>() / 4.0;
            return Err(Error::Mesh(format!(
                "tetrahedron {t} (0-based), nodes {:?}, is flat: volume {:.3e} m^3, quality {ratio:.2e} (a regular one has \
                 1, at least {MIN_QUALITY:.0e} is needed), centroid {}; mesh again or remove it",
                mesh.tets[t],
                signed_volume(corners),
                format_point(centre)
            )));
        }
    }
    Ok(())
}
