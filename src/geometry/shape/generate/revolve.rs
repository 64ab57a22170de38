//! Solids of revolution.

use crate::mesh::TriMesh;
use crate::shape::params::check_segments as turn;
use crate::shape::polygon::Profile;
use crate::shape::revolved::Revolved;
use crate::shape::{MassProperties, Shape, SurfaceFeatures};
use base::error::Result;
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Builds the solid of revolution about z of a profile with the points (rho, z), m: either an open polyline from axis
/// to axis, or a loop that does not touch the axis (`closed`, first point not repeated), in either orientation. The
/// distance is that of the exact solid, not of the mesh.
///
/// # Errors
/// Fails if the number of segments is out of range or the profile is invalid, see [`Profile::new`].
pub fn revolve(name: &str, profile: Vec<DVec2>, closed: bool, segments: u32) -> Result<Shape> {
    turn(name, segments)?;
    let profile = Profile::new(name, profile, closed)?;
    let mesh = revolved_mesh(&profile, segments);
    let features = SurfaceFeatures::of_profile(&profile, segments);
    let mass = MassProperties::of_profile(&profile);
    let reach = profile.points().iter().fold(0.0, |r: f64, p| r.max(p.length()));
    Ok(Shape::closed_form(name, Revolved::new(profile), mesh, features, mass, reach))
}

/// Returns the surface of the solid, with a ring of `segments` vertices for each profile point off the axis.
pub fn revolved_mesh(profile: &Profile, segments: u32) -> TriMesh {
    let mut mesh = TriMesh::default();
    let rings: Vec<u32> = profile
        .points()
        .iter()
        .map(|p| {
            let first = mesh.vertices.len() as u32;
            let count = if p.x == 0.0 { 1 } else { segments };
            mesh.vertices.extend((0..count).map(|k| {
                let (sin, cos) = (TAU * f64::from(k) / f64::from(segments)).sin_cos();
                DVec3::new(p.x * cos, p.x * sin, p.y)
            }));
            first
        })
        .collect();
    for i in 0..profile.segments() {
        let j = (i + 1) % rings.len();
        let pole = |r: usize| profile.points()[r].x == 0.0;
        let at = |r: usize, k: u32| rings[r] + if pole(r) { 0 } else { k % segments };
        for k in 0..segments {
            let (a, b, c, d) = (at(i, k), at(i, k + 1), at(j, k + 1), at(j, k));
            if !pole(i) {
                mesh.triangles.push([a, b, if pole(j) { d } else { c }]);
            }
            if !pole(j) {
                mesh.triangles.push([a, c, d]);
            }
        }
    }
    mesh
}
