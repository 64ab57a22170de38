//! Plane sections: clipping of triangles, and the intersection of a plane with tetrahedra.

use super::raster::Vertex;
use super::style::NodalValues;
use crate::ElementNodes;
use glam::DVec3;
use mech::element::{EDGES, tet10_values};

/// Clipping plane that keeps the points `x` with `normal . x >= offset`.
#[derive(Debug, Clone, Copy)]
pub struct CutPlane {
    /// Unit normal, pointing into the part that is kept.
    pub normal: DVec3,
    /// Distance from the origin along the normal, m.
    pub offset: f64,
}

impl CutPlane {
    fn distance(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }

    /// Clips a triangle; returns the remaining part as zero, one or two triangles.
    pub fn clip(&self, triangle: [Vertex; 3]) -> Vec<[Vertex; 3]> {
        let distances = triangle.map(|v| self.distance(v.position));
        let mut polygon = Vec::with_capacity(4);
        for i in 0..3 {
            let j = (i + 1) % 3;
            if distances[i] >= 0.0 {
                polygon.push(triangle[i]);
            }
            if (distances[i] >= 0.0) != (distances[j] >= 0.0) {
                polygon.push(between(triangle[i], triangle[j], distances[i], distances[j]));
            }
        }
        (2..polygon.len()).map(|i| [polygon[0], polygon[i - 1], polygon[i]]).collect()
    }

    /// Returns the intersection of the plane with the tetrahedra, as triangles whose normals point out of the part that
    /// is kept; positions in m. Quadratic tetrahedra are subdivided with their shape functions.
    pub(super) fn cut(&self, elements: &ElementNodes, positions: &[DVec3], field: &NodalValues) -> Vec<[Vertex; 3]> {
        let at = |nodes: &[u32], phi: &[f64]| Vertex {
            position: nodes.iter().zip(phi).map(|(n, w)| *w * positions[*n as usize]).sum(),
            value: field.at((nodes, phi)),
            normal: -self.normal,
        };
        let mut triangles = Vec::new();
        match elements {
            ElementNodes::Linear(tets) => {
                for tet in tets {
                    self.cut_tet(tet.map(|n| at(&[n], &[1.0])), &mut triangles);
                }
            }
            ElementNodes::Quadratic(tets) => {
                for tet in tets {
                    let above = tet.iter().filter(|n| self.distance(positions[**n as usize]) >= 0.0).count();
                    if (1..tet.len()).contains(&above) {
                        let corners = [0, 1, 2, 3].map(|k| [0, 1, 2, 3].map(|i| f64::from(u8::from(i == k))));
                        let point = |l: [f64; 4]| at(tet, &tet10_values(l));
                        self.cut_parts(corners, HALVINGS, &point, &mut triangles);
                    }
                }
            }
        }
        triangles
    }

    /// Intersects the part of a quadratic tetrahedron with these barycentric corners, after `halvings` further
    /// subdivisions.
    fn cut_parts(
        &self,
        corners: [[f64; 4]; 4],
        halvings: u32,
        point: &impl Fn([f64; 4]) -> Vertex,
        out: &mut Vec<[Vertex; 3]>,
    ) {
        if halvings == 0 {
            return self.cut_tet(corners.map(point), out);
        }
        let middle = |[a, b]: [usize; 2]| [0, 1, 2, 3].map(|i| 0.5 * (corners[a][i] + corners[b][i]));
        let middles = EDGES.map(middle);
        let at = |i: usize| if i < 4 { corners[i] } else { middles[i - 4] };
        PARTS.iter().for_each(|part| self.cut_parts(part.map(at), halvings - 1, point, out));
    }

    fn cut_tet(&self, corners: [Vertex; 4], out: &mut Vec<[Vertex; 3]>) {
        let side = corners.map(|v| self.distance(v.position));
        let (above, below): (Vec<usize>, Vec<usize>) = (0..4).partition(|&i| side[i] >= 0.0);
        let edge = |i: usize, j: usize| between(corners[i], corners[j], side[i], side[j]);
        match (above.as_slice(), below.as_slice()) {
            (&[a], &[b, c, d]) | (&[b, c, d], &[a]) => out.push([edge(a, b), edge(a, c), edge(a, d)]),
            (&[a, b], &[c, d]) => {
                // Order along the boundary of the quadrilateral.
                let ring = [edge(a, c), edge(a, d), edge(b, d), edge(b, c)];
                out.push([ring[0], ring[1], ring[2]]);
                out.push([ring[0], ring[2], ring[3]]);
            }
            _ => {}
        }
    }
}

/// Number of times that the edges of a quadratic tetrahedron are halved.
const HALVINGS: u32 = 2;

/// Eight sub-tetrahedra of a tetrahedron with halved edges: four at the corners, four from the inner octahedron, split
/// along the diagonal between the midpoints of edges (0,1) and (2,3).
const PARTS: [[usize; 4]; 8] =
    [[0, 4, 6, 7], [1, 4, 5, 8], [2, 5, 6, 9], [3, 7, 8, 9], [4, 9, 5, 6], [4, 9, 6, 7], [4, 9, 7, 8], [4, 9, 8, 5]];

/// Returns the intersection of the plane with the edge from `a` to `b`, whose signed distances `da` and `db` have
/// opposite signs.
fn between(a: Vertex, b: Vertex, da: f64, db: f64) -> Vertex {
    let t = (da / (da - db)).clamp(0.0, 1.0);
    Vertex {
        position: a.position.lerp(b.position, t),
        value: a.value + (b.value - a.value) * t,
        normal: a.normal.lerp(b.normal, t),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(triangles: &[[Vertex; 3]]) -> f64 {
        let one = |[a, b, c]: &[Vertex; 3]| (b.position - a.position).cross(c.position - a.position).length() / 2.0;
        triangles.iter().map(one).sum()
    }

    #[test]
    fn section_area_of_a_unit_tetrahedron_linear_and_quadratic() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let mids = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)].map(|(i, j)| (corners[i] + corners[j]) / 2.0);
        let nodes = [&corners[..], &mids[..]].concat();
        for z in [0.1, 0.3, 0.5, 0.8] {
            let plane = CutPlane { normal: DVec3::Z, offset: z };
            let exact = (1.0 - z) * (1.0 - z) / 2.0;
            let linear =
                plane.cut(&ElementNodes::Linear(vec![[0, 1, 2, 3]]), &nodes, &NodalValues::Numbers(vec![0.0; 10]));
            let quadratic = plane.cut(
                &ElementNodes::Quadratic(vec![[0, 1, 2, 3, 4, 5, 6, 7, 8, 9]]),
                &nodes,
                &NodalValues::Numbers(vec![0.0; 10]),
            );
            assert!((area(&linear) - exact).abs() < 1e-12);
            assert!((area(&quadratic) - exact).abs() < 1e-12);
        }
    }

    #[test]
    fn the_two_halves_of_a_clipped_triangle_make_the_whole() {
        let corner = |p: DVec3| Vertex { position: p, ..Vertex::default() };
        let triangle = [DVec3::ZERO, DVec3::X, DVec3::new(0.2, 0.9, 0.4)].map(corner);
        let plane = CutPlane { normal: DVec3::X, offset: 0.3 };
        let other = CutPlane { normal: -DVec3::X, offset: -0.3 };
        let sum = area(&plane.clip(triangle)) + area(&other.clip(triangle));
        assert!((sum - area(&[triangle])).abs() < 1e-12);
    }
}
