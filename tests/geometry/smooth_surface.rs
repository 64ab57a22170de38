//! Smooth surface of a mesh: consistent derivatives, small errors, independence of the number of triangles.

use crate::skipped::data;
use glam::{DMat3, DVec3};
use tactus::geometry::mesh::io::read_tri_mesh;
use tactus::geometry::shape::{Shape, ShapeKind, SurfaceDefinition};

/// Returns random points within `reach` (m) of the mesh of `shape`.
fn points(shape: &Shape, reach: f64) -> Vec<DVec3> {
    let mesh = &shape.surface;
    let mut seed = 1_u64;
    let mut next = move || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    let step = mesh.triangles.len().div_ceil(1000);
    let point = |t: usize| {
        let [a, b, c] = mesh.corners(t);
        let (u, v) = (next(), next());
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        let normal = (b - a).cross(c - a).normalize();
        a + (b - a) * u + (c - a) * v + normal * (2.0 * next() - 1.0) * reach
    };
    (0..mesh.triangles.len()).step_by(step).map(point).collect()
}

/// Checks that at points within 0.1 mm of the surface the normal is the gradient of the distance to 1e-6, and the
/// curvature is the gradient of the normal to 1e-3 of the inverse radius. Returns the number of points.
fn check_derivatives(shape: &Shape, radius: f64) -> usize {
    let distance = |q: DVec3| shape.distance.distance(q);
    let normal = |q: DVec3| shape.distance.closest(q, 1.0).expect("near").normal;
    let h = 1e-7;
    let all = points(shape, 1e-4);
    for &q in &all {
        let closest = shape.distance.closest(q, 1.0).expect("near");
        let slope = DVec3::AXES.map(|a| (distance(q + a * h) - distance(q - a * h)) / (2.0 * h));
        let error = DVec3::from_array(slope).distance(closest.normal);
        assert!(
            error < 1e-6,
            "{} at {q}: the distance changes by {slope:?}, the normal is {}",
            shape.name,
            closest.normal
        );
        let turn = DVec3::AXES.map(|a| (normal(q + a * h) - normal(q - a * h)) / (2.0 * h));
        let turn = DMat3::from_cols(turn[0], turn[1], turn[2]) - closest.curvature;
        let error = [turn.x_axis, turn.y_axis, turn.z_axis].map(DVec3::length).into_iter().fold(0.0, f64::max);
        assert!(error * radius < 1e-3, "{} at {q}: the curvature is off by {error} 1/m", shape.name);
    }
    all.len()
}

fn smooth(shape: &Shape) -> (f64, f64, f64) {
    match &shape.definition {
        SurfaceDefinition::Smooth(smooth) => (smooth.level.spacing(), smooth.largest, smooth.rms),
        other => panic!("{}: {other:?}", shape.name),
    }
}

#[test]
fn normals_and_curvature_are_derivatives_of_the_distance() {
    let semi_axes = DVec3::new(0.034, 0.026, 0.022);
    let potato = ShapeKind::Potato { semi_axes, roughness: 0.06, seed: 7 }.build(32).unwrap();
    let prism = ShapeKind::Prism { sides: 5, radius: 0.02, height: 0.03 }.build(8).unwrap();
    for (shape, radius) in [(potato, 1.3e-3), (prism, 1.3e-3)] {
        assert!(check_derivatives(&shape.smoothed(radius, radius).unwrap(), radius) > 15);
    }
    for name in ["lemon01", "lemon02", "strawberry01", "cucumber1"] {
        let Some(path) = data(&format!("objects/dgn/{name}/{name}_processed.stl")) else { continue };
        let shape = Shape::from_mesh(read_tri_mesh(&path).unwrap().0).unwrap().with_name(name);
        check_derivatives(&shape.smoothed(1.2e-3, 6e-4).unwrap(), 1.2e-3);
    }
}

/// The smooth surfaces of an ellipsoid meshed with 8,000 and with 70,000 triangles agree to 60 um, and with their
/// meshes to 0.1 mm.
#[test]
fn a_surface_does_not_depend_on_the_number_of_triangles() {
    let shapes = [64, 192].map(|segments| {
        let drawn = ShapeKind::Ellipsoid { semi_axes: DVec3::new(0.03, 0.022, 0.018) }.build(segments).unwrap();
        let shape = Shape::from_mesh((*drawn.surface).clone()).unwrap();
        let (shape, why) = shape.with_suitable_surface(1.2e-3, 6e-4);
        assert_eq!(why, None);
        let (radius, largest, rms) = smooth(&shape);
        assert!(radius == 1.2e-3 && largest < 1e-4 && rms <= largest, "{radius} {largest} {rms} m");
        shape
    });
    for q in points(&shapes[0], 0.0) {
        let d = shapes[1].distance.distance(q) - shapes[0].distance.distance(q);
        assert!(d.abs() < 6e-5, "{d} m at {q}");
    }
}

/// The surface is invariant under rotation of the object: distances from a rotated mesh are the same to 1e-9 m.
#[test]
fn a_surface_turns_with_its_object() {
    let semi_axes = DVec3::new(0.034, 0.026, 0.022);
    let potato = ShapeKind::Potato { semi_axes, roughness: 0.06, seed: 7 }.build(32).unwrap();
    let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.4, -1.1, 2.3);
    let mut mesh = (*potato.surface).clone();
    mesh.vertices.iter_mut().for_each(|p| *p = turn * *p);
    let turned = Shape::from_mesh(mesh).unwrap().smoothed(1.2e-3, 6e-4).unwrap();
    let smooth = potato.smoothed(1.2e-3, 6e-4).unwrap();
    for q in points(&potato, 1e-4) {
        let off = turned.distance.distance(turn * q) - smooth.distance.distance(q);
        assert!(off.abs() < 1e-9, "{off:e} m at {q}");
    }
}

/// A prism keeps its flat faces; a meshed sphere is replaced by a smooth surface within 0.1 mm.
#[test]
fn flat_faces_stay() {
    let prism = ShapeKind::Prism { sides: 6, radius: 0.02, height: 0.04 }.build(8).unwrap();
    let (shape, why) = prism.with_suitable_surface(1.2e-3, 6e-4);
    assert!(!shape.has_display_mesh() && why.is_some_and(|why| why.contains("flat faces")));
    let ball = ShapeKind::Sphere { radius: 0.02 }.build(32).unwrap();
    let ball = Shape::from_mesh((*ball.surface).clone()).unwrap();
    let (shape, _) = ball.with_suitable_surface(1.2e-3, 6e-4);
    let (_, largest, _) = smooth(&shape);
    assert!(shape.features.vertices.is_empty() && largest < 1e-4, "{largest} m");
    // Far from the surface the distance is a lower bound, accurate to the error of the surface.
    for q in [DVec3::X * 0.05, DVec3::ZERO] {
        let exact = q.length() - 0.02;
        let found = shape.distance.distance(q);
        assert!(
            found.abs() <= exact.abs() + 1e-6 && (found - exact).abs() < 3.0 * largest + 1e-4,
            "{found} m, not {exact} m"
        );
    }
}
