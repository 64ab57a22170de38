//! Contact surface of a mesh object: its facets, or a smooth surface that approximates them.
//!
//! The facets of a scan are an artefact of its decimation: at each edge between them the contact normal rotates within
//! one contact offset, which a smooth surface avoids. A mesh keeps its facets where they are its true shape, as those
//! of a box.

use crate::Aabb;
use crate::mesh::TriMesh;
use crate::mesh::disjoint_sets::DisjointSets;
use crate::shape::features::{ConvexEdge, FeaturePoint, SHARP_ANGLE, SurfaceFeatures, division_count};
use crate::shape::level_set::LevelSet;
use crate::shape::solid::Shape;
pub use crate::shape::surface_definition::{SmoothSurface, SurfaceDefinition};
use crate::shape::topology::Topology;
use base::error::{Error, Result};
use glam::DVec3;
use glamx::DSymmetricEigen3;
use std::sync::Arc;

/// Angle below which adjacent triangles belong to one flat face, rad.
const COPLANAR: f64 = 0.5 / 180.0 * std::f64::consts::PI;
/// Distance to the mesh, over the radius, above which a surface is rejected: rounding moves the corner of a cube by
/// `sqrt(3) - 1`, an edge of 60 degrees by 1. Sharper edges, and parts thinner than the grid resolves, would be lost.
const ROUNDED: f64 = 1.0;
/// Width of a flat face, over the radius, from which on its edges are edges of the object, not artefacts of a
/// triangulation.
const MIN_FACE_WIDTH: f64 = 2.0;
/// Number of times that the radius is halved before the facets are kept.
const HALVINGS: u32 = 3;
/// Largest number of grid cells along an object.
const CELLS: f64 = 512.0;

impl Shape {
    /// Returns true if the mesh is only for display, with vertices on the true surface.
    pub fn has_display_mesh(&self) -> bool {
        !matches!(self.definition, SurfaceDefinition::Facets)
    }

    /// Returns the object with a smooth surface that rounds edges by about `radius` (m), for pads whose points are
    /// `spacing` (m) apart. The surface depends on the radius alone; the points sampled on it, on the spacing.
    ///
    /// # Errors
    /// Fails for a radius that requires more than 512 grid cells along the object.
    pub fn smoothed(&self, radius: f64, spacing: f64) -> Result<Self> {
        let size = self.aabb.size().max_element();
        if !(size <= CELLS * radius) {
            return Err(Error::Mesh(format!(
                "a radius of {radius:e} m needs more than {CELLS} cells along the {}, which is {size:.3} m long; write \
                 at least {:.1e} m",
                self.name,
                size / CELLS
            )));
        }
        // A grid along the principal axes rotates with the object.
        let inertia = self.mass.inertia;
        let trace = inertia.x_axis.x + inertia.y_axis.y + inertia.z_axis.z;
        let axes = DSymmetricEigen3::new(inertia * trace.recip()).eigenvectors;
        let mut level = LevelSet::new(self.distance.clone(), &self.surface.vertices, (self.mass.center, axes), radius);
        let [largest, rms] = level.fit(&samples(&self.surface));
        let level = Arc::new(level);
        let on = |p: DVec3| level.project(p).map_or(p, |(c, _)| c);
        let mut surface = TriMesh::clone(&self.surface);
        surface.vertices.iter_mut().for_each(|p| *p = on(*p));
        // The points of a pad do not resolve the rounding of sharp edges: rows of samples along the edges cover it.
        let fine = 0.5 * spacing;
        let rows = (radius / fine).ceil() as i32;
        let beside = |edge: &ConvexEdge| {
            let across = (edge.b - edge.a).cross(edge.normal).normalize_or_zero() * fine;
            let (edge, along) = (*edge, division_count(edge.length(), fine));
            (0..=along).flat_map(move |i| {
                let on_edge = edge.point(f64::from(i) / f64::from(along));
                (-rows..=rows)
                    .map(move |k| FeaturePoint { position: on_edge.position + across * f64::from(k), ..on_edge })
            })
        };
        let rounded = |f: FeaturePoint| FeaturePoint { position: on(f.position), sharp: false, ..f };
        let corners = self.features.vertices.iter().filter(|v| v.sharp).copied();
        let vertices = corners.chain(self.features.sharp_edges.iter().flat_map(beside)).map(rounded).collect();
        Ok(Self {
            aabb: Aabb::from_points(surface.vertices.iter().copied()),
            bounding_radius: surface.vertices.iter().fold(0.0, |r: f64, p| r.max(p.length())),
            surface: Arc::new(surface),
            features: Arc::new(SurfaceFeatures { vertices, ..SurfaceFeatures::default() }),
            distance: level.clone(),
            definition: SurfaceDefinition::Smooth(SmoothSurface { level, largest, rms }),
            ..self.clone()
        })
    }

    /// Returns the object with the surface suited to its mesh, for pads whose points are `spacing` (m) apart: smooth,
    /// with an edge radius of at most `radius` (m), or the facets, with the reason. The choice does not depend on the
    /// spacing.
    pub fn with_suitable_surface(&self, mut radius: f64, spacing: f64) -> (Self, Option<String>) {
        if !matches!(self.definition, SurfaceDefinition::Facets) {
            return (self.clone(), None);
        }
        if self.aabb.size().max_element() > CELLS * radius {
            return (self.clone(), Some("it is too large for a grid as fine as the radius of its edges".into()));
        }
        if has_sharp_faces(&self.surface, MIN_FACE_WIDTH * radius) {
            return (self.clone(), Some("its edges bound flat faces".into()));
        }
        for _ in 0..=HALVINGS {
            let Ok(smooth) = self.smoothed(radius, spacing) else { break };
            if let SurfaceDefinition::Smooth(SmoothSurface { largest, .. }) = smooth.definition
                && largest <= ROUNDED * radius
            {
                return (smooth, None);
            }
            radius *= 0.5;
        }
        (self.clone(), Some(format!("it is too thin or too sharp to be rounded by {:.2} mm", radius * 2e3)))
    }
}

/// Sample points of a surface with their weights: vertices, edge midpoints and centroid of each triangle, each with a
/// seventh of its area.
fn samples(mesh: &TriMesh) -> Vec<(DVec3, f64)> {
    let of = |t: usize| {
        let [a, b, c] = mesh.corners(t);
        let share = 0.5 * (b - a).cross(c - a).length() / 7.0;
        let middles = [(a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5, (a + b + c) / 3.0];
        [a, b, c].into_iter().chain(middles).map(move |p| (p, share))
    };
    (0..mesh.triangles.len()).flat_map(of).collect()
}

/// Returns true if sharp edges bound, by more than half of their length, flat faces wider than `width` (m): a box, a
/// prism or a cylinder with its rims, not a scan.
fn has_sharp_faces(mesh: &TriMesh, width: f64) -> bool {
    let Ok(topology) = Topology::new(mesh) else { return true };
    let angle = |[l, r]: [u32; 2]| {
        let [l, r] = [l, r].map(|t| topology.normals[t as usize]);
        l.cross(r).length().atan2(l.dot(r))
    };
    let count = mesh.triangles.len();
    let mut faces = DisjointSets::new(count);
    for edge in topology.edges.iter().filter(|e| angle(e.triangles) < COPLANAR) {
        faces.union(edge.triangles);
    }
    let mut areas = vec![0.0; count];
    let mut boxes = vec![Aabb::EMPTY; count];
    for t in 0..count {
        let (f, [a, b, c]) = (faces.find(t as u32) as usize, mesh.corners(t));
        areas[f] += 0.5 * (b - a).cross(c - a).length();
        [a, b, c].into_iter().for_each(|p| boxes[f].include(p));
    }
    let wide = |f: usize| areas[f] >= width * boxes[f].size().length();
    let (mut all, mut flat) = (0.0, 0.0);
    for edge in topology.edges.iter().filter(|e| angle(e.triangles) > SHARP_ANGLE) {
        let [a, b] = edge.ends.map(|v| mesh.vertices[v as usize]);
        let [l, r] = edge.triangles.map(|t| faces.find(t) as usize);
        all += a.distance(b);
        flat += if wide(l) || wide(r) { a.distance(b) } else { 0.0 };
    }
    flat > 0.5 * all
}
