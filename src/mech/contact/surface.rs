//! Sample points on the free surface of a pad: the vertices of its subdivided faces, each with an area, and the
//! centroids of their sub-triangles (*sub-face samples*). The latter have a reduced contact offset and are active only
//! where vertices carry contact or the object would penetrate between them.

use crate::body::{Body, Elements};
use crate::element::EDGES;
use crate::potential::stencil::Stencil;
use base::scales::ROUNDING;
use geometry::mesh::adjacency::TriangleAdjacency;
use geometry::triangle6;
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A boundary face: three corners, and three mid-edge nodes ((0,1), (1,2), (2,0)) of a quadratic mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceFace {
    /// Corner nodes, counter-clockwise from outside.
    pub corners: [u32; 3],
    /// Mid-edge nodes; None for linear elements.
    pub mids: Option<[u32; 3]>,
}

/// Barycentric coordinate below which a point lies on the rim of its face.
pub(crate) const ON_RIM: f64 = 1e-9;

/// Sample points of a pad's free surface.
#[derive(Debug, Clone)]
pub struct ContactSurface {
    /// Faces that are not entirely fixed.
    pub faces: Arc<Vec<SurfaceFace>>,
    /// Adjacency of the faces.
    pub rings: Arc<TriangleAdjacency>,
    /// Location of each point: nodes and shape function values. The vertices come first, then the sub-face samples.
    pub points: Arc<Vec<Stencil>>,
    /// Number of points that are vertices.
    pub vertices: usize,
    /// Reference area of each point, m2; the areas of the sub-face samples sum to the area of the surface once more.
    pub area: Vec<f64>,
    /// Mean spacing of the vertices, m.
    pub spacing: f64,
    /// Nodes among which reports distribute the force of each point, with the weights of the linear interpolation on
    /// the nodal sub-triangles: non-negative, so that reported nodal forces have the sign of the pressure.
    pub report: Arc<Vec<Stencil>>,
    /// Vertices of the sub-triangles of each face.
    parts: Arc<Vec<u32>>,
}

/// Sub-edges per face edge of a linear and of a quadratic mesh: contact is detected between the nodes, too.
const SUBDIVISION: [usize; 2] = [4, 4];

impl ContactSurface {
    /// Samples the boundary faces of `body` that are not entirely fixed, each face edge cut into 4 parts.
    pub fn new(body: &Body) -> Self {
        Self::with_subdivision(body, SUBDIVISION[usize::from(matches!(body.elements, Elements::Quadratic(_)))])
    }

    /// Samples the boundary faces of `body` that are not entirely fixed, each face edge cut into `m` parts.
    pub fn with_subdivision(body: &Body, m: usize) -> Self {
        let faces: Vec<SurfaceFace> = boundary(body)
            .into_iter()
            .filter(|f| {
                let mut nodes = f.corners.to_vec();
                nodes.extend(f.mids.into_iter().flatten());
                !nodes.iter().all(|&n| body.fixed[n as usize])
            })
            .collect();
        // A lattice point shared by faces is one sample point: keyed by its corner weights, in node order.
        let mut index: BTreeMap<[(u32, u32); 3], u32> = BTreeMap::new();
        let cuts = sub_triangles(m);
        // The number of vertices is about half that of the sub-triangles.
        let (mut points, mut report) = (Vec::with_capacity(faces.len() * m * m * 13 / 8), Vec::new());
        report.reserve(points.capacity());
        let mut parts = Vec::with_capacity(faces.len() * cuts.len() * 3);
        let mut known = vec![None; (m + 1) * (m + 1)];
        for face in &faces {
            known.fill(None);
            for lattice in cuts.iter().flatten() {
                // Most corners are shared with earlier sub-triangles of this face.
                let known = &mut known[lattice[1] * (m + 1) + lattice[2]];
                let point = known.get_or_insert_with(|| {
                    let mut key = [0, 1, 2]
                        .map(|k| (face.corners[k], lattice[k] as u32))
                        .map(|(n, w)| if w == 0 { (u32::MAX, 0) } else { (n, w) });
                    key.sort_unstable();
                    *index.entry(key).or_insert_with(|| {
                        let l = lattice.map(|i| i as f64 / m as f64);
                        points.push(face.stencil(l));
                        report.push(face.report_stencil(l));
                        points.len() as u32 - 1
                    })
                });
                parts.push(*point);
            }
        }
        let vertices = points.len();
        for face in &faces {
            let middles = cuts.iter().map(|[a, b, c]| [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) as f64 / (3 * m) as f64));
            for l in middles {
                points.push(face.stencil(l));
                report.push(face.report_stencil(l));
            }
        }
        let rings = Arc::new(TriangleAdjacency::new(faces.iter().map(|f| f.corners).collect()));
        let (faces, points, report, parts) = (Arc::new(faces), Arc::new(points), Arc::new(report), Arc::new(parts));
        Self { faces, rings, points, vertices, report, parts, area: Vec::new(), spacing: 0.0 }.placed(&body.rest)
    }

    /// Vertices of the sub-triangle around sub-face sample `i`.
    pub fn around(&self, i: usize) -> [usize; 3] {
        let first = 3 * (i - self.vertices);
        [0, 1, 2].map(|k| self.parts[first + k] as usize)
    }

    /// Returns the surface of the same body with its nodes at reference positions `rest`, m.
    pub fn placed(&self, rest: &[DVec3]) -> Self {
        let mut area = vec![0.0; self.vertices];
        let own = self.parts.len() / self.faces.len().max(1);
        for (face, parts) in self.faces.iter().zip(self.parts.chunks_exact(own.max(1))) {
            let [a, b, c] = face.corners.map(|n| rest[n as usize]);
            let part = 0.5 * (b - a).cross(c - a).length() / (own / 3) as f64;
            parts.iter().for_each(|point| area[*point as usize] += part / 3.0);
            area.extend(std::iter::repeat_n(part, own / 3));
        }
        let total: f64 = area[..self.vertices].iter().sum();
        let spacing = (total / self.vertices.max(1) as f64).sqrt();
        Self { area, spacing, ..self.clone() }
    }
}

impl SurfaceFace {
    /// Returns true if a point at `distance` (m) from the face, with nodes at `x`, is on it up to rounding: the
    /// direction to it is then undefined.
    pub(crate) fn touches(&self, x: &[DVec3], distance: f64) -> bool {
        let [a, b, _] = self.corners.map(|n| x[n as usize]);
        distance < ROUNDING * a.distance(b)
    }

    /// Flat triangles between the nodes of the face, with its orientation: the face itself, or those at the corners and
    /// then the central one.
    pub fn flat_parts(&self) -> Vec<[u32; 3]> {
        let [a, b, c] = self.corners;
        match self.mids {
            None => vec![[a, b, c]],
            Some([ab, bc, ca]) => vec![[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]],
        }
    }

    /// Nodes of the face: corners, then mid-edge nodes.
    fn nodes(&self) -> impl Iterator<Item = u32> {
        self.corners.into_iter().chain(self.mids.into_iter().flatten())
    }

    /// Positions of the corners and midpoints of the edges for node positions `x`, m; also for a linear face.
    pub fn positions(&self, x: &[DVec3]) -> [DVec3; 6] {
        let [a, b, c] = self.corners.map(|n| x[n as usize]);
        self.six_nodes(x).unwrap_or([a, b, c, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)])
    }

    /// Positions of the six nodes of a quadratic face for node positions `x`, m; None for a linear one.
    pub(crate) fn six_nodes(&self, x: &[DVec3]) -> Option<[DVec3; 6]> {
        let [a, b, c] = self.corners;
        self.mids.map(|[ab, bc, ca]| [a, b, c, ab, bc, ca].map(|n| x[n as usize]))
    }

    /// Shape functions of the face at barycentric coordinates `l`.
    pub fn stencil(&self, l: [f64; 3]) -> Stencil {
        match self.mids {
            None => Stencil::new(self.nodes().zip(l)),
            Some(_) => Stencil::new(self.nodes().zip(triangle6::values(l))),
        }
    }

    /// Nodes with their shape functions at `l` and the derivatives of these in `l1`, `l2` (with `l0 = 1 - l1 - l2`).
    pub(crate) fn shape(&self, l: [f64; 3]) -> impl Iterator<Item = (u32, f64, DVec2)> {
        let (values, derivatives) = match self.mids {
            // The nodes limit the sequence: a linear face has three.
            None => {
                let zero = DVec2::ZERO;
                ([l[0], l[1], l[2], 0.0, 0.0, 0.0], [DVec2::NEG_ONE, DVec2::X, DVec2::Y, zero, zero, zero])
            }
            Some(_) => (triangle6::values(l), triangle6::derivatives(l)),
        };
        self.nodes().zip(values).zip(derivatives).map(|((node, value), derivative)| (node, value, derivative))
    }

    /// Linear interpolation on the sub-triangle of nodes that contains `l`.
    pub(crate) fn report_stencil(&self, l: [f64; 3]) -> Stencil {
        let [a, b, c] = self.corners;
        // A closest point may lie a little beyond the rim of its face.
        let l = l.map(|v| v.max(0.0));
        let sum: f64 = l.iter().sum();
        let l = l.map(|v| v / sum);
        let Some([ab, bc, ca]) = self.mids else { return self.stencil(l) };
        let (corner, k) = if l[0] >= 0.5 {
            ([a, ab, ca], [2.0 * l[0] - 1.0, 2.0 * l[1], 2.0 * l[2]])
        } else if l[1] >= 0.5 {
            ([b, bc, ab], [2.0 * l[1] - 1.0, 2.0 * l[2], 2.0 * l[0]])
        } else if l[2] >= 0.5 {
            ([c, ca, bc], [2.0 * l[2] - 1.0, 2.0 * l[0], 2.0 * l[1]])
        } else {
            ([bc, ca, ab], [1.0 - 2.0 * l[0], 1.0 - 2.0 * l[1], 1.0 - 2.0 * l[2]])
        };
        Stencil::new(corner.into_iter().zip(k))
    }
}

/// Lattice triangles of a face whose edges are cut into `m` parts, as integer barycentric coordinates.
pub fn sub_triangles(m: usize) -> Vec<[[usize; 3]; 3]> {
    let mut triangles = Vec::new();
    for i in 0..m {
        for j in 0..m - i {
            let p = |i: usize, j: usize| [m - i - j, i, j];
            triangles.push([p(i, j), p(i + 1, j), p(i, j + 1)]);
            if i + j + 1 < m {
                triangles.push([p(i + 1, j), p(i + 1, j + 1), p(i, j + 1)]);
            }
        }
    }
    triangles
}

/// Faces that belong to one element only, outward.
fn boundary(body: &Body) -> Vec<SurfaceFace> {
    // Face k is opposite to corner k; vertices counter-clockwise from outside for positive volume.
    const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];
    let mid = |i: usize, j: usize| 4 + EDGES.iter().position(|e| *e == [i, j] || *e == [j, i]).unwrap_or(0);
    let mut seen: BTreeMap<[u32; 3], (usize, SurfaceFace)> = BTreeMap::new();
    let mut add = |corner: &[u32], nodes: &[u32]| {
        for f in FACES {
            let corners = f.map(|k| corner[k]);
            let mids =
                (nodes.len() == 10).then(|| [mid(f[0], f[1]), mid(f[1], f[2]), mid(f[2], f[0])].map(|k| nodes[k]));
            let mut key = corners;
            key.sort_unstable();
            seen.entry(key).or_insert((0, SurfaceFace { corners, mids })).0 += 1;
        }
    };
    match &body.elements {
        Elements::Linear(e) => e.iter().for_each(|n| add(&n[..4], n)),
        Elements::Quadratic(e) => e.iter().for_each(|n| add(&n[..4], n)),
    }
    seen.into_values().filter(|(count, _)| *count == 1).map(|(_, face)| face).collect()
}

/// Position and unit outward normal of a face at barycentric coordinates `l`, for node positions `x`.
pub fn face_frame(face: &SurfaceFace, x: &[DVec3], l: [f64; 3]) -> (DVec3, DVec3) {
    match face.six_nodes(x) {
        None => {
            let [a, b, c] = face.corners.map(|n| x[n as usize]);
            (a * l[0] + b * l[1] + c * l[2], (b - a).cross(c - a).normalize_or_zero())
        }
        Some(nodes) => {
            let [d1, d2] = triangle6::tangents(&nodes, l);
            (face.stencil(l).position(x), d1.cross(d2).normalize_or_zero())
        }
    }
}

/// Position and derivatives in `l1`, `l2` (with `l0 = 1 - l1 - l2`) of a face.
#[inline]
pub(crate) fn tangents(face: &SurfaceFace, x: &[DVec3], l: [f64; 3]) -> (DVec3, DVec3, DVec3) {
    match face.six_nodes(x) {
        None => {
            let [a, b, c] = face.corners.map(|n| x[n as usize]);
            (face.stencil(l).position(x), b - a, c - a)
        }
        Some(nodes) => {
            let [d1, d2] = triangle6::tangents(&nodes, l);
            (triangle6::position(&nodes, l), d1, d2)
        }
    }
}
