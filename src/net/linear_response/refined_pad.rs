//! Pad with every tetrahedron divided into eight: at the nodes of the original mesh, which are its first nodes, its
//! small displacements are close to those of the continuum.

use geometry::mesh::{TetMesh, quadratic};
use glam::DVec3;
use mech::body::{Body, Elements};
use model::part::FingerModel;
use record::ElementNodes;
use std::collections::BTreeMap;

/// Refined pad of a finger.
pub struct RefinedPad {
    /// Mesh and law, hand frame.
    pub body: Body,
    /// Edges that have a midpoint node, sorted.
    edges: Vec<[u32; 2]>,
    corners: usize,
}

impl RefinedPad {
    /// Refines the pad of `finger`; None for 4-node tetrahedra, whose response includes their locking.
    pub fn of(finger: &FingerModel) -> Option<Self> {
        let ElementNodes::Quadratic(tets) = &finger.topology.elements else { return None };
        let body = &finger.body;
        let tets: Vec<[u32; 4]> = tets.iter().flat_map(|t| divided(t, &body.rest)).collect();
        let mesh = TetMesh { nodes: body.rest.clone(), tets };
        let (fine, edges) = (quadratic::to_quadratic(&mesh), quadratic::midpoint_edges(&mesh));
        let mut fixed = body.fixed.clone();
        // The midpoint of an edge is bonded if both its ends are.
        fixed.extend(edges.iter().map(|[a, b]| body.fixed[*a as usize] && body.fixed[*b as usize]));
        let elements = Elements::Quadratic(fine.tets);
        let fine = Body::new(fine.nodes, elements, fixed, body.material.clone(), body.mean_dilatation);
        Some(Self { body: fine, edges, corners: body.rest.len() })
    }

    /// Returns the nodal forces of a unit force around each of the nodes `face` of the pad of `finger`: the traction is
    /// a hat function, which falls linearly to zero at the neighbours.
    pub fn hat_forces(&self, finger: &FingerModel, face: &[u32]) -> Vec<Vec<(u32, f64)>> {
        let own: BTreeMap<u32, usize> = face.iter().enumerate().map(|(i, n)| (*n, i)).collect();
        let (mut whole, mut parts) = (vec![0.0; face.len()], vec![BTreeMap::new(); face.len()]);
        for t in &finger.topology.sensing {
            let [p, q, r] = t.map(|n| finger.topology.rest[n as usize]);
            let area = 0.5 * (q - p).cross(r - p).length();
            for k in 0..3 {
                let (a, b, c) = (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
                let i = own[&a];
                whole[i] += area / 3.0;
                // Integrals of the shape functions of a 6-node triangle times the barycentric coordinate of `a`.
                for (node, part) in [
                    (a, 1.0 / 30.0),
                    (b, -1.0 / 60.0),
                    (c, -1.0 / 60.0),
                    (self.middle(a, b), 2.0 / 15.0),
                    (self.middle(a, c), 2.0 / 15.0),
                    (self.middle(b, c), 1.0 / 15.0),
                ] {
                    *parts[i].entry(node).or_insert(0.0) += area * part;
                }
            }
        }
        let unit =
            |(parts, whole): (BTreeMap<u32, f64>, f64)| parts.into_iter().map(|(n, part)| (n, part / whole)).collect();
        parts.into_iter().zip(whole).map(unit).collect()
    }

    fn middle(&self, a: u32, b: u32) -> u32 {
        let edge = [a.min(b), a.max(b)];
        (self.corners + self.edges.partition_point(|e| *e < edge)) as u32
    }
}

/// Relative weight of the direction of a diagonal, which decides between diagonals of equal length.
const TIE: f64 = 1e-6;

/// Divides a 10-node tetrahedron into eight 4-node ones: one at each corner, and four that divide the octahedron
/// between them along its shortest diagonal.
fn divided(t: &[u32; 10], rest: &[DVec3]) -> [[u32; 4]; 8] {
    let [a, b, c, d, ab, bc, ca, ad, bd, cd] = *t;
    // Ties are broken independently of the order of the nodes.
    let length = |p: u32, q: u32| {
        let along = rest[q as usize] - rest[p as usize];
        along.length_squared() * (1.0 + TIE * along.normalize_or_zero().abs().dot(DVec3::new(1.0, 2.0, 3.0)))
    };
    let around = |p: u32, q: u32, ring: [u32; 4]| [0, 1, 2, 3].map(|k| [p, q, ring[k], ring[(k + 1) % 4]]);
    // Each diagonal joins the midpoints of two opposite edges; the other four midpoints form a ring around it.
    let diagonals = [(ab, cd, [bc, bd, ad, ca]), (bc, ad, [ab, bd, cd, ca]), (ca, bd, [ab, bc, cd, ad])];
    let (p, q, ring) =
        diagonals.into_iter().min_by(|x, y| length(x.0, x.1).total_cmp(&length(y.0, y.1))).unwrap_or(diagonals[0]);
    let [e, f, g, h] = around(p, q, ring);
    [[a, ab, ca, ad], [b, bc, ab, bd], [c, ca, bc, cd], [d, ad, cd, bd], e, f, g, h].map(|mut tet| {
        let [w, x, y, z] = tet.map(|n| rest[n as usize]);
        if (x - w).cross(y - w).dot(z - w) < 0.0 {
            tet.swap(2, 3);
        }
        tet
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::mesh::quadratic::to_quadratic;

    #[test]
    fn the_parts_of_a_tetrahedron_fill_it() {
        let nodes = vec![DVec3::ZERO, DVec3::X, DVec3::new(0.2, 1.1, 0.0), DVec3::new(0.3, 0.2, 0.9)];
        let whole = to_quadratic(&TetMesh { nodes, tets: vec![[0, 1, 2, 3]] });
        let volume = |t: &[u32]| {
            let [w, x, y, z] = [0, 1, 2, 3].map(|k| whole.nodes[t[k] as usize]);
            (x - w).cross(y - w).dot(z - w) / 6.0
        };
        let parts = divided(&whole.tets[0], &whole.nodes);
        let (all, one) = (parts.iter().map(|t| volume(t)).sum::<f64>(), volume(&whole.tets[0]));
        assert!((all - one).abs() < 1e-12 * one, "{all} of {one}");
        assert!(parts.iter().all(|t| (volume(t) - one / 8.0).abs() < 1e-12), "equal parts");
    }
}
