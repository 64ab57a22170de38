//! Contact vertices of objects: samples of sharp edges, corners, tips, and strongly curved surfaces.

use crate::shape_common::{families, real_meshes};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;
use tactus::geometry::shape::{FeaturePoint, Shape, generate};

/// Asserts that every sample is on the surface to 1e-12 m, that no two coincide, and that sampling is deterministic;
/// returns the samples.
fn check(shape: &Shape, spacing: f64) -> Vec<FeaturePoint> {
    let points = shape.features.sample(spacing, 1e-5);
    for p in &points {
        let d = shape.distance.distance(p.position);
        assert!(d.abs() < 1e-12, "{}: {p:?} is {d} m off the surface", shape.name);
        assert!((p.normal.length() - 1.0).abs() < 1e-12, "{}: {p:?}", shape.name);
    }
    let mut places: Vec<_> = points.iter().map(|p| p.position.to_array().map(|x| (x * 1e10).round() as i64)).collect();
    places.sort();
    assert!(places.windows(2).all(|w| w[0] != w[1]), "{}: a point occurs twice", shape.name);
    assert_eq!(points, shape.features.sample(spacing, 1e-5));
    points
}

#[test]
fn samples_are_on_the_surface_and_distinct() {
    let real = real_meshes().into_iter().map(|(name, mesh)| Shape::from_mesh(mesh).unwrap().with_name(name));
    for shape in real.chain(families(32)) {
        let points = check(&shape, 1e-3);
        assert!(shape.features.sharp_edges.iter().all(|e| e.angle > 0.34), "{}", shape.name);
        eprintln!("{}: {} points, {} sharp edges", shape.name, points.len(), shape.features.sharp_edges.len());
    }
}

#[test]
fn a_box_has_eight_corners_and_twelve_edges() {
    let shape = generate::cuboid(DVec3::new(0.04, 0.03, 0.05), 0.0, 8).unwrap();
    assert_eq!(shape.features.sharp_edges.len(), 12);
    let points = check(&shape, 0.011);
    // Edges of 40, 30, 50 mm are divided into 4, 3, 5 parts.
    assert_eq!(points.len(), 8 + 4 * (3 + 2 + 4));
    assert!(points.iter().all(|p| p.sharp));
    let corner = points.iter().find(|p| p.position.distance(DVec3::new(0.02, 0.015, 0.025)) < 1e-12).unwrap();
    assert!(corner.normal.distance(DVec3::ONE.normalize()) < 1e-12);
}

#[test]
fn rounded_edges_are_sampled_where_they_are_tight_for_the_spacing() {
    let shape = generate::cuboid(DVec3::splat(0.04), 0.002, 16).unwrap();
    assert!(shape.features.sample(1e-4, 1e-5).is_empty());
    let points = shape.features.sample(1e-3, 1e-5);
    // Edges of 36 mm are divided into 36 parts, their arcs of 3.1 mm into 4 by 3 lines.
    assert_eq!(points.len(), 12 * 37 * 3);
    for p in points {
        let surface = shape.distance.closest(p.position, 1.0).unwrap();
        assert!(!p.sharp && surface.distance.abs() < 1e-12 && surface.normal.distance(p.normal) < 1e-9);
    }
}

/// On the last 2 mm of a lemon, with a radius of curvature of about 1 mm, every mesh vertex is within 0.3 mm of a
/// sample; a sphere of radius 3 cm has no samples.
#[test]
fn tips_of_round_solids_are_sampled_where_they_are_tight_for_the_spacing() {
    let lemon = generate::lemon(0.07, 0.05, 64).unwrap();
    let points = check(&lemon, 3e-4);
    for v in lemon.surface.vertices.iter().filter(|v| v.z.abs() > 0.033) {
        let away = points.iter().map(|p| p.position.distance(*v)).fold(f64::INFINITY, f64::min);
        assert!(away < 3e-4, "{v}: {away} m");
    }
    let arc = (0..=64).map(|i| DVec2::from_angle((f64::from(i) / 64.0 - 0.5) * PI) * 0.03);
    let round = arc.enumerate().map(|(i, p)| if i % 64 == 0 { DVec2::new(0.0, p.y) } else { p }).collect();
    let ball = generate::revolve("ball", round, false, 64).unwrap();
    assert!(ball.features.sample(3e-4, 1e-5).is_empty());
}

/// On a sphere, pin and capsule of radius 1 mm every mesh vertex (except on the pin's flat ends) is within 0.11 mm of a
/// sample at a spacing of 0.5 mm, so that a pad penetrates by at most 6 um; at a tenth of the spacing their curved
/// surfaces have no samples.
#[test]
fn thin_rods_are_sampled_all_over() {
    let pin = generate::cylinder(1e-3, 0.01, 64).unwrap();
    let shapes = [generate::sphere(1e-3, 48).unwrap(), generate::capsule(1e-3, 0.01, 48).unwrap(), pin];
    for shape in shapes {
        let round = |p: &FeaturePoint| !p.sharp;
        let points = check(&shape, 5e-4);
        let flat = |v: &DVec3| shape.name == "cylinder" && v.x.hypot(v.y) < 0.999e-3;
        for v in shape.surface.vertices.iter().filter(|v| !flat(v)) {
            let away = points.iter().map(|p| p.position.distance(*v)).fold(f64::INFINITY, f64::min);
            assert!(away < 1.1e-4, "{}: {v}: {away} m", shape.name);
        }
        assert!(points.iter().any(round) && !check(&shape, 5e-5).iter().any(round), "{}", shape.name);
        let scaled = shape.scaled(10.0).unwrap();
        assert!(!check(&scaled, 5e-4).iter().any(round) && check(&scaled, 5e-3).iter().any(round));
    }
}

#[test]
fn rims_are_round_at_any_spacing() {
    let shape = generate::cylinder(0.02, 0.05, 8).unwrap();
    let points = check(&shape, 1e-3);
    assert!(points.len() > 2 * 120);
    for p in points.into_iter().filter(|p| p.sharp) {
        assert!((p.position.x.hypot(p.position.y) - 0.02).abs() < 1e-15);
        let wanted = DVec3::new(p.position.x / 0.02, p.position.y / 0.02, p.position.z.signum()).normalize();
        assert!(p.normal.distance(wanted) < 1e-12, "{p:?}");
    }
}

#[test]
fn only_convex_creases_count() {
    let cup = generate::cup(0.03, 0.06, 0.003, 16).unwrap();
    // The foot, the rim's outside and the rim's inside; not the corner between wall and floor.
    assert_eq!(cup.features.sharp_edges.len(), 3 * 16);
    let mesh = Shape::from_mesh((*cup.surface).clone()).unwrap();
    let floor = |e: &&tactus::geometry::shape::ConvexEdge| (e.a.z + 0.027).abs() < 1e-9 && (e.b.z + 0.027).abs() < 1e-9;
    assert_eq!(mesh.features.sharp_edges.iter().filter(floor).count(), 0);
}

#[test]
fn the_tip_of_a_fine_cone_is_sharp_and_a_fine_sphere_is_not() {
    let profile = [(0.0, 0.0), (0.01, 0.0), (0.0, 0.03)].map(glam::DVec2::from).to_vec();
    let cone = generate::revolve("cone", profile, false, 128).unwrap();
    let tip = |s: &Shape| s.features.vertices.iter().any(|v| v.sharp && v.position.distance(DVec3::Z * 0.03) < 1e-12);
    assert!(tip(&cone) && tip(&Shape::from_mesh((*cone.surface).clone()).unwrap()));
    let ball = Shape::from_mesh((*generate::sphere(0.02, 40).unwrap().surface).clone()).unwrap();
    assert!(ball.features.sharp_edges.is_empty() && ball.features.vertices.iter().all(|v| !v.sharp));
    assert_eq!(ball.features.vertices.len(), ball.surface.vertices.len());
}
