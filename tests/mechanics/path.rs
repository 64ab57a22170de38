//! Results do not depend on the number of frames: friction acts from first contact, and the increments are chosen by an
//! estimate of the displacement error.

use crate::keep::Keep;
use glam::DVec3;
use tactus::backend::choose;
use tactus::model::Model;
use tactus::model::grasp::grasp_poses;
use tactus::record::{Frame, Status};
use tactus::scene::load;
use tactus::world::run::run_grasps;

/// Runs the single grasp of a scene and returns its last frame and its number of Newton iterations.
fn last(text: &str) -> (Frame, u64) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ron");
    std::fs::write(&path, text).unwrap();
    let scene = load(&path).unwrap_or_else(|e| panic!("{e}")).scene;
    let model = Model::build(&scene).unwrap();
    let poses: Vec<_> = grasp_poses(&scene).unwrap().into_iter().enumerate().collect();
    let keep = Keep::default();
    let outcomes = run_grasps(&model, choose(&scene).unwrap().as_ref(), &poses, 2, &keep).unwrap();
    let summary = &outcomes[0].summary;
    assert_eq!(summary.status, Status::Reached, "{:?}", summary.reason);
    (keep.last(), summary.newton_iterations)
}

/// Norm of the difference of the displacements of all nodes, relative to the norm of those of `b`.
fn apart(a: &Frame, b: &Frame) -> f64 {
    let all = |f: &Frame| f.pads.iter().flat_map(|pad| pad.displacement.clone()).collect::<Vec<DVec3>>();
    let (a, b) = (all(a), all(b));
    let whole: f64 = b.iter().map(|u| u.length_squared()).sum();
    (a.iter().zip(&b).map(|(a, b)| a.distance_squared(*b)).sum::<f64>() / whole).sqrt()
}

/// Sphere of diameter 20 mm pressed 0.8 mm into one pad with friction 0.8.
fn press(frames: usize, more: &str) -> (Frame, u64) {
    last(&format!(
        "Scene(object: (shape: Sphere(radius: 0.01), motion: Fixed),
         gripper: (pads: GelSightMini(spacing: 2.6e-3), fingers: One, friction: 0.8),
         loading: Press(depth: 0.8e-3, frames: {frames}), {more})"
    ))
}

/// Displacement and force with one and ten frames agree with those of four hundred frames to 0.3 %. With one increment
/// per frame and sticking points anchored where an iterate first touched the object, ten frames deviate by 3.9 and
/// 2.3 %.
#[test]
#[ignore = "thorough: a press in 400 frames"]
fn a_press_is_the_same_in_one_ten_and_four_hundred_frames() {
    let (truth, _) = press(400, "");
    for frames in [1, 10] {
        let (frame, iterations) = press(frames, "");
        let (field, force) = (apart(&frame, &truth), (frame.applied_force / truth.applied_force - 1.0).abs());
        println!(
            "{frames} frames: displacement {:.3} %, force {:.3} %, {iterations} iterations",
            1e2 * field,
            1e2 * force
        );
        assert!(field < 3e-3 && force < 3e-3, "{frames} frames: displacement {field}, force {force}");
    }
}

/// Frictionless contact is path-independent: the path tolerance changes neither the force nor the number of iterations.
#[test]
fn without_friction_a_press_takes_as_many_increments_as_converge() {
    let press = |path: &str| {
        last(&format!(
            "Scene(object: (shape: Sphere(radius: 0.01), motion: Fixed),
             gripper: (pads: GelSightMini(spacing: 4e-3), fingers: One, friction: 0),
             loading: Press(depth: 0.4e-3, frames: 1), stepper: Fem(path: {path}))"
        ))
    };
    let [(loose, few), (tight, many)] = ["1", "1e-4"].map(press);
    assert_eq!((loose.applied_force, few), (tight.applied_force, many));
}

/// Displacements around a free cylinder that rotates as it is squeezed differ by at most 1 % between 5 and 40 frames;
/// by 5 to 10 % when the frames determine the increments and the force of release.
#[test]
fn a_squeeze_is_the_same_in_five_and_in_forty_frames() {
    let squeeze = |frames: usize| {
        last(&format!(
            "Scene(object: (shape: Cylinder(radius: 0.02, height: 0.06)),
             gripper: (pads: GelSightMini(spacing: 2.6e-3), material: Preset(\"gelsight_mini\"), friction: 0.8),
             grasps: List([(position: (0.0, 0.0, -0.1), rotation: RpyDeg((4.0, 8.0, 0.0)))]),
             loading: Squeeze(force: 15.0, frames: {frames}), stepper: Fem(solver: Condensed(error: 0.01)))"
        ))
        .0
    };
    let error = apart(&squeeze(5), &squeeze(40));
    println!("5 against 40 frames: displacement {:.3} %", 1e2 * error);
    assert!(error < 1e-2, "displacement {error}");
}

/// An object is fixed until its release, at the last frame at the latest, which is balanced to 1e-3 of the force.
#[test]
fn an_object_is_held_until_it_is_let_go() {
    let squeeze = |release: f64, frames: usize| {
        last(&format!(
            "Scene(object: (shape: Cuboid(size: (0.02, 0.03, 0.03), edge_radius: 0.003)),
             gripper: (pads: GelSightMini(spacing: 4e-3)), grasps: List([(position: (0.0, 0.0, -0.1), rotation: RpyDeg((0.0, 3.0, 0.0)))]),
             loading: Squeeze(force: 4.0, frames: {frames}, release: {release}))"
        ))
        .0
    };
    let (early, late) = (squeeze(0.3, 2), squeeze(4.0, 2));
    assert!(!early.object_fixed && !late.object_fixed, "let go at the last frame at the latest");
    for frame in [&early, &late] {
        assert!(frame.force_balance < 1e-3, "{}", frame.force_balance);
    }
}
