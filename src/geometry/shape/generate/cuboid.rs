//! Boxes with sharp or rounded edges.

use crate::mesh::TriMesh;
use crate::shape::cuboid::Cuboid;
use crate::shape::params::{check_length, check_segments as turn, require};
use crate::shape::topology::Topology;
use crate::shape::{MassProperties, RoundedEdge, Shape, SurfaceFeatures};
use base::error::Result;
use glam::DVec3;
use std::collections::HashMap;
use std::f64::consts::FRAC_PI_4;

/// Builds a box of the given outer size along x, y, z, m. Edges and corners are rounded with `edge_radius`, m; 0 leaves
/// them sharp.
///
/// # Errors
/// Fails if a parameter is out of range or the edge radius is too large for the box.
pub fn cuboid(size: DVec3, edge_radius: f64, segments: u32) -> Result<Shape> {
    for (axis, value) in ["x", "y", "z"].into_iter().zip(size.to_array()) {
        check_length("cuboid", &format!("size {axis}"), value)?;
    }
    turn("cuboid", segments)?;
    let half = 0.5 * size;
    let most = 0.999 * half.min_element();
    require("cuboid", edge_radius == 0.0 || (1e-6..=most).contains(&edge_radius), || {
        format!(
            "edge_radius is {edge_radius} m; it must be 0, or between 1e-6 m and less than half the smallest size ({most} m)"
        )
    })?;
    let shape = Cuboid { core: half - edge_radius, radius: edge_radius };
    let mesh = lattice(&shape, if edge_radius > 0.0 { segments.div_ceil(8) } else { 0 });
    let features = match edge_radius > 0.0 {
        true => SurfaceFeatures { rounded_edges: rounded_edges(&shape), ..SurfaceFeatures::default() },
        false => SurfaceFeatures::of_mesh(&mesh, &Topology::new(&mesh)?),
    };
    let mass = MassProperties::of_cuboid(shape.core, edge_radius);
    let reach = shape.core.length() + edge_radius;
    Ok(Shape::closed_form("cuboid", shape, mesh, features, mass, reach))
}

/// Returns the twelve edges.
fn rounded_edges(shape: &Cuboid) -> Vec<RoundedEdge> {
    let mut edges = Vec::new();
    for axis in 0..3 {
        for (u, v) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            let normals = [DVec3::AXES[(axis + 1) % 3] * u, DVec3::AXES[(axis + 2) % 3] * v];
            let ends = [-1.0, 1.0].map(|end| shape.core * (normals[0] + normals[1] + DVec3::AXES[axis] * end));
            edges.push(RoundedEdge { axis: ends, radius: shape.radius, normals });
        }
    }
    edges
}

/// Returns the surface mesh of an integer lattice on a cube whose outer `k` layers form the rounding: along each axis,
/// `k` steps rotate the normal from that of the flat face to 45 degrees, where the next face begins.
fn lattice(shape: &Cuboid, k: u32) -> TriMesh {
    let last = 2 * k + 1;
    let bend = |i: u32| {
        let t = if k == 0 { 0.0 } else { f64::from(k.saturating_sub(i).max(i.saturating_sub(k + 1))) / f64::from(k) };
        // Division into equal angles.
        let t = (t * FRAC_PI_4).tan();
        if i <= k { -t } else { t }
    };
    let place = |c: [u32; 3]| {
        let side = DVec3::from_array(c.map(|i| if i <= k { -1.0 } else { 1.0 }));
        let direction = DVec3::from_array(c.map(bend)).normalize_or_zero();
        shape.core * side + shape.radius * direction
    };
    let mut mesh = TriMesh::default();
    let mut known = HashMap::new();
    for axis in 0..3 {
        for (end, out) in [(0, false), (last, true)] {
            for i in 0..last {
                for j in 0..last {
                    let mut corner = |i: u32, j: u32| {
                        let mut c = [0; 3];
                        (c[axis], c[(axis + 1) % 3], c[(axis + 2) % 3]) = (end, i, j);
                        *known.entry(c).or_insert_with(|| {
                            mesh.vertices.push(place(c));
                            mesh.vertices.len() as u32 - 1
                        })
                    };
                    let q = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
                    let two = [[q[0], q[1], q[2]], [q[0], q[2], q[3]]];
                    mesh.triangles.extend(two.map(|t| if out { t } else { [t[0], t[2], t[1]] }));
                }
            }
        }
    }
    mesh
}
