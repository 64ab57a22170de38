//! Closed parts of a surface and their orientation.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use glam::DVec3;

use crate::Aabb;
use crate::mesh::disjoint_sets::DisjointSets;
use crate::mesh::topology::half_edges;
use crate::mesh::{TriMesh, format_point};
use base::number::format_count;

/// Part of a surface whose triangles are connected across edges.
#[derive(Debug, Clone, PartialEq)]
pub struct Shell {
    /// Indices of its triangles, ascending.
    pub triangles: Vec<u32>,
    /// Signed volume, m3; positive if it is wound outward.
    pub volume: f64,
    /// Bounding box, m.
    pub bounds: Aabb,
}

/// Returns the shells of `mesh`, in the order of their first triangles. Indices must be valid.
pub fn shells(mesh: &TriMesh) -> Vec<Shell> {
    let mut joined = DisjointSets::new(mesh.triangles.len());
    for pair in half_edges(mesh).windows(2).filter(|p| p[0].ends == p[1].ends) {
        joined.union([pair[0].triangle, pair[1].triangle]);
    }
    let mut shell_of = BTreeMap::new();
    let mut shells: Vec<Shell> = Vec::new();
    for t in 0..mesh.triangles.len() as u32 {
        let at = *shell_of.entry(joined.find(t)).or_insert(shells.len());
        if at == shells.len() {
            shells.push(Shell { triangles: Vec::new(), volume: 0.0, bounds: Aabb::EMPTY });
        }
        shells[at].triangles.push(t);
    }
    for shell in &mut shells {
        let origin = mesh.corners(shell.triangles[0] as usize)[0];
        for t in &shell.triangles {
            let corners = mesh.corners(*t as usize);
            let [a, b, c] = corners.map(|p| p - origin);
            shell.volume += a.cross(b).dot(c) / 6.0;
            corners.into_iter().for_each(|p| shell.bounds.include(p));
        }
    }
    shells
}

/// Flips triangles so that all triangles of a shell are oriented consistently, as the majority of them, where that is
/// possible. Returns the number of flipped triangles. Indices must be valid.
pub fn orient_consistently(mesh: &mut TriMesh) -> usize {
    let sides = half_edges(mesh);
    let mut across = vec![[None; 3]; mesh.triangles.len()];
    for group in sides.chunk_by(|x, y| x.ends == y.ends) {
        if let [one, two] = group {
            let agree = one.reversed != two.reversed;
            across[one.triangle as usize][usize::from(one.corner)] = Some((two.triangle, agree));
            across[two.triangle as usize][usize::from(two.corner)] = Some((one.triangle, agree));
        }
    }
    let mut turned: Vec<Option<bool>> = vec![None; mesh.triangles.len()];
    let mut count = 0;
    for first in 0..mesh.triangles.len() {
        if turned[first].is_some() {
            continue;
        }
        turned[first] = Some(false);
        let (mut part, mut next) = (vec![first], 0);
        while let Some(t) = part.get(next).copied() {
            next += 1;
            for (other, agree) in across[t].into_iter().flatten() {
                let other = other as usize;
                if turned[other].is_none() {
                    turned[other] = turned[t].map(|t| t == agree);
                    part.push(other);
                }
            }
        }
        // Of the two orientations, that of the majority: only a few triangles of a scan are inverted.
        let odd = part.iter().filter(|t| turned[**t] == Some(true)).count();
        let most = 2 * odd > part.len();
        count += if most { part.len() - odd } else { odd };
        part.into_iter().filter(|t| turned[*t] == Some(!most)).for_each(|t| mesh.triangles[t].swap(1, 2));
    }
    count
}

/// Result of [`orient`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Oriented {
    /// Number of outer shells that were oriented inward.
    pub outward: usize,
    /// Number of shells inside an odd number of others, which bound a cavity, that were oriented outward.
    pub inward: usize,
}

impl Oriented {
    /// Returns true if any shell was flipped.
    pub fn any(&self) -> bool {
        self.outward + self.inward > 0
    }
}

/// Orients each shell of a closed, consistently wound mesh: outward, or inward if it lies inside an odd number of
/// others, because it then bounds a cavity. Shells must not intersect each other, and indices must be valid.
pub fn orient(mesh: &mut TriMesh) -> Oriented {
    let shells = shells(mesh);
    let mut done = Oriented::default();
    for shell in &shells {
        let around = shells.iter().filter(|other| holds(mesh, other, shell)).count();
        let hollow = around % 2 == 1;
        if (shell.volume < 0.0) == hollow || shell.volume == 0.0 {
            continue;
        }
        *(if hollow { &mut done.inward } else { &mut done.outward }) += 1;
        shell.triangles.iter().for_each(|t| mesh.triangles[*t as usize].swap(1, 2));
    }
    done
}

/// Returns true if `outer` encloses `inner`, for either orientation.
fn holds(mesh: &TriMesh, outer: &Shell, inner: &Shell) -> bool {
    let (o, i) = (&outer.bounds, &inner.bounds);
    if !(o.min.cmple(i.min).all() && i.max.cmple(o.max).all()) || outer.triangles == inner.triangles {
        return false;
    }
    // Where the two touch, the winding number is ambiguous; the first point with an unambiguous one decides.
    let turns =
        |p: DVec3| outer.triangles.iter().map(|t| solid_angle(mesh.corners(*t as usize), p)).sum::<f64>() / (4.0 * PI);
    let points = inner.triangles.iter().take(64).map(|t| mesh.corners(*t as usize).into_iter().sum::<DVec3>() / 3.0);
    let sure = points.map(|p| turns(p).abs()).find(|w| (w - w.round()).abs() < 0.25);
    sure.is_some_and(|w| w.round() as u64 % 2 == 1)
}

/// Computes the signed solid angle of the triangle seen from `p`, sr (Van Oosterom and Strackee 1983, eq. 8); positive
/// if `p` is behind the triangle.
pub(crate) fn solid_angle(corners: [DVec3; 3], p: DVec3) -> f64 {
    let [a, b, c] = corners.map(|q| q - p);
    let [x, y, z] = [a, b, c].map(DVec3::length);
    let below = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
    2.0 * a.dot(b.cross(c)).atan2(below)
}

/// Returns the reason to reject the mesh, in one sentence, if a shell has no volume.
pub(crate) fn flat_shell(mesh: &TriMesh) -> Option<String> {
    let shells = shells(mesh);
    let flat = shells.iter().find(|s| s.volume.abs() <= 1e-12 * s.bounds.size().max_element().powi(3))?;
    let what = if shells.len() == 1 {
        "it".into()
    } else {
        format!("a part of {}", format_count(flat.triangles.len(), "triangle"))
    };
    Some(format!(
        "the object's mesh: {what} is closed but encloses no volume, about {}; give it a thickness or remove it",
        format_point(flat.bounds.center())
    ))
}
