//! Closest points on the faces of a deformed pad against a search over all of them.

use crate::common::{Random, elements};
use glam::DVec3;
use std::sync::Arc;
use tactus::geometry::mesh::{TetMesh, grid};
use tactus::mech::body::Body;
use tactus::mech::contact::ContactSurface;
use tactus::mech::contact::project::{ClosestPoint, FaceBounds};
use tactus::mech::contact::surface::face_frame;
use tactus::mech::material::NeoHookean;

/// A slab of 3 x 3 x 1 cells with its back fixed, its nodes moved at random by up to `bend` of a cell; lengths of
/// order one.
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

/// Distance of `y` from the surface: the best of a lattice on every face, refined by pattern search.
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

/// A foot lies where it says, as far and in the direction it says.
fn consistent(surface: &ContactSurface, x: &[DVec3], y: DVec3, foot: &ClosestPoint) {
    let face = &surface.faces[foot.face];
    let (p, frame) = face_frame(face, x, foot.l);
    assert!((foot.l.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{:?}", foot.l);
    assert!((foot.normal.length() - 1.0).abs() < 1e-9, "unit normal");
    let off = (y - p - foot.normal * foot.gap).length();
    assert!(off < 1e-6, "foot + gap * normal misses the point by {off:.1e}: {foot:?}");
    assert!(foot.normal.dot(frame) > -1e-9, "the normal points out of the gel: {foot:?}, frame {frame}");
}

/// Points at a height of at most `height` over or under the free surface, faces' rims and the pad's edges included.
fn check(quadratic: bool, bend: f64, height: f64, tolerance: f64) {
    let mut random = Random(9);
    let (mut compared, mut worst) = (0, 0.0_f64);
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
            compared += 1;
        }
    }
    println!("quadratic {quadratic}, bend {bend}: {compared} points, worst {worst:.1e}");
    assert!(worst < tolerance, "distance off by {worst:.2e}");
}

#[test]
fn closest_points_of_flat_faces_are_those_of_a_search() {
    check(false, 0.15, 0.2, 1e-7);
}

#[test]
fn closest_points_of_straight_quadratic_faces_are_those_of_a_search() {
    check(true, 0.0, 0.2, 1e-7);
}

/// Where the foot lies inside a bent face the distance is exact; on its rim the search stops early, which costs little.
#[test]
fn closest_points_of_bent_faces_are_those_of_a_search() {
    check(true, 0.05, 0.1, 1e-5);
}

/// Faces bent through more than a right angle: no point of the surface is nearer than the foot, which is where it says.
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

/// A point right on a folded face is found there, also a thousandth of the face away from its rim.
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
