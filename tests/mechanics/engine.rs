//! Guarantees of the engine: unambiguous schedule, no unused components, bitwise reproducible results, balanced forces.

use std::sync::{Arc, LazyLock, Mutex};
use tactus::backend::choose;
use tactus::base::error::Result;
use tactus::geometry::Pose;
use tactus::model::Model;
use tactus::model::grasp::grasp_poses;
use tactus::record::{Frame, Status};
use tactus::scene::{Scene, load};
use tactus::world::Stepper;
use tactus::world::components::*;
use tactus::world::environment::Environment;
use tactus::world::run::{Observer, Outcome, run_grasps};
use tactus::world::schedule::Phase;

/// Coarse squeeze of an ellipsoid; `gripper` and `more` add fields to the gripper and the scene.
fn scene(gripper: &str, more: &str) -> Scene {
    spaced("4e-3", gripper, more)
}

/// As [`scene`], with this spacing of the pads, m.
fn spaced(spacing: &str, gripper: &str, more: &str) -> Scene {
    read(&format!(
        "(object: (shape: Ellipsoid(radii: (0.014, 0.02, 0.017)), density: 900.0),
          gripper: (pads: GelSightMini(spacing: {spacing}), {gripper}),
          loading: Squeeze(force: 6.0, frames: 3), {more})"
    ))
}

fn read(text: &str) -> Scene {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scene.ron");
    std::fs::write(&path, text).unwrap();
    load(&path).unwrap_or_else(|e| panic!("{e}")).scene
}

/// Model, backend and numbered grasps of a scene.
type Prepared = (Arc<Model>, Box<dyn Stepper>, Vec<(usize, Pose)>);

fn prepare(scene: &Scene) -> Prepared {
    let poses = grasp_poses(scene).unwrap().into_iter().enumerate().collect();
    (Model::build(scene).unwrap(), choose(scene).unwrap(), poses)
}

/// Observer that stores all frames with the index of their grasp.
#[derive(Default)]
struct Keep(Mutex<Vec<(usize, Frame)>>);

impl Observer for Keep {
    fn frame(&self, index: usize, frame: &Frame) -> Result<()> {
        self.0.lock().unwrap().push((index, frame.clone()));
        Ok(())
    }
}

fn run(scene: &Scene, threads: usize) -> Run {
    let (model, stepper, poses) = prepare(scene);
    let keep = Keep::default();
    let outcomes = run_grasps(&model, stepper.as_ref(), &poses, threads, &keep).unwrap();
    let mut frames = keep.0.into_inner().unwrap();
    frames.sort_by_key(|(grasp, frame)| (*grasp, frame.index));
    (outcomes, frames)
}

/// Hash over all bits of all frames.
fn hash(frames: &[(usize, Frame)]) -> blake3::Hash {
    blake3::hash(&serde_json::to_vec(frames).unwrap())
}

const TWO: &str =
    "grasps: List([(position: (0, 0, -0.1)), (position: (0.001, 0.002, -0.1), rotation: RpyDeg((0, 0, 80)))])";

/// Outcomes of grasps, and their frames with the number of the grasp.
type Run = (Vec<Outcome>, Vec<(usize, Frame)>);

/// Outcomes and frames of both grasps of [`TWO`] at friction 0.8 on one thread, shared by tests.
static OF_TWO: LazyLock<Run> = LazyLock::new(|| run(&scene("friction: 0.8", TWO), 1));

#[test]
fn no_two_systems_touch_the_same_data_in_no_order() {
    for more in [
        "",
        "gravity: (0, 0, 9.81)",
        "record: (fields: [])",
        "record: (fields: [Gap])",
        "object: (shape: Sphere(radius: 0.02), motion: Fixed)",
    ] {
        // The schedule does not depend on the mesh.
        let scene = if more.starts_with("object") {
            read(&format!(
                "({more}, gripper: (pads: GelSightMini(spacing: 6e-3)), loading: Press(depth: 1e-3, frames: 2))"
            ))
        } else {
            spaced("6e-3", "", more)
        };
        let (model, stepper, poses) = prepare(&scene);
        // Building fails on any ambiguity of the schedule, stepping on any missing resource.
        let mut environment = Environment::new(&model, stepper.as_ref(), poses[0].1).unwrap();
        let mut phases = Vec::new();
        while !environment.phase().is_final() {
            phases.push(environment.phase());
            environment.step();
        }
        assert_eq!(environment.phase(), Phase::Done, "{more}");
        assert_eq!(&phases[..3], &[Phase::Place, Phase::Close, Phase::Ramp { frame: 0 }], "{more}");
        assert_eq!(phases.len(), 2 + model.levels.len());
        environment.step();
        assert_eq!(environment.phase(), Phase::Done, "a step after the end changes nothing");
    }
}

#[test]
fn what_nobody_asks_for_is_not_there() {
    let count = |scene: &Scene| {
        let (model, stepper, poses) = prepare(scene);
        let environment = Environment::new(&model, stepper.as_ref(), poses[0].1).unwrap();
        let systems: usize = environment.systems().iter().map(|(_, names)| names.len()).sum();
        (environment.components(), systems, model.unknowns().total)
    };
    let (full, full_systems, full_unknowns) = count(&scene("friction: 0.8", "gravity: (0, 0, 9.81)"));
    for name in ["NodalStress", "TetStress", "ContactForce", "ContactFriction", "ObjectWeight"] {
        assert!(full.contains_key(name), "{name} is there if asked for");
    }
    let (light, _, _) = count(&scene("friction: 0.8", ""));
    assert!(!light.contains_key("ObjectWeight"), "no weight without gravity");
    let (slick, slick_systems, _) = count(&scene("friction: 0.0", ""));
    assert!(
        !slick.contains_key("ContactFriction") && slick_systems < full_systems,
        "no friction state without friction"
    );
    let (bare, bare_systems, _) = count(&scene("friction: 0.0", "record: (fields: [])"));
    assert!(["NodalStress", "TetStress", "ContactForce"].iter().all(|n| !bare.contains_key(*n)));
    assert!(bare_systems < slick_systems && bare.len() < slick.len());
    let (gaps, _, _) = count(&scene("friction: 0.0", "record: (fields: [Gap])"));
    assert!(gaps.contains_key("NodeGap") && !full.contains_key("NodeGap"));
    let (expected, _, _) = count(&scene("friction: 0.0", "record: (fields: []), expect: [MaxStress(at_most: 1e6)]"));
    assert!(expected.contains_key("NodalStress"), "a bound on the stress needs the stress");
    let mut fixed = scene("", "");
    fixed.object.motion = tactus::scene::ObjectMotion::Fixed;
    assert_eq!(count(&fixed).2 + 5, full_unknowns, "a fixed object has no pose; its fingers are not geared");
}

#[test]
fn every_word_that_a_scene_leaves_out_makes_it_strictly_smaller() {
    let count = |scene: &Scene| {
        let (model, stepper, poses) = prepare(scene);
        let environment = Environment::new(&model, stepper.as_ref(), poses[0].1).unwrap();
        let systems: usize = environment.systems().iter().map(|(_, names)| names.len()).sum();
        (systems, environment.components().values().sum::<usize>(), model.unknowns().total)
    };
    let weight = "gravity: (0, 0, 9.81)";
    let full = count(&scene("friction: 0.8", weight));
    let mut fixed = scene("friction: 0.8", weight);
    fixed.object.motion = tactus::scene::ObjectMotion::Fixed;
    let silent = scene("friction: 0.8", &format!("{weight}, record: (fields: [])"));
    // Only the object's pose has unknowns: six, minus one because fingers that hold a free object share one travel.
    for (left_out, scene, unknowns) in [
        ("gravity", scene("friction: 0.8", ""), 0),
        ("friction", scene("friction: 0.0", weight), 0),
        ("free object", fixed, 5),
        ("recording", silent, 0),
    ] {
        let less = count(&scene);
        assert!(less.0 < full.0, "without {left_out}: {} systems, {} with it", less.0, full.0);
        assert!(less.1 < full.1, "without {left_out}: {} components, {} with it", less.1, full.1);
        assert_eq!(less.2 + unknowns, full.2, "unknowns without {left_out}");
    }
    let mut least = scene("friction: 0.0", "record: (fields: [])");
    least.object.motion = tactus::scene::ObjectMotion::Fixed;
    assert!(count(&least).0 + 4 <= full.0, "each of them takes its own systems with it");
}

/// Whole pads of two grasps: a repetition, a grasp per thread, and threads shared by the pads of a grasp. One grasp of
/// condensed pads and one in motion with ground: one and two threads.
#[test]
fn frames_are_the_same_bits_on_any_number_of_threads() {
    let condensed = "(object: (shape: Ellipsoid(radii: (0.014, 0.02, 0.017)), density: 900.0),
        gripper: (pads: GelSightMini(spacing: 3e-3), friction: 0.8),
        loading: Squeeze(force: 6.0, frames: 3), stepper: Fem(solver: Condensed()))";
    let moving = "(object: (shape: Cuboid(size: (0.03, 0.03, 0.04)), density: 2000.0),
        grasps: List([(position: (0, 0, 0.1), rotation: RpyDeg((180, 0, 0)))]),
        gripper: (pads: GelSightMini(spacing: 8e-3), friction: 0.8), stepper: Fem(element: Linear),
        gravity: (0, 0, -9.81), ground: Plane(),
        loading: Dynamic(motions: [Close(force: 4.0, duration: 0.02), Lift(height: 0.01, duration: 0.05)],
                         time_step: 2e-3, frames: 3))";
    let (outcomes, two) = &*OF_TWO;
    assert!(outcomes.iter().all(|o| o.summary.status == Status::Reached), "{:?}", outcomes[0].summary);
    assert_eq!(two.len(), 6);
    let (condensed, moving) = (read(condensed), read(moving));
    for (name, scene, one, threads) in [
        ("whole pads", scene("friction: 0.8", TWO), hash(two), &[1, 2, 3][..]),
        ("condensed pads", condensed.clone(), hash(&run(&condensed, 1).1), &[2]),
        ("motion in time", moving.clone(), hash(&run(&moving, 1).1), &[2]),
    ] {
        for threads in threads {
            assert_eq!(hash(&run(&scene, *threads).1), one, "{name} on {threads} threads");
        }
    }
}

#[test]
fn forces_and_torques_on_a_free_object_cancel_in_every_frame() {
    let weight = |gravity: &str| run(&scene("friction: 0.8", gravity), 2).1;
    let [along, across] = ["gravity: (0, 0, 2.0)", "gravity: (2.0, 0, 0)"];
    for (more, frames) in [(TWO, &OF_TWO.1), (along, &weight(along)), (across, &weight(across))] {
        for (grasp, frame) in frames {
            let name = format!("{more} grasp {grasp} frame {}", frame.index);
            assert!(frame.force_balance <= 1e-3, "{name}: force balance {:e}", frame.force_balance);
            assert!(frame.torque_balance <= 1e-3, "{name}: torque balance {:e}", frame.torque_balance);
            assert!(frame.min_gap > 0.0 && frame.min_det_f > 0.0, "{name}");
            assert!((frame.applied_force - 2.0 * (frame.index + 1) as f64).abs() < 1e-12, "{name}: exact levels");
            for pad in &frame.pads {
                let nodal: glam::DVec3 = pad.contact_force.iter().sum();
                assert!((nodal - pad.wrench.force).length() < 1e-9, "{name}: nodal forces sum to the wrench");
            }
        }
    }
}

#[test]
fn fingers_that_meet_nothing_or_start_inside_are_refused_by_name() {
    let reason = |gripper: &str, more: &str| {
        let outcome = run(&scene(gripper, more), 1).0.remove(0).summary;
        assert_eq!((outcome.status, outcome.frames), (Status::Infeasible, 0));
        outcome.reason.unwrap()
    };
    let far = reason("", "grasps: List([(position: (0, 0.2, -0.1))])");
    assert!(far.contains("left finger does not touch the object within its stroke of 40.0 mm"), "{far}");
    assert!(far.contains("the object is 180.0 mm from the point midway between the pads"), "{far}");
    // A rotation about the hand moves the pads off the object; a rotation about the object's centre does not.
    let swung = reason("", "grasps: List([(position: (0, 0, -0.1), rotation: RpyDeg((0, 60, 0)))])");
    assert!(swung.contains("does not touch the object") && swung.contains("`centre` of a pose"), "{swung}");
    let inside = reason("opening: 0.02", "");
    assert!(inside.contains("left pad overlaps the object by") && inside.contains("increase `opening`"), "{inside}");
    let heavy = reason("", "gravity: (981, 0, 0)");
    assert!(heavy.contains("gravity acts on the object"), "{heavy}");
}

#[test]
fn a_fault_keeps_the_last_accepted_state() {
    let mut scene = scene("friction: 0.8", "stepper: Fem(max_iterations: 1)");
    scene.record.pictures = false;
    let (model, stepper, poses) = prepare(&scene);
    let mut environment = Environment::new(&model, stepper.as_ref(), poses[0].1).unwrap();
    while !environment.phase().is_final() {
        environment.step();
    }
    let Phase::Fault { reason } = environment.phase() else { panic!("{:?}", environment.phase()) };
    assert!(reason.contains("no equilibrium within 80 Newton iterations, the limit for a grasp"), "{reason}");
    let world = environment.world_mut();
    let mut nodes = world.query::<&Position>();
    assert!(nodes.iter(world).all(|p| p.0.is_finite()));
}

#[test]
fn a_press_balances_contact_against_the_reaction_of_the_mount() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("press.ron");
    let text = "(object: (shape: Sphere(radius: 7.5e-3), motion: Fixed),
        gripper: (pads: GelSightMini(spacing: 4e-3), fingers: One),
        loading: Press(depth: 1e-3, frames: 2), record: (fields: [Gap]), gravity: (9.81, 0, 0))";
    std::fs::write(&path, text).unwrap();
    let (outcomes, frames) = run(&load(&path).unwrap_or_else(|e| panic!("{e}")).scene, 1);
    assert_eq!(outcomes[0].summary.status, Status::Reached);
    assert!((frames[1].1.travel[0] - 1e-3).abs() < 1e-12, "the depth is met exactly");
    for (_, frame) in frames {
        assert!(frame.applied_force > 0.1, "{} N", frame.applied_force);
        assert!(frame.force_balance > 0.0 && frame.force_balance <= 1e-3, "{:e}", frame.force_balance);
        let gap = &frame.pads[0].gap;
        let nearest = gap.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(nearest > 0.0 && nearest < 1e-4, "the nearest node is {nearest} m away");
    }
}

/// Coulomb limit: two pads that press with 4 N each carry at most 2 N at friction 0.25. A weight of 1.99 N is held,
/// 2.01 N is dropped.
#[test]
fn a_weight_just_beyond_friction_drops_and_one_just_below_is_held() {
    for (weight, expected) in [(1.99, Status::Reached), (2.01, Status::Dropped)] {
        let density = weight / (9.81 * 0.03_f64.powi(3));
        let text = format!(
            "(object: (shape: Cuboid(size: (0.03, 0.03, 0.03)), density: {density}),
              gripper: (pads: GelSightMini(spacing: 8e-3), friction: 0.25), gravity: (0, 0, -9.81),
              loading: Squeeze(force: 8.0, release: 8.0, frames: 2), stepper: Fem(element: Linear))"
        );
        let summary = run(&read(&text), 1).0.remove(0).summary;
        assert_eq!(summary.status, expected, "{weight} N: {:?}", summary.reason);
    }
}
