//! Definition of the surface of a shape: a closed form, the facets of a mesh, or a smooth surface near them.

use crate::shape::level_set::LevelSet;
use std::sync::Arc;

/// How a shape defines its surface.
#[derive(Debug, Clone)]
pub enum SurfaceDefinition {
    /// A distance in closed form; the mesh is for display, with vertices on the true surface.
    ClosedForm,
    /// The facets of the mesh.
    Facets,
    /// A smooth surface near the facets; the mesh is for display, with vertices on it.
    Smooth(SmoothSurface),
}

/// Smooth surface, and its distance from the mesh that it approximates.
#[derive(Debug, Clone)]
pub struct SmoothSurface {
    /// The surface.
    pub level: Arc<LevelSet>,
    /// Largest distance of the mesh's vertices, edge midpoints and triangle centroids from the surface, m.
    pub largest: f64,
    /// Area-weighted root mean square of these distances, m.
    pub rms: f64,
}
