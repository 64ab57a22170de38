//! Volume, centroid and inertia of the solid inside a closed triangle mesh.

use glam::{DMat3, DVec3};

use crate::error::{Error, Result};
use crate::mesh::{TriMesh, topology};

/// Mass properties of a solid of density 1 kg/m^3; multiply volume and inertia by the density.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MassProperties {
    /// Volume, m^3 (the mass in kg at unit density).
    pub volume: f64,
    /// Centroid, m, in the frame of the mesh.
    pub centroid: DVec3,
    /// Inertia tensor about the centroid in the axes of the mesh, kg m^2 at unit density, i.e. m^5.
    pub inertia: DMat3,
}

/// Exact polyhedral integrals: the solid is a signed sum of tetrahedra over the triangles, each with the closed form of
/// its second moments. Indices must be valid.
///
/// Errors: [`Error::Mesh`] if the surface is not closed, oriented and facing outwards, saying why and where.
pub fn mass_properties(mesh: &TriMesh) -> Result<MassProperties> {
    if let Some(complaint) = topology::watertight(mesh).complaint() {
        return Err(Error::Mesh(format!(
            "no volume to integrate over: {complaint}; a closed, outward surface is needed"
        )));
    }
    let Some(origin) = mesh.vertices.first().copied() else {
        return Err(Error::Mesh("no volume to integrate over: the mesh has no vertices".into()));
    };
    let outer = |a: DVec3, b: DVec3| DMat3::from_cols(a * b.x, a * b.y, a * b.z);
    let (mut volume, mut first, mut second) = (0.0, DVec3::ZERO, DMat3::ZERO);
    for t in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(t).map(|p| p - origin);
        let det = a.cross(b).dot(c);
        let s = a + b + c;
        volume += det / 6.0;
        first += s * (det / 24.0);
        second += (outer(s, s) + outer(a, a) + outer(b, b) + outer(c, c)) * (det / 120.0);
    }
    let centre = first / volume;
    let covariance = second - outer(centre, centre) * volume;
    let trace = covariance.x_axis.x + covariance.y_axis.y + covariance.z_axis.z;
    Ok(MassProperties { volume, centroid: centre + origin, inertia: DMat3::IDENTITY * trace - covariance })
}
