//! Exact signed distance to a closed triangle mesh.
//!
//! The magnitude comes from a bounding-volume tree, the sign from the pseudo-normal of the closest face, edge or vertex
//! (Baerentzen and Aanaes 2005). A lattice of distances over the bounding box of the mesh supplies a nearby facet as
//! the start of each search and rejects distant points by the Lipschitz bound, without a traversal of the tree.

use crate::mesh::TriMesh;
use crate::mesh::adjacency::{SurfacePart, TriangleAdjacency, TrianglePart, TrianglePosition};
use crate::shape::bvh::Bvh;
use crate::shape::facet::Facet;
use crate::shape::lattice::Lattice;
use crate::shape::topology::Topology;
use crate::shape::{ContactPoints, Hit, SignedDistance, SurfacePoint, outer};
use base::error::Result;
use glam::{DMat3, DVec3};
use std::sync::Arc;

/// Distance below which the direction from the closest point is dominated by rounding, m; the gradient is then the
/// pseudo-normal.
const COINCIDENT: f64 = 1e-12;

/// Signed distance to a closed, outward-wound triangle mesh.
#[derive(Debug)]
pub struct MeshDistance {
    mesh: Arc<TriMesh>,
    topology: Topology,
    rings: TriangleAdjacency,
    bvh: Bvh,
    /// Index of the facet of each triangle.
    facet: Vec<u32>,
    lattice: Lattice,
}

impl MeshDistance {
    /// Builds the distance of a mesh. The orientation is not checked: for an inverted mesh the sign is reversed.
    ///
    /// # Errors
    /// Fails if the mesh is open, inconsistently wound or degenerate.
    pub fn new(mesh: Arc<TriMesh>) -> Result<Self> {
        let topology = Topology::new(&mesh)?;
        Ok(Self::with_topology(mesh, topology))
    }

    pub(crate) fn with_topology(mesh: Arc<TriMesh>, topology: Topology) -> Self {
        let corners = |t: [u32; 3]| t.map(|v| mesh.vertices[v as usize]);
        // `Topology` has rejected every triangle that has no facet.
        let facets = mesh.triangles.iter().zip(0..).filter_map(|(&t, i)| Facet::new(corners(t), i)).collect();
        let bvh = Bvh::new(facets);
        let mut facet = vec![0; mesh.triangles.len()];
        bvh.facets.iter().zip(0..).for_each(|(f, i)| facet[f.triangle as usize] = i);
        let rings = TriangleAdjacency::new(mesh.triangles.clone());
        let mut lattice = Lattice::over(bvh.bounds());
        let this = Self { mesh, topology, rings, bvh, facet, lattice: Lattice::over(Default::default()) };
        lattice.fill(|q, seed| {
            let (_, i) = this.bvh.nearest(q, (this.bvh.facets[seed as usize].nearest(q).0, seed));
            (this.signed(q, i).distance, i)
        });
        Self { lattice, ..this }
    }

    /// Returns the mesh.
    pub fn mesh(&self) -> &Arc<TriMesh> {
        &self.mesh
    }

    /// Returns distance and gradient, given the index of the facet closest to `q`.
    #[inline]
    fn signed(&self, q: DVec3, facet: u32) -> SurfacePoint {
        let f = &self.bvh.facets[facet as usize];
        let corners = self.mesh.triangles[f.triangle as usize];
        let corner = |i: usize| corners[(i + f.turn as usize) % 3] as usize;
        let (point, pseudo) = match f.nearest(q).1 {
            // On a face the distance from the plane and its normal are exact.
            TrianglePart::Face => {
                return SurfacePoint { distance: f.n.dot(q - f.origin), normal: f.n, curvature: DMat3::ZERO };
            }
            TrianglePart::Edge(i) => {
                let (a, b) = (self.mesh.vertices[corner(i)], self.mesh.vertices[corner(i + 1)]);
                let e = b - a;
                let t = ((q - a).dot(e) / e.length_squared()).clamp(0.0, 1.0);
                let edge = self.topology.triangle_edges[f.triangle as usize][(i + f.turn as usize) % 3];
                (a + t * e, self.topology.edge_normals[edge as usize])
            }
            TrianglePart::Corner(i) => (self.mesh.vertices[corner(i)], self.topology.vertex_normals[corner(i)]),
        };
        let away = q - point;
        let (length, inside) = (away.length(), away.dot(pseudo) < 0.0);
        let distance = if inside { -length } else { length };
        let normal = if length < COINCIDENT { pseudo } else { away / distance };
        SurfacePoint { distance, normal, curvature: DMat3::ZERO }
    }

    /// Returns the closest point of the surface if its signed distance is below `max`, and its facet.
    #[inline]
    fn signed_within(&self, q: DVec3, max: f64) -> Option<(SurfacePoint, u32)> {
        let (seed, limit) = match self.lattice.cell_at(q) {
            Some(cell) if cell.at_least >= max => return None,
            // If `q` is outside for certain, distances beyond `max` are irrelevant. Otherwise it may be deep inside,
            // below any `max`.
            Some(cell) => (cell.seed, if cell.at_least > 0.0 { max } else { f64::INFINITY }),
            None => {
                let gap = self.bvh.bounds().distance_squared(q);
                if !(gap < max * max && max > 0.0) {
                    return None;
                }
                (0, max)
            }
        };
        let start = self.bvh.facets[seed as usize].nearest(q).0;
        // The margin ensures that squaring does not exclude a point that is at `max` to within rounding.
        let limit = limit * limit * (1.0 + 1e-12);
        let best = self.bvh.nearest(q, if start < limit { (start, seed) } else { (limit, u32::MAX) });
        if best.1 == u32::MAX {
            return None;
        }
        let closest = self.signed(q, best.1);
        (closest.distance < max).then_some((closest, best.1))
    }

    /// Returns the surface points other than the closest one, which is on `facet`, that interact with `q` within the
    /// distance `felt` (m), with their weights: near a concave edge, the closest point on the other incident face.
    fn additional_points(&self, q: DVec3, facet: u32, felt: f64) -> Vec<(SurfacePoint, f64)> {
        let f = &self.bvh.facets[facet as usize];
        let (_, nearest) = f.nearest(q);
        if nearest == TrianglePart::Face && f.edge_distance(q) > 2.0 * felt {
            return Vec::new();
        }
        let view = |t: u32| {
            let other = &self.bvh.facets[self.facet[t as usize] as usize];
            match other.nearest_within(q, felt * felt) {
                (squared, _) if squared >= felt * felt => TrianglePosition::Beyond,
                (_, TrianglePart::Face) if other.n.dot(q - other.origin) < 0.0 => TrianglePosition::Behind,
                (_, part) => TrianglePosition::At(other.mesh_part(part)),
            }
        };
        let along = |t, i| self.closest_on_edge(q, t, i).1;
        let others = self.rings.additional_parts(f.triangle, f.mesh_part(nearest), view, along).into_iter();
        others.filter_map(|(place, weight)| Some((self.surface_point(q, place)?, weight))).collect()
    }

    /// Returns the point of edge `i` of triangle `t` that is closest to `q`, and the part of the triangle that contains
    /// it.
    fn closest_on_edge(&self, q: DVec3, t: u32, i: usize) -> (DVec3, TrianglePart) {
        let [a, b] = [i, (i + 1) % 3].map(|k| self.mesh.corners(t as usize)[k]);
        let s = (q - a).dot(b - a) / (b - a).length_squared();
        let part = if s <= 0.0 {
            TrianglePart::Corner(i)
        } else if s >= 1.0 {
            TrianglePart::Corner((i + 1) % 3)
        } else {
            TrianglePart::Edge(i)
        };
        (a.lerp(b, s.clamp(0.0, 1.0)), part)
    }

    /// Returns closest point data for a part of the surface that faces `q`.
    fn surface_point(&self, q: DVec3, place: SurfacePart) -> Option<SurfacePoint> {
        let (point, turning) = match place {
            SurfacePart::Face(t) => {
                let f = &self.bvh.facets[self.facet[t as usize] as usize];
                let distance = f.n.dot(q - f.origin);
                return Some(SurfacePoint { distance, normal: f.n, curvature: DMat3::ZERO });
            }
            SurfacePart::Edge(e) => {
                let (t, i) = self.rings.triangle_of_edge(e);
                let [a, b] = [i, (i + 1) % 3].map(|k| self.mesh.corners(t as usize)[k]);
                (self.closest_on_edge(q, t, i).0, DMat3::IDENTITY - outer((b - a).normalize()))
            }
            SurfacePart::Corner(v) => (self.mesh.vertices[v as usize], DMat3::IDENTITY),
        };
        let distance = q.distance(point);
        let normal = (q - point).try_normalize()?;
        Some(SurfacePoint { distance, normal, curvature: (turning - outer(normal)) * distance.recip() })
    }
}

impl SignedDistance for MeshDistance {
    fn distance(&self, q: DVec3) -> f64 {
        self.closest(q, f64::INFINITY).map_or(f64::NAN, |c| c.distance)
    }

    fn closest(&self, q: DVec3, max: f64) -> Option<SurfacePoint> {
        Some(self.signed_within(q, max)?.0)
    }

    fn contact_points(&self, q: DVec3, max: f64, felt: f64) -> Option<ContactPoints> {
        let (nearest, facet) = self.signed_within(q, max)?;
        let beside = if nearest.distance < felt { self.additional_points(q, facet, felt) } else { Vec::new() };
        Some(ContactPoints { nearest, additional: beside })
    }

    fn ray(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        let d = direction.try_normalize().filter(|_| origin.is_finite())?;
        let (t, i) = self.bvh.ray_entry(origin, d)?;
        Some(Hit { t, normal: self.bvh.facets[i as usize].n })
    }

    fn support(&self, direction: DVec3) -> Option<DVec3> {
        self.mesh.vertices.iter().copied().max_by(|a, b| a.dot(direction).total_cmp(&b.dot(direction)))
    }
}
