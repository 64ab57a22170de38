//! Distance to a surface that need not be closed.

use crate::mesh::TriMesh;
use crate::shape::winding::Winding;
use glam::DVec3;

/// Magnitude of the winding number above which a point is inside; its sign depends on the orientation of the triangles.
const INSIDE: f64 = 0.5;

/// Distance to a surface; zero inside the volume that it encloses.
#[derive(Debug)]
pub struct SurfaceDistance(Winding);

impl SurfaceDistance {
    /// Builds the distance of a mesh with at least one triangle that has an area; its indices must be valid.
    pub fn new(mesh: &TriMesh) -> Self {
        Self(Winding::new(mesh))
    }

    /// Returns the distance from `q` to the surface, m; zero inside.
    pub fn distance(&self, q: DVec3) -> f64 {
        let (squared, _) = self.0.bvh.nearest(q, (f64::INFINITY, u32::MAX));
        if self.0.at(q).abs() > INSIDE { 0.0 } else { squared.sqrt() }
    }

    /// Returns the largest extent of the surface along an axis, m.
    pub fn size(&self) -> f64 {
        self.0.bvh.bounds().size().max_element()
    }
}
