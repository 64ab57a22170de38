//! Signed distances in closed form: exact, with correct gradient and curvature, and equal to those of a fine mesh.

use crate::shape_common::{Random, brute_force, families, gradient_error};
use glam::{DMat3, DVec2, DVec3};
use tactus::geometry::shape::capsule::Capsule;
use tactus::geometry::shape::cuboid::Cuboid;
use tactus::geometry::shape::cylinder::Cylinder;
use tactus::geometry::shape::ellipsoid::Ellipsoid;
use tactus::geometry::shape::plane::HalfSpace;
use tactus::geometry::shape::polygon::Profile;
use tactus::geometry::shape::revolved::Revolved;
use tactus::geometry::shape::sphere::Sphere;
use tactus::geometry::shape::{SignedDistance, SurfaceDefinition, generate};

fn all() -> Vec<Box<dyn SignedDistance>> {
    let ring = [(0.02, -0.01), (0.03, -0.01), (0.03, 0.01), (0.02, 0.01)].map(DVec2::from).to_vec();
    let cone = [(0.0, -0.02), (0.02, -0.02), (0.005, 0.01), (0.0, 0.02)].map(DVec2::from).to_vec();
    vec![
        Box::new(Sphere { radius: 0.02 }),
        Box::new(Ellipsoid { semi: DVec3::new(0.03, 0.02, 0.012) }),
        Box::new(Ellipsoid { semi: DVec3::new(0.012, 0.03, 0.012) }),
        Box::new(Cuboid { core: DVec3::new(0.02, 0.015, 0.025), radius: 0.0 }),
        Box::new(Cuboid { core: DVec3::new(0.01, 0.005, 0.015), radius: 0.01 }),
        Box::new(Cylinder { radius: 0.02, half: 0.015 }),
        Box::new(Capsule { radius: 0.012, half: 0.015 }),
        Box::new(HalfSpace::new(DVec3::new(0.01, 0.0, 0.0), DVec3::new(1.0, 2.0, -1.0)).unwrap()),
        Box::new(Revolved::new(Profile::new("ring", ring, true).unwrap())),
        Box::new(Revolved::new(Profile::new("cone", cone, false).unwrap())),
    ]
}

/// Returns random points inside and around the shapes of [`all`], whose size is about 20 mm.
fn points(count: usize) -> Vec<DVec3> {
    let mut random = Random(11);
    (0..count).map(|_| 0.045 * random.vector()).collect()
}

#[test]
fn distances_are_1_lipschitz_and_agree_with_closest() {
    for d in all() {
        for pair in points(2000).windows(2) {
            let change = (d.distance(pair[0]) - d.distance(pair[1])).abs();
            assert!(change <= pair[0].distance(pair[1]) + 1e-14, "{d:?}: {pair:?}");
            let c = d.closest(pair[0], f64::INFINITY).unwrap();
            assert!((c.distance - d.distance(pair[0])).abs() < 1e-15, "{d:?} at {}", pair[0]);
            for max in [-2e-3, 0.0, 1e-3, 1e-2] {
                assert_eq!(d.closest(pair[0], max).is_some(), c.distance < max, "{d:?} at {}, limit {max}", pair[0]);
            }
        }
    }
}

#[test]
fn gradient_is_the_slope_to_1e_6() {
    for d in all() {
        let wrong = points(1000).into_iter().filter(|&q| gradient_error(&*d, q, 1e-7) > 1e-6).collect::<Vec<_>>();
        // The distance has no gradient at its non-smooth ridges, which differences at a few points cross.
        assert!(wrong.len() <= 3, "{d:?}: {wrong:?}");
    }
}

#[test]
fn curvature_is_the_slope_of_the_gradient_to_1e_5() {
    // Smooth shapes only: at a sharp edge or a corner of a profile the curvature is zero by definition.
    for d in [0, 1, 2, 4, 6, 7].map(|i| all().swap_remove(i)) {
        let mut wrong = Vec::new();
        for q in points(1000) {
            let h = 1e-7;
            let normal = |q: DVec3| d.closest(q, f64::INFINITY).unwrap().normal;
            let c = d.closest(q, f64::INFINITY).unwrap();
            let slope = |a: DVec3| (normal(q + h * a) - normal(q - h * a)) / (2.0 * h);
            let rough = DMat3::from_cols(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z));
            let size = |m: DMat3| m.to_cols_array().iter().fold(0.0, |s: f64, x| s.max(x.abs()));
            if size(c.curvature - rough) > 1e-5 * size(rough).max(10.0) {
                wrong.push((q, size(c.curvature), size(rough)));
            }
        }
        // Near the medial axis the curvature is unbounded and finite differences are meaningless.
        wrong.retain(|(_, _, rough)| *rough < 1e3);
        assert!(wrong.len() <= 5, "{d:?}: {:?}", &wrong[..wrong.len().min(4)]);
    }
}

#[test]
fn round_sides_curve_and_flats_and_creases_do_not() {
    let c = Cylinder { radius: 0.02, half: 0.015 };
    let at = |q: DVec3| c.closest(q, 1.0).unwrap().curvature;
    let side = at(DVec3::new(0.025, 0.0, 0.001));
    assert!((side - DMat3::from_diagonal(DVec3::new(0.0, 40.0, 0.0))).abs_diff_eq(DMat3::ZERO, 1e-12));
    assert_eq!(at(DVec3::new(0.001, 0.0, 0.016)), DMat3::ZERO);
    assert_eq!(at(DVec3::new(0.021, 0.0, 0.016)), DMat3::ZERO);
    let ring = all().swap_remove(8);
    let inner = ring.closest(DVec3::new(0.016, 0.0, 0.0), 1.0).unwrap();
    assert!((inner.curvature.y_axis.y + 1.0 / 0.016).abs() < 1e-9, "the inside of a ring is concave: {inner:?}");
}

#[test]
fn the_foot_on_an_ellipsoid_is_on_it_and_the_offset_normal_to_1e_12() {
    let mut random = Random(2);
    for semi in [DVec3::new(3.0, 2.0, 1.0), DVec3::new(1.0, 1.0, 0.01), DVec3::ONE, DVec3::new(50.0, 1.0, 1.0)] {
        let d = Ellipsoid { semi };
        let mut special =
            vec![DVec3::ZERO, semi * DVec3::X, DVec3::X * 1e-9, DVec3::new(0.5, 0.0, 0.0), DVec3::Z * 1e-300];
        special.extend((0..3000).map(|_| semi * random.vector() * 2.0 * random.unit()));
        special.extend((0..300).map(|_| semi * random.vector() * DVec3::new(1.0, 1.0, 1e-12 * random.unit())));
        for q in special {
            let c = d.closest(q, f64::INFINITY).unwrap();
            let foot = q - c.distance * c.normal;
            let level = (foot / semi).length() - 1.0;
            assert!(level.abs() * semi.min_element() < 1e-12, "{semi} at {q}: {level}, {c:?}");
            let n = (foot / (semi * semi)).normalize();
            let tilt = n.distance(c.normal) * semi.min_element();
            assert!(tilt < 1e-9, "{semi} at {q}: {tilt}");
            // No point of the surface is closer.
            for _ in 0..10 {
                let other = semi * random.vector().normalize_or(DVec3::X);
                assert!(other.distance(q) >= c.distance.abs() - 1e-12, "{semi} at {q}: {other} is closer");
            }
        }
    }
}

#[test]
fn a_fine_mesh_is_as_far_to_its_sagitta() {
    let mut random = Random(3);
    for shape in families(256).into_iter().filter(|s| matches!(s.definition, SurfaceDefinition::ClosedForm)) {
        let mut worst: f64 = 0.0;
        for _ in 0..60 {
            let q = random.near_surface(&shape.surface, 5e-3);
            worst = worst.max((shape.distance.distance(q).abs() - brute_force(&shape.surface, q)).abs());
        }
        // The sagitta of a chord of 1/256 turn at a radius of 30 mm is 2.3 um, and a few times that inside a cup's rim
        // and at poles.
        assert!(worst < 1e-5, "{}: {worst} m", shape.name);
        for p in &shape.surface.vertices {
            assert!(shape.distance.distance(*p).abs() < 1e-14, "{}: vertex {p} is off its surface", shape.name);
        }
    }
}

#[test]
fn a_scaled_shape_is_the_shape_of_the_scaled_size() {
    let (big, small) = (generate::sphere(0.04, 16).unwrap(), generate::sphere(0.02, 16).unwrap().scaled(2.0).unwrap());
    for q in points(200) {
        let (a, b) = (big.distance.closest(q, 0.01), small.distance.closest(q, 0.01));
        assert_eq!(a.is_some(), b.is_some());
        if let (Some(a), Some(b)) = (a, b) {
            assert!((a.distance - b.distance).abs() < 1e-16 && a.curvature.abs_diff_eq(b.curvature, 1e-9));
        }
    }
    assert!((big.mass.volume / small.mass.volume - 1.0).abs() < 1e-14);
    assert!(small.scaled(-1.0).unwrap_err().to_string().contains("the scale is -1; it must be positive"));
}

#[test]
fn points_that_are_not_finite_do_no_harm() {
    for d in all() {
        for q in [DVec3::NAN, DVec3::INFINITY, DVec3::new(f64::NAN, 0.0, 0.0), DVec3::splat(1e200), DVec3::ZERO] {
            let _ = (d.distance(q), d.closest(q, 1.0), d.closest(q, f64::INFINITY), d.ray(q, DVec3::X), d.support(q));
        }
    }
}
