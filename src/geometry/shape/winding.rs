//! Generalized winding number of a triangle surface (Jacobson et al. 2013), evaluated by a tree (Barill et al. 2018,
//! "Fast winding numbers for soups and clouds").

use crate::mesh::TriMesh;
use crate::mesh::shells::solid_angle;
use crate::shape::bvh::Bvh;
use crate::shape::facet::Facet;
use glam::DVec3;
use std::f64::consts::PI;

/// Distance from a part of the surface, in radii of that part, beyond which the part is approximated by one dipole: the
/// error is then below some hundredths.
const FAR: f64 = 3.0;

/// Far-field description of a part of the surface.
#[derive(Debug, Clone, Copy)]
struct Dipole {
    center: DVec3,
    /// Sum of area times normal, m2.
    area: DVec3,
    /// Upper bound of the distance of its points from the centre, m.
    radius: f64,
}

/// Winding number of a surface, closed or not, about a point: 1 inside and 0 outside a solid, between 0 and 1 near a
/// hole, 2 where the surface overlaps itself.
#[derive(Debug)]
pub(crate) struct Winding {
    pub bvh: Bvh,
    dipoles: Vec<Dipole>,
}

impl Winding {
    /// Builds the tree of the triangles of `mesh` that have an area; there must be one. Indices must be valid.
    pub fn new(mesh: &TriMesh) -> Self {
        let facets = (0..mesh.triangles.len()).filter_map(|t| Facet::new(mesh.corners(t), t as u32)).collect();
        let bvh = Bvh::new(facets);
        let nothing = Dipole { center: DVec3::ZERO, area: DVec3::ZERO, radius: 0.0 };
        let mut dipoles = vec![nothing; bvh.nodes.len()];
        // Area, m2; area times centroid, m3; area times normal, m2.
        let mut sums = vec![(0.0, DVec3::ZERO, DVec3::ZERO); bvh.nodes.len()];
        // Children have larger indices than their parents.
        for (i, node) in bvh.nodes.iter().enumerate().rev() {
            sums[i] = if node.count == 0 {
                let [a, b] = [0, 1].map(|k| sums[node.first as usize + k]);
                (a.0 + b.0, a.1 + b.1, a.2 + b.2)
            } else {
                bvh.facets[node.first as usize..][..node.count as usize].iter().fold(
                    (0.0, DVec3::ZERO, DVec3::ZERO),
                    |s, f| {
                        let (area, [a, b, c]) = (f.area(), f.corners());
                        (s.0 + area, s.1 + area / 3.0 * (a + b + c), s.2 + area * f.n)
                    },
                )
            };
            let center = sums[i].1 / sums[i].0;
            let radius = (node.bounds.max - center).max(center - node.bounds.min).length();
            dipoles[i] = Dipole { center, area: sums[i].2, radius };
        }
        Self { bvh, dipoles }
    }

    /// Returns the winding number at `q`; on the surface itself, values between those of its two sides.
    pub fn at(&self, q: DVec3) -> f64 {
        let mut stack = vec![0_u32];
        let mut angle = 0.0;
        while let Some(i) = stack.pop() {
            let (node, dipole) = (&self.bvh.nodes[i as usize], &self.dipoles[i as usize]);
            let away = dipole.center - q;
            let square = away.length_squared();
            if square > (FAR * dipole.radius).powi(2) {
                angle += dipole.area.dot(away) / (square * square.sqrt());
            } else if node.count == 0 {
                stack.extend([node.first + 1, node.first]);
            } else {
                let facets = &self.bvh.facets[node.first as usize..][..node.count as usize];
                angle += facets.iter().map(|f| solid_angle(f.corners(), q)).sum::<f64>();
            }
        }
        angle / (4.0 * PI)
    }
}
