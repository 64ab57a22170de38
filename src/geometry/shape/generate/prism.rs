//! Regular prisms.

use crate::mesh::TriMesh;
use crate::shape::Shape;
use crate::shape::params::{MAX_SEGMENTS, check_length, require};
use base::error::Result;
use glam::DVec3;
use std::f64::consts::TAU;

/// Builds a prism on a regular polygon of 3 or more sides; circumradius and height in m. One corner is on the x axis.
///
/// # Errors
/// Fails if a parameter is out of range.
pub fn prism(sides: u32, radius: f64, height: f64) -> Result<Shape> {
    check_length("prism", "radius", radius)?;
    check_length("prism", "height", height)?;
    require("prism", (3..=MAX_SEGMENTS).contains(&sides), || {
        format!("sides is {sides}; it must be between 3 and {MAX_SEGMENTS}")
    })?;
    let mut mesh = TriMesh::default();
    for z in [-height / 2.0, height / 2.0] {
        mesh.vertices.extend((0..sides).map(|i| {
            let (sin, cos) = (TAU * f64::from(i) / f64::from(sides)).sin_cos();
            DVec3::new(radius * cos, radius * sin, z)
        }));
    }
    for i in 0..sides {
        let (a, b) = (i, (i + 1) % sides);
        mesh.triangles.extend([[a, b, b + sides], [a, b + sides, a + sides]]);
    }
    for i in 1..sides - 1 {
        mesh.triangles.extend([[0, i + 1, i], [sides, sides + i, sides + i + 1]]);
    }
    Ok(Shape::from_mesh(mesh)?.with_name("prism"))
}
