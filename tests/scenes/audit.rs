//! The audit detects each kind of error: a valid recorded frame is altered in one respect at a time.

use crate::common::Random;
use crate::keep::Keep;
use glam::DVec3;
use std::path::Path;
use std::sync::{Arc, LazyLock};
use tactus::backend::choose;
use tactus::mech::element::TET10;
use tactus::model::Model;
use tactus::model::evaluation::Findings;
use tactus::model::evaluation::audit::elasticity::{elastic_gradient, nodal_volume};
use tactus::model::evaluation::audit::solid::Solid;
use tactus::model::grasp::grasp_poses;
use tactus::model::part::object;
use tactus::record::{ElementNodes, Frame};
use tactus::scene::{Scene, load};
use tactus::world::run::run_grasps;

fn scene(folder: &Path, text: &str) -> Scene {
    let path = folder.join("scene.ron");
    std::fs::write(&path, text).unwrap();
    load(&path).unwrap_or_else(|e| panic!("{e}")).scene
}

/// Model and last frame, which is valid, of a ball squeezed with 4 N, shared by tests.
static SQUEEZED: LazyLock<(Arc<Model>, Frame)> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let text = "(object: (shape: Sphere(radius: 0.015)), gripper: (pads: GelSightMini(spacing: 4e-3)),
        loading: Squeeze(force: 4, frames: 1), expect: [NoInversion, NoPenetration, Converged(relative: 1e-3)])";
    let scene = scene(folder.path(), text);
    let model = Model::build(&scene).unwrap();
    let last = Keep::default();
    let poses: Vec<_> = grasp_poses(&scene).unwrap().into_iter().enumerate().collect();
    let outcomes = run_grasps(&model, choose(&scene).unwrap().as_ref(), &poses, 2, &last).unwrap();
    let frame = last.last();
    assert_eq!(outcomes[0].measured.findings, Some(judge(&model, &frame)), "what the run measured");
    (model, frame)
});

fn judge(model: &Model, frame: &Frame) -> Findings {
    model.auditor.as_ref().expect("the scene asks for it").audit(&model.fingers, frame, DVec3::ZERO)
}

#[test]
fn a_spoilt_frame_is_found_out() {
    let (model, sound) = &*SQUEEZED;
    let fine = judge(model, sound);
    println!("{fine:?}");
    assert!(fine.finite && fine.min_det_f > 0.5 && fine.penetration < 1e-5 && fine.imbalance < 1e-3, "{fine:?}");

    let mut frame = sound.clone();
    frame.pads[1].position[7].y = f64::NAN;
    assert!(!judge(model, &frame).finite, "a position that is no number");

    let mut frame = sound.clone();
    frame.object_position.x += 1e-4;
    let depth = judge(model, &frame).penetration;
    assert!((depth - 1e-4).abs() < 1.5e-5, "the ball moved 100 um into the right pad is found {depth} m deep");

    let mut frame = sound.clone();
    for (i, pad) in frame.pads.iter_mut().enumerate() {
        let closing = model.fingers[i].placement.closing;
        pad.position.iter_mut().for_each(|p| *p += closing * 0.016 + DVec3::Z * 0.03);
    }
    frame.object_position.z -= 0.05;
    let depth = judge(model, &frame).penetration;
    assert!(depth > 5e-4, "pads pushed through each other beside the ball are found {depth} m deep");

    let mut frame = sound.clone();
    let topology = &model.fingers[0].topology;
    let inner = (0..topology.corner_count).find(|&i| {
        let free = !topology.bonded[i];
        free && topology.surface.iter().flatten().all(|&s| s as usize != i)
    });
    if let Some(inner) = inner {
        frame.pads[0].position[inner].y += 1e-5;
        let imbalance = judge(model, &frame).imbalance;
        assert!(
            imbalance > 10.0 * fine.imbalance,
            "an inner node 10 um off its place leaves {imbalance} of the force over"
        );
    }
    let mut frame = sound.clone();
    frame.pads[0].wrench.force *= 1.01;
    assert!(judge(model, &frame).imbalance > 5e-3, "a contact force that the gel does not feel");
    let mut frame = sound.clone();
    frame.applied_force *= 1.01;
    assert!(judge(model, &frame).imbalance > 5e-3, "a finger force that the mount does not give");
}

/// For every law and both elements, the elastic forces of the audit (finite differences of the energy) equal those of
/// the solver to 1e-7 of the largest force, and the nodal volumes agree to 1e-20 m3.
#[test]
fn forces_of_the_audit_agree_with_those_of_the_solver() {
    for law in ["NeoHookean", "Corotational", "Linear"] {
        for element in ["Linear", "Quadratic"] {
            let folder = tempfile::tempdir().unwrap();
            let text = format!(
                "(object: (shape: Sphere(radius: 0.015)), gripper: (pads: GelSightMini(spacing: 6e-3),
                   material: {law}(young: 1e5, poisson: 0.45)), loading: Squeeze(force: 1, frames: 1), stepper: Fem(element: {element}))"
            );
            let model = Model::build(&scene(folder.path(), &text)).unwrap();
            let finger = &model.fingers[0];
            let (body, elements) = (&finger.body, &finger.topology.elements);
            // Displacement gradients of up to 0.2 that vary over a few millimetres.
            let moved = |x: &DVec3| *x + DVec3::new((1e3 * x.y).sin(), (1e3 * x.z).sin(), (1e3 * x.x).sin()) * 2e-4;
            let x: Vec<DVec3> = body.rest.iter().map(moved).collect();
            let mut solver = vec![DVec3::ZERO; x.len()];
            body.add_gradient(&x, &mut solver);
            let own = elastic_gradient(body, elements, &x);
            let largest = solver.iter().map(|f| f.length()).fold(0.0, f64::max);
            let off = own.iter().zip(&solver).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
            assert!(body.min_det_f(&x) > 0.1 && largest > 0.0, "{law}, {element}: the state is no test");
            assert!(off < 1e-7 * largest, "{law}, {element}: off by {:.1e} of the largest force", off / largest);
            let volumes = nodal_volume(body, elements).into_iter().zip(body.nodal_volume());
            let off = volumes.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 1e-20, "{law}, {element}: volumes off by {off:.1e} m3");
        }
    }
}

/// A mid-edge node beyond the quarter point of its edge inverts a corner of the element while det F at its quadrature
/// points stays positive.
#[test]
fn a_folded_corner_is_an_inversion() {
    let (model, mut frame) = SQUEEZED.clone();
    let ElementNodes::Quadratic(tets) = &model.fingers[0].topology.elements else { panic!("10-node tetrahedra") };
    let n = tets[0].map(|i| i as usize);
    let x = &mut frame.pads[0].position;
    x[n[4]] = x[n[0]] + (x[n[1]] - x[n[0]]) * 0.22;
    let body = &model.fingers[0].body;
    let x = &frame.pads[0].position;
    let (inside, felt) = (body.min_det_f_at(&TET10, x), body.min_det_f(x));
    let found = judge(&model, &frame).min_det_f;
    assert!(inside > 0.0 && found < 0.0, "quadrature points see det F {inside}, corners {found}");
    assert!((felt - found).abs() < 1e-9, "solver and audit mean one number: {felt}, {found}");
    let worst = body.most_inverted(x).expect("an element");
    assert!(tets[worst].contains(&tets[0][4]), "element {worst} has the edge");
}

/// The audit samples the object as well as the pads, and so detects the penetration of a tip between the sample points
/// of a pad.
#[test]
fn a_tip_between_the_points_of_the_pad_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let text = "(object: (shape: Revolve(profile: [(0, -0.02), (0.004, -0.02), (0, 0.02)]), motion: Fixed),
        gripper: (pads: GelSightMini(spacing: 4e-3), fingers: One), expect: [NoPenetration],
        grasps: List([(position: (-0.1, 0.0003, 0.0003), rotation: RpyDeg((0, 90, 0)))]), loading: Press(depth: 1e-4, frames: 1))";
    let scene = scene(folder.path(), text);
    let model = Model::build(&scene).unwrap();
    let last = Keep::default();
    let poses: Vec<_> = grasp_poses(&scene).unwrap().into_iter().enumerate().collect();
    run_grasps(&model, choose(&scene).unwrap().as_ref(), &poses, 1, &last).unwrap();
    let mut frame = last.last();
    assert!(judge(&model, &frame).penetration < 1e-5);
    frame.object_position.x -= 1e-4;
    let depth = judge(&model, &frame).penetration;
    assert!(depth > 5e-5, "the tip pushed 100 um into the pad is found {depth} m deep");
}

/// For every family, the depth of the audit is positive exactly where the signed distance of the contact is negative,
/// and equals its magnitude to 1e-9 m.
#[test]
fn the_solid_is_where_the_signed_distance_says() {
    let folder = tempfile::tempdir().unwrap();
    let shapes = [
        "Sphere(radius: 0.02)",
        "Ellipsoid(radii: (0.01, 0.02, 0.03))",
        "Cuboid(size: (0.02, 0.03, 0.04))",
        "Cuboid(size: (0.02, 0.03, 0.04), edge_radius: 0.004)",
        "Cylinder(radius: 0.01, height: 0.03)",
        "Capsule(radius: 0.01, height: 0.03)",
        "Prism(sides: 5, radius: 0.02, height: 0.03)",
        "Annulus(outer: 0.02, inner: 0.012, height: 0.02)",
        "Cup(radius: 0.02, height: 0.03, wall: 0.003)",
        "Lemon()",
        "Strawberry()",
        "Pear()",
        "Banana()",
        "Potato(seed: 4)",
        "Revolve(profile: [(0.01, -0.01), (0.02, 0), (0.012, 0.012)], closed: true)",
        "Sweep(path: [(0, 0, -0.02), (0.004, 0, 0), (0, 0, 0.02)], radii: [0.005, 0.008, 0])",
    ];
    let mut random = Random(5);
    for shape in shapes {
        for scale in ["1.0", "0.5"] {
            let scene = scene(
                folder.path(),
                &format!("(object: (shape: {shape}, scale: {scale}), loading: Squeeze(force: 1))"),
            );
            let built = object::build(&scene.object, &mut Vec::new()).unwrap();
            let solid = Solid::new(&scene.object, &built);
            let (center, size) = (0.5 * (built.aabb.min + built.aabb.max), built.aabb.max - built.aabb.min);
            let mut inside = 0;
            for _ in 0..3000 {
                let q = center + 0.55 * size * random.vector();
                let (depth, distance) = (solid.depth(q), built.distance.distance(q));
                if distance.abs() < 1e-9 {
                    continue;
                }
                assert_eq!(depth > 0.0, distance < 0.0, "{shape} at {q}: depth {depth}, distance {distance} m");
                // The depth inside an ellipsoid is a first-order approximation.
                if distance < 0.0 && !shape.starts_with("Ellipsoid") {
                    assert!((depth + distance).abs() < 1e-9, "{shape} at {q}: depth {depth}, distance {distance} m");
                }
                inside += usize::from(distance < 0.0);
            }
            assert!(inside > 200, "{shape}: {inside} points are inside");
        }
    }
}
