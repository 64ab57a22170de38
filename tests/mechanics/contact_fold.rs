//! Pad surface with a fold as sharp as those at knife edges and rims: the distance to the pad is continuous, and so is
//! the force on a contact vertex of the object that crosses the fold.

use crate::common::{Random, elements};
use glam::{DQuat, DVec3};
use std::sync::Arc;
use tactus::geometry::mesh::{TetMesh, grid};
use tactus::geometry::shape::{ConvexEdge, EdgeSection};
use tactus::mech::body::Body;
use tactus::mech::contact::face_bounds::FaceBounds;
use tactus::mech::contact::law::ContactLaw;
use tactus::mech::contact::{ContactSurface, ContactVertex, VertexContact};
use tactus::mech::material::NeoHookean;
use tactus::mech::potential::block::BodyBlock;
use tactus::mech::potential::state::{RigidUnknowns, State};
use tactus::mech::potential::term::{Assembly, BodyTerm};

/// Slab of 3 x 3 x 1 cells of unit length with a fixed back.
fn slab(quadratic: bool) -> Body {
    let lines = [0.0, 1.0, 2.0, 3.0];
    let mesh: TetMesh = grid::structured([&lines, &lines, &[0.0, 1.0]]).expect("grid");
    let (rest, elements) = elements(&mesh, quadratic);
    let fixed = rest.iter().map(|p| p.z < 1e-9).collect();
    Body::new(rest, elements, fixed, Arc::new(NeoHookean::new(1.0, 0.45)), true)
}

/// Returns the nodes of the slab folded along x = 1: the flanks rise by `slope` away from the fold; a ridge (negative
/// slope) is raised.
fn folded(body: &Body, slope: f64) -> Vec<DVec3> {
    let from = if slope < 0.0 { 2.0 } else { 0.0 };
    body.rest.iter().map(|p| *p + DVec3::Z * (slope * ((p.x - 1.0).abs() - from) * p.z)).collect()
}

#[test]
fn distance_to_a_folded_pad_changes_no_faster_than_the_point_moves() {
    let mut random = Random(3);
    for quadratic in [false, true] {
        let body = slab(quadratic);
        let surface = ContactSurface::new(&body);
        let spike = |p: &DVec3| if *p == DVec3::new(1.0, 1.0, 1.0) { *p + DVec3::Z * 1.5 } else { *p };
        let spiked: Vec<DVec3> = body.rest.iter().map(spike).collect();
        let mut shapes = vec![folded(&body, 1.5), folded(&body, -0.6), folded(&body, -1.5)];
        // A spike would curve quadratic faces, on which the closest point is found by iteration.
        shapes.extend((!quadratic).then_some(spiked));
        for x in shapes {
            let mut bounds = FaceBounds::new(1e-5);
            bounds.update(&surface, &x);
            let gap = |y: DVec3| bounds.closest(&surface, &x, y, 10.0).expect("everything is within reach").gap;
            for _ in 0..40 {
                // Region around the free rim and the fold, above mid-height of the side faces.
                let mut end = || DVec3::new(1.5, 1.5, 2.2) + random.vector() * DVec3::new(2.0, 2.0, 1.6);
                let (a, b) = (end(), end());
                let steps = 500;
                let step = a.distance(b) / f64::from(steps);
                let gaps: Vec<f64> = (0..=steps).map(|k| gap(a.lerp(b, f64::from(k) / f64::from(steps)))).collect();
                let jump = gaps.windows(2).map(|g| (g[1] - g[0]).abs()).fold(0.0, f64::max);
                assert!(
                    jump <= step * (1.0 + 1e-6),
                    "quadratic {quadratic}: jumps by {jump:.1e} in a step of {step:.1e}"
                );
            }
        }
    }
}

/// Returns the force (N) on the object for a contact vertex at `y` over a pad with nodes at `x`, and the energies (J)
/// with the vertex at each of `others`.
fn press(body: &Body, x: &[DVec3], y: DVec3, others: &[DVec3]) -> (DVec3, Vec<f64>) {
    let law = ContactLaw { stiffness: 1.0, offset: 0.05, friction: 0.0, tangential: 1.0 };
    let features = Arc::from([ContactVertex { position: DVec3::ZERO, sharp: true, segment: None }]);
    let mut term = VertexContact::new(law, Arc::new(ContactSurface::new(body)), features);
    let rigid = RigidUnknowns::new(vec![DVec3::Z], false, true, 1.0);
    let at = |position| State { x: vec![x.to_vec()], travel: vec![0.0], position, rotation: DQuat::IDENTITY };
    let (state, mut block) = (at(y), BodyBlock::new(body, rigid.size));
    term.assemble(body, &state.view(0, &rigid), Assembly::COMPLETE, &mut block);
    let energies = others.iter().map(|y| term.energy(body, &at(*y).view(0, &rigid))).collect();
    (-DVec3::from_slice(&block.rigid.gradient[..3]), energies)
}

/// The vertex moves at half the contact offset above the flanks; in the fold it is closer to both.
#[test]
fn force_on_a_feature_turns_gradually_from_one_flank_of_a_fold_to_the_other() {
    for quadratic in [false, true] {
        let body = slab(quadratic);
        for slope in [0.0, 0.2, 1.0] {
            let x = folded(&body, slope);
            let over = |s: f64| DVec3::new(1.0 + s, 1.53, 1.0 + slope * s.abs() + 0.025 * (1.0 + slope * slope).sqrt());
            let forces: Vec<DVec3> = (-500..=500).map(|k| press(&body, &x, over(f64::from(k) * 4e-4), &[]).0).collect();
            let (first, last) = (forces[0], forces[1000]);
            let normal = DVec3::new(slope, 0.0, 1.0).normalize();
            assert!(first.normalize().dot(normal) > 1.0 - 1e-9 || slope == 0.0, "alone on a flank: {first}");
            assert!((first.length() - last.length()).abs() < 1e-9 * first.length(), "{first} {last}");
            let jump = forces.windows(2).map(|f| f[1].distance(f[0])).fold(0.0, f64::max) / first.length();
            println!("quadratic {quadratic}, slope {slope}: {jump:.1e}");
            // Without a fold, crossing between faces does not change the force; with one the force turns over a
            // twentieth of a face.
            let most = if slope == 0.0 { 1e-9 } else { 0.06 };
            assert!(jump < most, "quadratic {quadratic}, slope {slope}: the force jumps by {jump:.1e}");
        }
    }
}

#[test]
fn force_in_a_fold_is_the_gradient_of_its_energy() {
    for quadratic in [false, true] {
        let body = slab(quadratic);
        let x = folded(&body, 0.7);
        let y = DVec3::new(1.013, 1.53, 1.028);
        for axis in DVec3::AXES {
            let h = 3e-6;
            let (force, e) = press(&body, &x, y, &[y + axis * h, y - axis * h]);
            let error = ((e[1] - e[0]) / (2.0 * h) - force.dot(axis)).abs() / force.length();
            assert!(error < 1e-7, "quadratic {quadratic}, along {axis}: off by {error:.1e}");
        }
    }
}

/// For an edge of the object across a ridge of the pad, the movable contact vertex on the edge moves to the crossing.
#[test]
fn a_feature_moves_along_its_edge_to_where_a_ridge_of_the_pad_crosses_it() {
    let body = slab(false);
    let x = folded(&body, -0.6);
    // With the smaller offset the movable vertex is initially outside the search radius.
    for offset in [1e-3, 1e-5] {
        // The ridge is at a height of 2.2.
        let height = 2.2 - 5.0 * offset;
        let (a, b) = (DVec3::new(0.9, 1.5, height), DVec3::new(1.8, 1.6, height));
        let ridge = ConvexEdge { a, b, normal: -DVec3::Z, angle: 0.2, round: false };
        let stretch = EdgeSection { edge: ridge, from: 0.0, to: 1.0 };
        let law = ContactLaw { stiffness: 1.0, offset, friction: 0.0, tangential: 1.0 };
        let surface = Arc::new(ContactSurface::new(&body));
        let mut term = VertexContact::new(law, surface, Arc::from([ContactVertex::on_segment(stretch)]));
        let rigid = RigidUnknowns::new(vec![DVec3::Z], false, true, 1.0);
        let state = State { x: vec![x.clone()], travel: vec![0.0], position: DVec3::ZERO, rotation: DQuat::IDENTITY };
        let view = state.view(0, &rigid);
        let mut block = BodyBlock::new(&body, rigid.size);
        term.assemble(&body, &view, Assembly::COMPLETE, &mut block);
        assert!(!term.enforce_constraints(&body, &view), "the edge is in the pad");
        term.assemble(&body, &view, Assembly::COMPLETE, &mut block);
        let gap = term.edge(0).gap;
        assert!(
            (gap + 5.0 * offset / f64::hypot(1.0, 0.6)).abs() < 1.2 * offset,
            "as deep as the ridge is high: {gap:.2e}"
        );
    }
}
