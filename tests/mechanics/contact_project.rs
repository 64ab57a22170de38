//! Closest points on the faces of a deformed pad against an exhaustive search.

use crate::common::{Random, elements};
use glam::DVec3;
use std::sync::Arc;
use tactus::geometry::mesh::{TetMesh, grid};
use tactus::mech::body::Body;
use tactus::mech::contact::ContactSurface;
use tactus::mech::contact::face_bounds::{ClosestPoint, FaceBounds};
use tactus::mech::contact::surface::face_frame;
use tactus::mech::material::NeoHookean;

/// Returns the surface and the nodes of a slab of 3 x 3 x 1 unit cells with a fixed back, its nodes displaced at random
/// by up to `bend`.
fn slab(quadratic: bool, bend: f64, seed: u64) -> (ContactSurface, Vec<DVec3>) {
    let mut random = Random(seed);
    let lines = [0.0, 1.0, 2.0, 3.0];
    let mesh: TetMesh = grid::structured([&lines, &lines, &[0.0, 1.0]]).expect("grid");
    let (rest, elements) = elements(&mesh, quadratic);
    let fixed = rest.iter().map(|p| p.z < 1e-9).collect();
    let body = Body::new(rest, elements, fixed, Arc::new(NeoHookean::new(1.0, 0.45)), true);
    let x = body.rest.iter().map(|p| *p + random.vector() * bend).collect();
    (ContactSurface::new(&body), x)
}

/// Returns the distance of `y` from the surface: the closest lattice point of each face, refined by pattern search.
fn search(surface: &ContactSurface, x: &[DVec3], y: DVec3) -> f64 {
    let mut best = f64::INFINITY;
    for face in surface.faces.iter() {
        let at = |l: [f64; 3]| face.stencil(l).position(x).distance(y);
        let m = 12;
        let mut here = [1.0, 0.0, 0.0];
        for i in 0..=m {
            for j in 0..=m - i {
                let l = [f64::from(m - i - j), f64::from(i), f64::from(j)].map(|v| v / f64::from(m));
                if at(l) < at(here) {
                    here = l;
                }
            }
        }
        let mut step = 0.5 / f64::from(m);
        while step > 1e-9 {
            let moves = [(0, 1), (1, 0), (0, 2), (2, 0), (1, 2), (2, 1)].map(|(from, to)| {
                let mut l = here;
                let by = step.min(l[from]);
                l[from] -= by;
                l[to] += by;
                l
            });
            match moves.into_iter().min_by(|a, b| at(*a).total_cmp(&at(*b))) {
                Some(l) if at(l) < at(here) => here = l,
                _ => step *= 0.5,
            }
        }
        best = best.min(at(here));
    }
    best
}

/// Asserts that foot, gap and normal of a closest point are consistent with `y` to 1e-6.
fn consistent(surface: &ContactSurface, x: &[DVec3], y: DVec3, foot: &ClosestPoint) {
    let face = &surface.faces[foot.face];
    let (p, frame) = face_frame(face, x, foot.l);
    assert!((foot.l.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{:?}", foot.l);
    assert!((foot.normal.length() - 1.0).abs() < 1e-9, "unit normal");
    let off = (y - p - foot.normal * foot.gap).length();
    assert!(off < 1e-6, "foot + gap * normal misses the point by {off:.1e}: {foot:?}");
    assert!(foot.normal.dot(frame) > -1e-9, "the normal points out of the gel: {foot:?}, frame {frame}");
}

/// Compares distances of points at most `height` above or below the free surface, including those near the rims of
/// faces and the edges of the pad, with those of a search; returns the largest difference.
fn farthest_from_a_search(quadratic: bool, bend: f64, height: f64) -> f64 {
    let mut random = Random(9);
    let mut worst = 0.0_f64;
    for seed in 0..3 {
        let (surface, x) = slab(quadratic, bend, seed);
        let mut bounds = FaceBounds::new(1e-5);
        bounds.update(&surface, &x);
        for _ in 0..200 {
            let face = &surface.faces[(0.5 * (random.number() + 1.0) * surface.faces.len() as f64) as usize];
            let l = [0, 1, 2].map(|_| (random.number() + 0.3).max(0.0));
            let sum: f64 = l.iter().sum();
            if sum == 0.0 {
                continue;
            }
            let (p, normal) = face_frame(face, &x, l.map(|v| v / sum));
            let y = p + normal * (height * random.number());
            let truth = search(&surface, &x, y);
            let foot = bounds.closest(&surface, &x, y, height).expect("within reach");
            consistent(&surface, &x, y, &foot);
            worst = worst.max((foot.gap.abs() - truth).abs());
        }
    }
    worst
}

/// The distance is exact if the closest point is inside a curved face; on its rim the iteration stops early, with an
/// error below 1e-5.
#[test]
fn closest_points_are_those_of_a_search() {
    for (faces, quadratic, bend, height, tolerance) in [
        ("flat", false, 0.15, 0.2, 1e-7),
        ("straight quadratic", true, 0.0, 0.2, 1e-7),
        ("bent quadratic", true, 0.05, 0.1, 1e-5),
    ] {
        let worst = farthest_from_a_search(quadratic, bend, height);
        println!("{faces} faces: worst {worst:.1e}");
        assert!(worst < tolerance, "{faces} faces: distance off by {worst:.2e}");
    }
}

/// On faces curved by more than a right angle no point of the surface is more than 1e-5 closer than the returned one.
#[test]
fn nothing_is_nearer_than_the_foot_on_a_crumpled_surface() {
    let mut random = Random(4);
    for seed in 0..3 {
        let (surface, x) = slab(true, 0.45, seed);
        let mut bounds = FaceBounds::new(1e-5);
        bounds.update(&surface, &x);
        for _ in 0..200 {
            let y = DVec3::new(1.5, 1.5, 1.2) + random.vector() * DVec3::new(1.8, 1.8, 0.8);
            let foot = bounds.closest(&surface, &x, y, 10.0).expect("within reach");
            let distance = surface.faces[foot.face].stencil(foot.l).position(&x).distance(y);
            assert!((foot.gap.abs() - distance).abs() < 1e-5, "{} m, but the foot is {distance} m away", foot.gap);
            let truth = search(&surface, &x, y);
            assert!(distance < truth + 1e-5, "the foot is {distance} m away, the surface {truth} m");
        }
    }
}

/// The closest point of a point at most 1e-4 from a folded face is no farther than that face (to 1e-7), also at a
/// thousandth of the face from its rim.
#[test]
fn a_point_on_a_crumpled_surface_is_found_on_it() {
    let mut random = Random(5);
    for seed in 0..3 {
        let (surface, x) = slab(true, 0.45, seed);
        let mut bounds = FaceBounds::new(1e-5);
        bounds.update(&surface, &x);
        for k in 0..300 {
            let face = &surface.faces[k % surface.faces.len()];
            let from_rim = [1.0, 1e-2, 1e-3][k % 3];
            let l = [from_rim, 1.0, 1.0 + random.number()];
            let sum: f64 = l.iter().sum();
            let (p, normal) = face_frame(face, &x, l.map(|v| v / sum));
            let height = 1e-4 * random.number();
            let foot = bounds.closest(&surface, &x, p + normal * height, 10.0).expect("within reach");
            let (gap, height) = (foot.gap.abs(), height.abs());
            assert!(gap < height + 1e-7, "{height} m above face {}, but the foot is {gap} m away", k % 12);
        }
    }
}

#[test]
fn nothing_is_found_beyond_the_reach_and_everything_inside() {
    let (surface, x) = slab(true, 0.0, 0);
    let mut bounds = FaceBounds::new(1e-5);
    bounds.update(&surface, &x);
    let gap = |z: f64| bounds.closest(&surface, &x, DVec3::new(1.3, 1.6, z), 0.1).map(|f| f.gap);
    assert!(gap(1.1001).is_none() && gap(5.0).is_none());
    for inside in [0.099, 0.0, -0.05, -0.3] {
        let found = gap(1.0 + inside).expect("near");
        assert!((found - inside).abs() < 1e-12, "{found} against {inside}");
    }
}
