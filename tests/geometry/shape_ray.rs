//! Intersections of rays with objects.

use crate::shape_common::{Random, families, real_meshes};
use glam::DVec3;
use tactus::geometry::shape::{Shape, generate};

#[test]
fn a_ray_ends_on_the_surface_from_outside() {
    let real = real_meshes().into_iter().map(|(name, mesh)| Shape::from_mesh(mesh).unwrap().with_name(name));
    for shape in real.chain(families(32)) {
        let mut random = Random(4);
        let (mut hits, center) = (0, 0.5 * (shape.aabb.min + shape.aabb.max));
        for _ in 0..500 {
            let origin = center + 2.0 * shape.bounding_radius * random.vector().normalize_or(DVec3::X);
            let aim = center + 0.5 * (shape.aabb.max - shape.aabb.min) * random.vector();
            let Some(hit) = shape.ray(origin, 3.0 * (aim - origin)) else { continue };
            hits += 1;
            let dir = (aim - origin).normalize();
            let d = shape.distance.distance(origin + hit.t * dir);
            assert!(d.abs() < 2e-12, "{}: {d} m off the surface", shape.name);
            assert!(hit.normal.dot(dir) < 1e-6, "{}: {} along {dir}", shape.name, hit.normal);
            // The ray is outside the object before the hit.
            for i in 0..20 {
                let before = shape.distance.distance(origin + hit.t * f64::from(i) / 20.0 * dir);
                assert!(before > -1e-12, "{}: {before} m inside before the hit", shape.name);
            }
        }
        assert!(hits > 150, "{}: {hits} hits", shape.name);
    }
}

#[test]
fn a_ray_to_an_inner_point_always_enters() {
    let real = real_meshes().into_iter().map(|(name, mesh)| Shape::from_mesh(mesh).unwrap().with_name(name));
    for shape in real.chain(families(32)) {
        let mut random = Random(6);
        for _ in 0..500 {
            let target = random.near_surface(&shape.surface, 5e-3);
            let origin = target + 3.0 * shape.bounding_radius * random.vector().normalize_or(DVec3::X);
            if shape.distance.distance(target) < -1e-6 && shape.distance.distance(origin) > 0.0 {
                let hit = shape.ray(origin, target - origin);
                assert!(hit.is_some_and(|h| h.t < origin.distance(target)), "{} to {target} from {origin}", shape.name);
            }
        }
    }
}

#[test]
fn rays_through_corners_and_along_edges_do_not_slip_through() {
    let cube = Shape::from_mesh((*generate::cuboid(DVec3::splat(2.0), 0.0, 8).unwrap().surface).clone()).unwrap();
    let t = |from: DVec3, to: DVec3| cube.ray(from, to - from).map(|h| h.t);
    // At the diagonal shared by two triangles, at a corner, and at the midpoint of an edge.
    assert!((t(DVec3::new(0.3, 0.3, 5.0), DVec3::new(0.3, 0.3, 0.0)).unwrap() - 4.0).abs() < 1e-12);
    assert!((t(DVec3::splat(3.0), DVec3::ZERO).unwrap() - 2.0 * 3.0_f64.sqrt()).abs() < 1e-12);
    assert!((t(DVec3::new(3.0, 3.0, 0.0), DVec3::ZERO).unwrap() - 2.0 * 2.0_f64.sqrt()).abs() < 1e-12);
    assert!(t(DVec3::new(3.0, 3.0, 0.0), DVec3::new(0.0, 7.0, 0.0)).is_none());
}

#[test]
fn the_analytic_sphere_is_hit_to_1e_12_m_and_misses_are_misses() {
    let ball = generate::sphere(0.02, 16).unwrap();
    for offset in [0.0, 0.01, 0.0199, 0.019999999] {
        let hit = ball.ray(DVec3::new(-0.1, offset, 0.0), DVec3::X).unwrap();
        let wanted = 0.1 - (0.02_f64.powi(2) - offset * offset).sqrt();
        // At grazing incidence the rounding error of the distance is amplified.
        assert!(
            (hit.t - wanted).abs() < if offset < 0.0195 { 1e-12 } else { 1e-8 },
            "{offset}: {} against {wanted}",
            hit.t
        );
    }
    assert!(ball.ray(DVec3::new(-0.1, 0.0200001, 0.0), DVec3::X).is_none());
    assert!(ball.ray(DVec3::new(-0.1, 0.0, 0.0), DVec3::NEG_X).is_none());
    assert!(ball.ray(DVec3::ZERO, DVec3::X).is_none(), "from inside, a convex object is never entered");
    assert!(ball.ray(DVec3::ZERO, DVec3::ZERO).is_none() && ball.ray(DVec3::NAN, DVec3::X).is_none());
    let cup = generate::cup(0.03, 0.06, 0.003, 32).unwrap();
    let across = cup.ray(DVec3::new(-0.0285, 0.0, 0.0), DVec3::X).unwrap();
    assert!((across.t - (0.0285 + 0.027)).abs() < 1e-11, "from inside one wall to the other: {}", across.t);
}
