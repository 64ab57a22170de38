//! Penetration depth: points of a pad inside the object, of the object inside a pad, of a pad inside the other.

use super::inversion::position;
use super::solid::Solid;
use super::tetrahedra::Tetrahedra;
use super::triangle;
use geometry::mesh::TriMesh;
use glam::DVec3;
use record::{ElementNodes, PadTopology};
use std::collections::BTreeMap;

/// Number of parts into which an edge of a boundary face is divided. The resulting points differ from the contact
/// samples of the solver.
const PARTS: usize = 6;

/// Free surface of a pad: boundary faces that are not bonded to the finger.
#[derive(Debug)]
pub struct PadSurface {
    /// Nodes of each face: corners and, for 10-node tetrahedra, the mid-edge nodes of (0,1), (1,2), (2,0); otherwise
    /// corners again.
    faces: Vec<[u32; 6]>,
    quadratic: bool,
    /// True for each node on a free face.
    pub free: Vec<bool>,
    /// Mean edge length of the parts into which a face is divided, m.
    pub spacing: f64,
}

/// Points of the object's surface, object frame: vertices, and points along its edges.
#[derive(Debug)]
pub struct ObjectPoints(Vec<DVec3>);

/// Cosine of the angle between the normals of two triangles above which their edge counts as smooth: points of the pad
/// detect penetration there.
const ROUND: f64 = 0.985;

impl ObjectPoints {
    /// Collects the vertices of `surface`, and points along its edges at most `spacing` (m) apart. If the mesh only
    /// approximates a curved surface (`drawing`), only sharp edges get such points, because the others are chords
    /// inside the object.
    pub fn new(surface: &TriMesh, drawing: bool, spacing: f64) -> Self {
        let mut points = surface.vertices.clone();
        let mut normals = BTreeMap::new();
        for (t, corners) in surface.triangles.iter().enumerate() {
            let [a, b, c] = surface.corners(t);
            let normal = (b - a).cross(c - a).normalize_or_zero();
            for k in 0..3 {
                let (i, j) = (corners[k], corners[(k + 1) % 3]);
                // The adjacent triangle has the edge in the opposite direction.
                let Some(other) = normals.remove(&(j, i)) else {
                    normals.insert((i, j), normal);
                    continue;
                };
                if !drawing || normal.dot(other) < ROUND {
                    let (a, b) = (surface.vertices[i as usize], surface.vertices[j as usize]);
                    let parts = (a.distance(b) / spacing).ceil().clamp(1.0, 1000.0) as usize;
                    points.extend((1..parts).map(|i| a.lerp(b, i as f64 / parts as f64)));
                }
            }
        }
        Self(points)
    }
}

impl PadSurface {
    /// Creates the free surface of a recorded pad.
    pub fn new(topology: &PadTopology) -> Self {
        let mut middle = BTreeMap::new();
        if let ElementNodes::Quadratic(tets) = &topology.elements {
            for n in tets {
                for (e, [i, j]) in [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]].into_iter().enumerate() {
                    middle.insert((n[i].min(n[j]), n[i].max(n[j])), n[4 + e]);
                }
            }
        }
        let quadratic = !middle.is_empty();
        let mut free = vec![false; topology.rest.len()];
        let (mut faces, mut length) = (Vec::new(), 0.0);
        for &[a, b, c] in &topology.surface {
            if [a, b, c].iter().all(|&i| topology.bonded[i as usize]) {
                continue;
            }
            let between = |i: u32, j: u32| middle.get(&(i.min(j), i.max(j))).copied().unwrap_or(i);
            let face = [a, b, c, between(a, b), between(b, c), between(c, a)];
            face.iter().for_each(|&i| free[i as usize] = true);
            length += topology.rest[a as usize].distance(topology.rest[b as usize]);
            faces.push(face);
        }
        let spacing = length / (faces.len().max(1) * PARTS) as f64;
        Self { faces, quadratic, free, spacing }
    }

    /// Returns the largest depth of a point of the pad in the object or of the object in the pad, m; zero if nothing
    /// penetrates. `tets` are the tetrahedra of the pad in the object frame.
    pub fn depth(&self, tets: &Tetrahedra, solid: &Solid, object: &ObjectPoints) -> f64 {
        let x = tets.x;
        let points = x.iter().copied().chain(self.points(x)).chain(centers(tets.elements, x));
        let of_pad = points.map(|p| solid.depth(p)).fold(0.0, f64::max);
        let of_object = object.0.iter().copied().filter(|p| tets.contains(*p) && self.between(*p, solid));
        self.depth_below_surface(of_object, x).max(of_pad)
    }

    /// Returns the largest depth in this pad of the surface nodes of another pad, at `others`, m.
    pub fn depth_of_nodes(&self, tets: &Tetrahedra, others: impl Iterator<Item = DVec3>) -> f64 {
        self.depth_below_surface(others.filter(|p| tets.contains(*p)), tets.x)
    }

    /// Returns the largest distance to the free surface of points inside the pad, m.
    fn depth_below_surface(&self, inside: impl Iterator<Item = DVec3>, x: &[DVec3]) -> f64 {
        let mut inside = inside.peekable();
        if inside.peek().is_none() {
            return 0.0;
        }
        let spheres: Vec<(DVec3, f64)> = self.faces.iter().map(|face| self.sphere(face, x)).collect();
        inside.map(|p| self.distance(p, &spheres, x)).fold(0.0, f64::max)
    }

    /// Returns the distance of `p` to the free surface, whose faces have the bounding `spheres`, m. Flat pieces
    /// approximate a strongly curved face too coarsely, so pieces near `p` are repeatedly divided into four.
    fn distance(&self, p: DVec3, spheres: &[(DVec3, f64)], x: &[DVec3]) -> f64 {
        let away = |pieces: &[Piece]| -> Vec<f64> {
            pieces.iter().map(|piece| triangle::distance(&[piece.flat], p)).collect()
        };
        let least = |distances: &[f64]| distances.iter().copied().fold(f64::INFINITY, f64::min);
        let mut slack = 0.5 * self.spacing;
        let farthest = spheres.iter().map(|(center, radius)| center.distance(p) + radius).fold(f64::INFINITY, f64::min);
        let reached = |i: usize| spheres[i].0.distance(p) - spheres[i].1 <= farthest + slack;
        let faces = (0..self.faces.len()).filter(|i| reached(*i)).map(|i| &self.faces[i]);
        let mut near: Vec<Piece> =
            faces.flat_map(|face| parts().map(|part| Piece::new(self, *face, part, x))).collect();
        let mut distances = away(&near);
        for _ in 0..if self.quadratic { CUTS } else { 0 } {
            let close = least(&distances) + slack;
            let pieces = near.iter().zip(&distances).filter(|(_, d)| **d <= close);
            near = pieces.flat_map(|(piece, _)| piece.quarters(self, x)).collect();
            distances = away(&near);
            slack *= 0.25;
        }
        least(&distances)
    }

    /// Returns a bounding sphere of a face.
    fn sphere(&self, face: &[u32; 6], x: &[DVec3]) -> (DVec3, f64) {
        let n = face.map(|i| x[i as usize]);
        let center = n.iter().sum::<DVec3>() / 6.0;
        // A quadratic face lies in the convex hull of its Bezier control points.
        let middle =
            |m: usize, i: usize, j: usize| if self.quadratic { n[m] * 2.0 - (n[i] + n[j]) * 0.5 } else { n[m] };
        let around = [n[0], n[1], n[2], middle(3, 0, 1), middle(4, 1, 2), middle(5, 2, 0)];
        (center, around.iter().map(|p| p.distance(center)).fold(0.0, f64::max))
    }

    /// Returns true if a point of the mesh belongs to the object; a chord across a concave part of the true surface
    /// does not.
    fn between(&self, p: DVec3, solid: &Solid) -> bool {
        match solid {
            Solid::Surface(_) => true,
            _ => solid.depth(p * (1.0 - 1e-9)) > 0.0 || solid.depth(p * (1.0 + 1e-9)) > 0.0,
        }
    }

    /// Returns points of the free surface, one for each part of its faces, m.
    fn points<'a>(&'a self, x: &'a [DVec3]) -> impl Iterator<Item = DVec3> + 'a {
        let center = |part: [[f64; 3]; 3]| [0, 1, 2].map(|k| (part[0][k] + part[1][k] + part[2][k]) / 3.0);
        self.faces.iter().flat_map(move |face| parts().map(move |part| self.point(face, center(part), x)))
    }

    /// Returns the point of a face at barycentric coordinates `l`, m.
    fn point(&self, face: &[u32; 6], l: [f64; 3], x: &[DVec3]) -> DVec3 {
        let n = face.map(|i| x[i as usize]);
        if !self.quadratic {
            return n[0] * l[0] + n[1] * l[1] + n[2] * l[2];
        }
        let corners: DVec3 = (0..3).map(|k| n[k] * (l[k] * (2.0 * l[k] - 1.0))).sum();
        corners + n[3] * (4.0 * l[0] * l[1]) + n[4] * (4.0 * l[1] * l[2]) + n[5] * (4.0 * l[2] * l[0])
    }
}

/// Returns every part of a face, given by the barycentric coordinates of its corners.
fn parts() -> impl Iterator<Item = [[f64; 3]; 3]> {
    let at = |i: usize, j: usize| [PARTS - i - j, i, j].map(|k| k as f64 / PARTS as f64);
    let row = move |i: usize| {
        (0..PARTS - i).flat_map(move |j| {
            let under = (i + j + 1 < PARTS).then(|| [at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            std::iter::once([at(i, j), at(i + 1, j), at(i, j + 1)]).chain(under)
        })
    };
    (0..PARTS).flat_map(row)
}

/// Number of subdivisions of the pieces near a point; they reduce the distance between flat pieces and curved face by a
/// factor of a thousand.
const CUTS: usize = 5;

/// Piece of a face: the barycentric coordinates of its corners and the flat triangle between them.
#[derive(Clone, Copy)]
struct Piece {
    face: [u32; 6],
    part: [[f64; 3]; 3],
    /// Corners of the flat triangle, m.
    flat: [DVec3; 3],
}

impl Piece {
    fn new(surface: &PadSurface, face: [u32; 6], part: [[f64; 3]; 3], x: &[DVec3]) -> Self {
        Self { face, part, flat: part.map(|l| surface.point(&face, l, x)) }
    }

    /// Returns the four pieces between the corners and the midpoints of the sides.
    fn quarters(&self, surface: &PadSurface, x: &[DVec3]) -> [Self; 4] {
        let [a, b, c] = self.part;
        let middle = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|k| 0.5 * (a[k] + b[k]));
        let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]].map(|part| Self::new(surface, self.face, part, x))
    }
}

/// Returns the material centre of every tetrahedron, m. In a curved one it is not the mean of the corners, which may
/// lie outside.
fn centers(elements: &ElementNodes, x: &[DVec3]) -> Vec<DVec3> {
    let node = |i: u32| x[i as usize];
    match elements {
        ElementNodes::Linear(tets) => tets.iter().map(|n| n.map(node).iter().sum::<DVec3>() / 4.0).collect(),
        ElementNodes::Quadratic(tets) => tets.iter().map(|n| position(&n.map(node), &[0.25; 4])).collect(),
    }
}
