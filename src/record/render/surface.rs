//! Surface of a pad: quadratic faces are subdivided into triangles small enough to appear curved, whose corners are
//! evaluated with the shape functions of the elements.

use super::normals::corner_normals;
use super::raster::Vertex;
use super::style::NodalValues;
use crate::{ElementNodes, PadTopology};
use glam::DVec3;
use mech::contact::SurfaceFace;
use mech::contact::surface::sub_triangles;
use mech::element::EDGES;
use mech::potential::term::Stencil;
use std::collections::{HashMap, HashSet};

/// Number of segments per edge of a curved face: about six pixels each at 13 pixels/mm and 2.6 mm per face edge.
const PARTS: usize = 6;

/// Triangles between points on element faces.
#[derive(Default)]
pub struct Surface {
    /// Nodes and shape function values of each point.
    pub points: Vec<Stencil>,
    /// Points of each triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl Surface {
    /// Returns the sensing face and the rest of the outer surface; quadratic if `curved` and the elements are,
    /// otherwise flat between nodes.
    pub fn sensing_and_outer(topology: &PadTopology, curved: bool) -> [Self; 2] {
        let flat = |triangles: &[[u32; 3]]| triangles.iter().map(|t| SurfaceFace { corners: *t, mids: None }).collect();
        let [sensing, outside] = curved
            .then(|| faces(topology))
            .flatten()
            .unwrap_or_else(|| [flat(&topology.sensing), flat(&topology.outer_triangles())]);
        [Self::of(&sensing), Self::of(&outside)]
    }

    fn of(faces: &[SurfaceFace]) -> Self {
        let (mut surface, mut known) = (Self::default(), HashMap::new());
        for face in faces {
            let parts = if face.mids.is_some() { PARTS } else { 1 };
            for triangle in sub_triangles(parts) {
                let corner = triangle.map(|lattice| {
                    // Faces share points: the key consists of corner nodes and their weights, sorted by node.
                    let mut key = [0, 1, 2].map(|k| (face.corners[k], lattice[k] * PARTS / parts));
                    key.iter_mut().filter(|(_, weight)| *weight == 0).for_each(|entry| *entry = (u32::MAX, 0));
                    key.sort_unstable();
                    *known.entry(key).or_insert_with(|| {
                        surface.points.push(face.stencil(lattice.map(|i| i as f64 / parts as f64)));
                        surface.points.len() as u32 - 1
                    })
                });
                surface.triangles.push(corner);
            }
        }
        surface
    }

    /// Returns the positions of the points for nodes at `x`.
    pub fn positions(&self, x: &[DVec3]) -> Vec<DVec3> {
        self.points.iter().map(|point| point.position(x)).collect()
    }

    /// Returns the values of a field at the points.
    pub fn values(&self, field: &NodalValues) -> Vec<f64> {
        self.points.iter().map(|point| field.at(point.slices())).collect()
    }

    /// Returns the triangles with positions, values and shading normals for nodes at `x`.
    pub fn shaded(&self, x: &[DVec3], field: &NodalValues) -> Vec<[Vertex; 3]> {
        let (positions, values) = (self.positions(x), self.values(field));
        let normals = corner_normals(&positions, &self.triangles);
        let vertex = |(triangle, normals): (&[u32; 3], [DVec3; 3])| {
            [0, 1, 2].map(|k| {
                let point = triangle[k] as usize;
                Vertex { position: positions[point], value: values[point], normal: normals[k] }
            })
        };
        self.triangles.iter().zip(normals).map(vertex).collect()
    }
}

/// Returns the sensing and the other faces with their mid-edge nodes; None for linear elements, or if the sensing face
/// does not consist of whole element faces.
fn faces(topology: &PadTopology) -> Option<[Vec<SurfaceFace>; 2]> {
    let ElementNodes::Quadratic(tets) = &topology.elements else { return None };
    let edge = |a: u32, b: u32| [a.min(b), a.max(b)];
    let middle: HashMap<[u32; 2], u32> =
        tets.iter().flat_map(|t| (0..6).map(|e| (edge(t[EDGES[e][0]], t[EDGES[e][1]]), t[4 + e]))).collect();
    let face = |&[a, b, c]: &[u32; 3]| {
        let mids = [*middle.get(&edge(a, b))?, *middle.get(&edge(b, c))?, *middle.get(&edge(c, a))?];
        Some(SurfaceFace { corners: [a, b, c], mids: Some(mids) })
    };
    let nodes: HashSet<u32> = topology.sensing.as_flattened().iter().copied().collect();
    let all: Vec<SurfaceFace> = topology.surface.iter().map(face).collect::<Option<_>>()?;
    let (sensing, outside): (Vec<SurfaceFace>, Vec<SurfaceFace>) =
        all.into_iter().partition(|f| f.corners.iter().chain(f.mids.iter().flatten()).all(|n| nodes.contains(n)));
    (4 * sensing.len() == topology.sensing.len()).then_some([sensing, outside])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks two faces with a common curved edge: no point is duplicated, and the edge is a parabola.
    #[test]
    fn a_curved_edge_is_a_parabola_and_faces_share_its_points() {
        let faces = [
            SurfaceFace { corners: [0, 1, 2], mids: Some([4, 5, 6]) },
            SurfaceFace { corners: [1, 0, 3], mids: Some([4, 7, 8]) },
        ];
        let mut x =
            [(0., 0.), (1., 0.), (0., 1.), (0., -1.), (0.5, 0.), (0.5, 0.5), (0., 0.5), (0., -0.5), (0.5, -0.5)]
                .map(|(x, y)| DVec3::new(x, y, 0.0));
        x[4].z = 0.4;
        let surface = Surface::of(&faces);
        assert_eq!(surface.points.len(), 28 + 28 - (PARTS + 1));
        let on_edge = surface.positions(&x).into_iter().filter(|p| p.y.abs() < 1e-12);
        assert!(
            on_edge.clone().count() == PARTS + 1 && { on_edge }.all(|p| (p.z - 1.6 * p.x * (1.0 - p.x)).abs() < 1e-12)
        );
    }
}
