//! Contact of a point with a mesh: one closest point at flat faces and convex edges, all flanks at concave edges.

use glam::DVec3;
use std::sync::Arc;
use tactus::geometry::mesh::TriMesh;
use tactus::geometry::shape::{MeshDistance, SignedDistance};

/// Distance within which the surface is active, m.
const FELT: f64 = 0.3;

/// L-shaped prism of size 2 x 2 x 1 with its concave edge at (1, 1).
fn bracket() -> MeshDistance {
    let outline = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)];
    let mut mesh = TriMesh::default();
    for z in [0.0, 1.0] {
        mesh.vertices.extend(outline.map(|(x, y)| DVec3::new(x, y, z)));
    }
    for [a, b, c] in [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]] {
        mesh.triangles.extend([[a, c, b], [a + 6, b + 6, c + 6]]);
    }
    for i in 0..6 {
        let j = (i + 1) % 6;
        mesh.triangles.extend([[i, j, j + 6], [i, j + 6, i + 6]]);
    }
    MeshDistance::new(Arc::new(mesh)).expect("a solid")
}

/// Returns the energy of a point at `q` with a quadratic potential within [`FELT`] of the surface.
fn energy(object: &MeshDistance, q: DVec3) -> f64 {
    let push = |d: f64| (FELT - d).max(0.0).powi(2);
    object.contact_points(q, FELT, FELT).map_or(0.0, |touch| touch.sum(|c| push(c.distance)))
}

#[test]
fn flat_ground_and_ridges_are_touched_once() {
    let object = bracket();
    let mut compared = 0;
    for i in 0..40_000 {
        let f = |k: u32| (f64::from(i) * [0.754_877_666, 0.569_840_291, 0.430_159_709][k as usize]).fract();
        let q = DVec3::new(2.8 * f(0) - 0.4, 2.8 * f(1) - 0.4, 1.8 * f(2) - 0.4);
        // Outside the object and away from the concave edge. (Inside, the nearest face alone is active as well, but it
        // has a kink.)
        let distance = object.distance(q);
        if q.x > 1.0 && q.y > 1.0 && q.x < 1.0 + FELT && q.y < 1.0 + FELT || !(0.0..FELT).contains(&distance) {
            continue;
        }
        let alone = (FELT - distance).powi(2);
        let sum = energy(&object, q);
        assert!((sum - alone).abs() < 1e-12, "{q}: {sum} against {alone}");
        compared += 1;
    }
    assert!(compared > 2000, "{compared}");
}

#[test]
fn both_flanks_of_a_valley_are_touched_and_where_they_meet_is_not_counted_twice() {
    let object = bracket();
    let push = |d: f64| (FELT - d).max(0.0).powi(2);
    for (a, b) in [(0.1, 0.05), (0.02, 0.2), (0.1, 0.1), (0.29, 0.01)] {
        for z in [0.5, 0.31, 0.77] {
            let sum = energy(&object, DVec3::new(1.0 + a, 1.0 + b, z));
            let wanted = push(a) + push(b) - push(f64::hypot(a, b));
            assert!((sum - wanted).abs() < 1e-12, "{a} {b}: {sum} against {wanted}");
        }
    }
}

/// Along paths over the concave edge, flat faces and convex edges, the gradient of the energy changes by at most 40
/// times the step.
#[test]
fn the_push_of_a_surface_has_no_jumps_outside_it() {
    let object = bracket();
    let h = 1e-6;
    let gradient = |q: DVec3| {
        DVec3::from_array(DVec3::AXES.map(|a| (energy(&object, q + a * h) - energy(&object, q - a * h)) / (2.0 * h)))
    };
    let paths = [
        (DVec3::new(1.02, 1.9, 0.4), DVec3::new(1.3, 1.02, 0.6)),
        (DVec3::new(1.25, 1.05, 1.2), DVec3::new(1.05, 1.25, 0.9)),
        (DVec3::new(-0.1, 1.5, 0.5), DVec3::new(-0.02, 2.1, 1.1)),
    ];
    for (from, to) in paths {
        let steps = 4000;
        let step = from.distance(to) / f64::from(steps);
        let pushes: Vec<DVec3> =
            (0..=steps).map(|k| gradient(from.lerp(to, f64::from(k) / f64::from(steps)))).collect();
        let jump = pushes.windows(2).map(|p| p[1].distance(p[0])).fold(0.0, f64::max);
        // Bound of the Hessian: three terms with second derivative two, and at edges the force over the distance.
        assert!(jump < 40.0 * step, "{from} to {to}: {jump:.1e} in a step of {step:.1e}");
    }
}
