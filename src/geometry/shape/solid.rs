//! Rigid object, with all data that the solver, the recorder and the renderer require.

use crate::Aabb;
use crate::mesh::TriMesh;
use crate::mesh::shells::{flat_shell, orient};
use crate::mesh::topology::drop_unused;
use crate::shape::mesh_distance::MeshDistance;
use crate::shape::params::{check_length, require};
use crate::shape::scaled::Scaled;
use crate::shape::topology::Topology;
use crate::shape::{Hit, MassProperties, SignedDistance, SurfaceDefinition, SurfaceFeatures};
use base::error::{Error, Result};
use glam::DVec3;
use std::sync::Arc;

/// Rigid object in its own frame. Cheap to clone.
#[derive(Debug, Clone)]
pub struct Shape {
    /// Name in messages and records.
    pub name: String,
    /// Exact signed distance to the surface.
    pub distance: Arc<dyn SignedDistance>,
    /// Surface mesh: the surface itself, or an approximation for display with vertices on the true surface.
    pub surface: Arc<TriMesh>,
    /// Contact vertices and edges.
    pub features: Arc<SurfaceFeatures>,
    /// Volume, centre of mass and inertia at unit density; closed forms for a surface in closed form, otherwise those
    /// of the mesh.
    pub mass: MassProperties,
    /// Definition of the surface.
    pub definition: SurfaceDefinition,
    /// Bounding box of the true surface, m.
    pub aabb: Aabb,
    /// Largest distance of the true surface from the frame's origin, m.
    pub bounding_radius: f64,
}

impl Shape {
    /// Builds an object with the surface `mesh`. Shells are oriented by [`orient`]; vertices that no triangle uses are
    /// dropped.
    ///
    /// # Errors
    /// Fails if the mesh is not closed, not consistently wound or has degenerate triangles, with the location of the
    /// first fault.
    pub fn from_mesh(mut mesh: TriMesh) -> Result<Self> {
        let mut topology = Topology::new(&mesh)?;
        if drop_unused(&mut mesh) | orient(&mut mesh).any() {
            topology = Topology::new(&mesh)?;
        }
        let mass = MassProperties::of_mesh(&mesh);
        let aabb = Aabb::from_points(mesh.vertices.iter().copied());
        let bounding_radius = mesh.vertices.iter().fold(0.0, |r: f64, p| r.max(p.length()));
        if let Some(message) = flat_shell(&mesh) {
            return Err(Error::Mesh(message));
        }
        let features = Arc::new(SurfaceFeatures::of_mesh(&mesh, &topology));
        let surface = Arc::new(mesh);
        let distance = Arc::new(MeshDistance::with_topology(surface.clone(), topology));
        let definition = SurfaceDefinition::Facets;
        Ok(Self { name: "mesh".into(), distance, surface, features, mass, definition, aabb, bounding_radius })
    }

    /// Builds an object with a distance in closed form, which must implement `support`.
    pub(crate) fn closed_form(
        name: &str,
        distance: impl SignedDistance + 'static,
        surface: TriMesh,
        features: SurfaceFeatures,
        mass: MassProperties,
        bounding_radius: f64,
    ) -> Self {
        let ends = DVec3::AXES.into_iter().flat_map(|a| [distance.support(a), distance.support(-a)]).flatten();
        let aabb = Aabb::from_points(ends);
        Self {
            name: name.into(),
            distance: Arc::new(distance),
            surface: Arc::new(surface),
            features: Arc::new(features),
            mass,
            definition: SurfaceDefinition::ClosedForm,
            aabb,
            bounding_radius,
        }
    }

    /// Returns the same object under another name.
    pub fn with_name(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// Returns the object scaled by `factor` about its origin.
    ///
    /// # Errors
    /// Fails if the factor is not positive and finite or the scaled size is out of range.
    pub fn scaled(&self, factor: f64) -> Result<Self> {
        require(&self.name, factor > 0.0 && factor.is_finite(), || {
            format!("the scale is {factor}; it must be positive and finite")
        })?;
        check_length(&self.name, "the scaled size", factor * self.bounding_radius)?;
        let mut surface = TriMesh::clone(&self.surface);
        surface.vertices.iter_mut().for_each(|p| *p *= factor);
        Ok(Self {
            name: self.name.clone(),
            distance: Arc::new(Scaled { inner: self.distance.clone(), factor }),
            surface: Arc::new(surface),
            features: Arc::new(self.features.scaled(factor)),
            mass: self.mass.scaled(factor),
            definition: self.definition.clone(),
            aabb: Aabb { min: factor * self.aabb.min, max: factor * self.aabb.max },
            bounding_radius: factor * self.bounding_radius,
        })
    }

    /// Returns the first entry of the ray into the object; see [`SignedDistance::ray`].
    pub fn ray(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        self.distance.ray(origin, direction)
    }

    /// Returns a surface point farthest along `direction`, m.
    pub fn support(&self, direction: DVec3) -> DVec3 {
        let of_mesh = || {
            let ahead = |a: &DVec3, b: &DVec3| a.dot(direction).total_cmp(&b.dot(direction));
            self.surface.vertices.iter().copied().max_by(ahead).unwrap_or_default()
        };
        self.distance.support(direction).unwrap_or_else(of_mesh)
    }

    /// Returns the interval that the object covers along the unit vector `direction`, m.
    pub fn extent(&self, direction: DVec3) -> (f64, f64) {
        (self.support(-direction).dot(direction), self.support(direction).dot(direction))
    }
}
