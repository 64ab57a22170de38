//! Tubes swept along a path.

use crate::mesh::TriMesh;
use crate::shape::Shape;
use crate::shape::params::{check_segments as turn, require};
use base::error::Result;
use glam::{DQuat, DVec3};
use std::f64::consts::TAU;

const MAX_POINTS: usize = 1024;

/// Builds a tube about a path, with a radius at each of its points, m. A radius of 0 at an end gives a tip there;
/// otherwise the end is flat. The radius of curvature of the path must exceed that of the tube, and the tube must not
/// touch itself.
///
/// # Errors
/// Fails if a parameter is out of range or the tube touches itself.
pub fn sweep(name: &str, path: &[DVec3], radii: &[f64], segments: u32) -> Result<Shape> {
    turn(name, segments)?;
    check(name, path, radii)?;
    let (mesh, rings) = swept_mesh(path, radii, segments);
    for i in 0..path.len() - 1 {
        // Where adjacent rings intersect, the tube is folded.
        let ahead = path[i + 1] - path[i];
        let bad = rings[i].iter().zip(&rings[i + 1]).any(|(a, b)| (*b - *a).dot(ahead) <= 0.0);
        require(name, !bad, || format!("the path bends too sharply for the radius {} m near point {i}", radii[i]))?;
    }
    Ok(Shape::from_mesh(mesh)?.with_name(name))
}

fn check(name: &str, path: &[DVec3], radii: &[f64]) -> Result<()> {
    let n = path.len();
    require(name, (2..=MAX_POINTS).contains(&n), || {
        format!("the path has {n} points; it must have 2 to {MAX_POINTS}")
    })?;
    require(name, radii.len() == n, || format!("{} radii for {n} path points; give one for each", radii.len()))?;
    let mut along = vec![0.0; n];
    for i in 0..n {
        let fits = path[i].is_finite() && path[i].abs().max_element() < 100.0;
        require(name, fits, || format!("path point {i} is {}; it must be finite and within 100 m", path[i]))?;
        let end = i == 0 || i == n - 1;
        let fits = (1e-6..=100.0).contains(&radii[i]) || (end && n > 2 && radii[i] == 0.0);
        require(name, fits, || {
            format!(
                "radius {i} is {} m; it must be between 1e-6 and 100 m (or 0, at an end of 3 or more points)",
                radii[i]
            )
        })?;
        if i > 0 {
            let step = path[i].distance(path[i - 1]);
            require(name, step > 1e-7, || format!("path point {i} repeats the one before"))?;
            along[i] = along[i - 1] + step;
        }
    }
    for i in 0..n {
        for j in i + 1..n {
            let reach = radii[i] + radii[j];
            // Points no farther apart along the path than a half turn of the tightest possible bend are neighbours,
            // which may be close.
            let strangers = along[j] - along[i] > std::f64::consts::PI * reach;
            let apart = path[i].distance(path[j]) > reach;
            require(name, apart || !strangers, || format!("the tube touches itself at path points {i} and {j}"))?;
        }
    }
    Ok(())
}

/// Returns the tube and its rings of points. Frames are transported along the path by the smallest rotation, so they do
/// not twist.
pub fn swept_mesh(path: &[DVec3], radii: &[f64], segments: u32) -> (TriMesh, Vec<Vec<DVec3>>) {
    let n = path.len();
    let step = |i: usize| (path[i + 1] - path[i]).normalize_or(DVec3::X);
    let tangent = |i: usize| match i {
        0 => step(0),
        i if i == n - 1 => step(n - 2),
        i => (step(i - 1) + step(i)).normalize_or(step(i)),
    };
    let mut t = tangent(0);
    let mut u = t.any_orthonormal_vector();
    let mut mesh = TriMesh::default();
    let mut rings = Vec::new();
    let mut starts = Vec::new();
    for i in 0..n {
        let next = tangent(i);
        u = (DQuat::from_rotation_arc(t, next) * u)
            .reject_from_normalized(next)
            .normalize_or(next.any_orthonormal_vector());
        t = next;
        let v = t.cross(u);
        let ring: Vec<DVec3> = (0..segments)
            .map(|k| {
                let (sin, cos) = (TAU * f64::from(k) / f64::from(segments)).sin_cos();
                path[i] + radii[i] * (cos * u + sin * v)
            })
            .collect();
        starts.push(mesh.vertices.len() as u32);
        // A tip is one vertex.
        mesh.vertices.extend(&ring[..if radii[i] == 0.0 { 1 } else { segments as usize }]);
        rings.push(ring);
    }
    let at = |i: usize, k: u32| starts[i] + if radii[i] == 0.0 { 0 } else { k % segments };
    for i in 0..n - 1 {
        for k in 0..segments {
            let (a, b, c, d) = (at(i, k), at(i, k + 1), at(i + 1, k + 1), at(i + 1, k));
            if radii[i] > 0.0 {
                mesh.triangles.push([a, b, if radii[i + 1] == 0.0 { d } else { c }]);
            }
            if radii[i + 1] > 0.0 {
                mesh.triangles.push([a, c, d]);
            }
        }
    }
    for (i, turned) in [(0, true), (n - 1, false)] {
        if radii[i] > 0.0 {
            let middle = mesh.vertices.len() as u32;
            mesh.vertices.push(path[i]);
            mesh.triangles.extend((0..segments).map(|k| {
                let (a, b) = (at(i, k), at(i, k + 1));
                if turned { [middle, b, a] } else { [middle, a, b] }
            }));
        }
    }
    (mesh, rings)
}
