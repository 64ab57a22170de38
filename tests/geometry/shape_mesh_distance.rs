//! Signed distance to a mesh: the distance to its nearest triangle, negative inside.

use crate::shape_common::{Random, brute_force, families, gradient_error, real_meshes, winding};
use glam::{DMat3, DVec3};
use std::sync::Arc;
use tactus::geometry::mesh::TriMesh;
use tactus::geometry::shape::{MeshDistance, SignedDistance, generate};

fn meshes() -> Vec<(String, TriMesh)> {
    let made = families(24).into_iter().map(|s| (s.name, TriMesh::clone(&s.surface)));
    real_meshes().into_iter().chain(made).collect()
}

/// Returns random points around the mesh and near its surface, inside and outside, at distances down to nanometres.
fn points(mesh: &TriMesh, count: usize) -> Vec<DVec3> {
    let mut random = Random(1);
    let mut all: Vec<DVec3> = (0..count).map(|_| random.around(mesh)).collect();
    for reach in [1e-2, 1e-3, 1e-5, 1e-9] {
        all.extend((0..count).map(|_| random.near_surface(mesh, reach)));
    }
    all
}

#[test]
fn magnitude_is_that_of_brute_force_to_1e_12_m() {
    for (name, mesh) in meshes() {
        let d = MeshDistance::new(Arc::new(mesh.clone())).unwrap();
        for q in points(&mesh, 100) {
            let (fast, slow) = (d.distance(q), brute_force(&mesh, q));
            assert!((fast.abs() - slow).abs() < 1e-12, "{name} at {q}: {fast} against {slow} m");
        }
    }
}

#[test]
fn sign_is_that_of_the_winding_number() {
    for (name, mesh) in meshes() {
        let d = MeshDistance::new(Arc::new(mesh.clone())).unwrap();
        for q in points(&mesh, 100) {
            let distance = d.distance(q);
            // Within a nanometre of the surface the winding number has rounding errors.
            if distance.abs() > 1e-9 {
                let w = winding(&mesh, q);
                assert_eq!(distance < 0.0, w > 0.5, "{name} at {q}: {distance} m, winding number {w}");
            }
        }
    }
}

#[test]
fn it_is_1_lipschitz_and_the_gradient_is_its_slope_to_1e_6() {
    for (name, mesh) in meshes() {
        let d = MeshDistance::new(Arc::new(mesh.clone())).unwrap();
        let (all, mut smooth, mut steep) = (points(&mesh, 60), 0, 0);
        for pair in all.windows(2) {
            let change = (d.distance(pair[0]) - d.distance(pair[1])).abs();
            assert!(change <= pair[0].distance(pair[1]) + 1e-13, "{name}: {pair:?}");
        }
        for &q in &all[..180] {
            let c = d.closest(q, f64::INFINITY).unwrap();
            assert!((c.normal.length() - 1.0).abs() < 1e-9, "{name} at {q}: {}", c.normal);
            assert_eq!(c.curvature, DMat3::ZERO);
            assert_eq!(c.distance, d.distance(q));
            // The distance has no gradient on the medial axis; differences at few points cross it.
            if gradient_error(&d, q, 1e-8) < 1e-6 {
                smooth += 1;
            } else {
                steep += 1;
            }
        }
        assert!(steep <= 2, "{name}: the gradient differs at {steep} of {} points", smooth + steep);
    }
}

#[test]
fn the_limit_only_hides_what_is_beyond_it() {
    for (name, mesh) in meshes() {
        let d = MeshDistance::new(Arc::new(mesh.clone())).unwrap();
        for q in points(&mesh, 60) {
            let full = d.closest(q, f64::INFINITY).unwrap();
            for max in [-2e-3, 0.0, 1e-4, 1e-3, 1e-2] {
                let limited = d.closest(q, max);
                assert_eq!(limited.is_some(), full.distance < max, "{name} at {q}: {} m, limit {max}", full.distance);
                if let Some(c) = limited {
                    assert!((c.distance - full.distance).abs() < 1e-15 && c.normal.distance(full.normal) < 1e-6);
                }
            }
        }
    }
}

#[test]
fn on_the_surface_the_normal_is_the_pseudo_normal() {
    let d = MeshDistance::new(generate::cuboid(DVec3::splat(2.0), 0.0, 8).unwrap().surface).unwrap();
    let normal = |q: DVec3| d.closest(q, 1.0).unwrap().normal;
    assert!(normal(DVec3::ONE).distance(DVec3::ONE.normalize()) < 1e-12);
    assert!(normal(DVec3::new(1.0, 1.0, 0.3)).distance(DVec3::new(1.0, 1.0, 0.0).normalize()) < 1e-12);
    assert!(normal(DVec3::new(1.0, 0.2, 0.3)).distance(DVec3::X) < 1e-12);
}

#[test]
fn a_fine_mesh_approaches_the_sphere_by_the_square_of_its_spacing() {
    let (ball, mut last) = (generate::sphere(0.02, 8).unwrap(), f64::INFINITY);
    for segments in [10, 20, 40, 80] {
        let mesh = generate::sphere(0.02, segments).unwrap().surface;
        let d = MeshDistance::new(mesh.clone()).unwrap();
        let mut random = Random(5);
        let error = (0..500)
            .map(|_| random.near_surface(&mesh, 1e-3))
            .map(|q| (d.distance(q) - ball.distance.distance(q)).abs())
            .fold(0.0, f64::max);
        assert!(error < last / 3.0, "{segments}: {error} m after {last} m");
        last = error;
    }
    assert!(last < 3e-5, "{last} m");
}

#[test]
fn points_that_are_not_finite_do_no_harm() {
    let d = MeshDistance::new(generate::sphere(0.02, 16).unwrap().surface).unwrap();
    for q in [DVec3::NAN, DVec3::INFINITY, DVec3::new(0.0, f64::NAN, 0.0), DVec3::splat(1e200)] {
        assert!(d.closest(q, 1.0).is_none());
        let _ = (d.distance(q), d.ray(q, DVec3::X), d.ray(DVec3::ZERO, q));
    }
}
