//! Outcomes of grasps: only a valid state counts as reached, a drop is not a fault, every grasp ends, and none depends
//! on a writable stderr.

use crate::common::{Press, Setup, pad_body};
use glam::DVec3;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::sync::Arc;
use tactus::backend::choose;
use tactus::geometry::pad::{Resolution, box_pad};
use tactus::geometry::shape::sphere::Sphere;
use tactus::mech::material::NeoHookean;
use tactus::mech::newton::Failure;
use tactus::mech::newton::effort::{Effort, iteration_limit};
use tactus::mech::path::Load;
use tactus::mech::path::continuation::FullPads;
use tactus::model::Model;
use tactus::model::grasp::grasp_poses;
use tactus::record::Status;
use tactus::scene::{Scene, load};
use tactus::world::run::{Outcome, run_grasps};

fn scene(text: &str) -> Scene {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scene.ron");
    std::fs::write(&path, text).unwrap();
    load(&path).unwrap_or_else(|e| panic!("{e}")).scene
}

/// Runs the first grasp of a scene.
fn run(text: &str) -> Outcome {
    let scene = scene(text);
    let model = Model::build(&scene).unwrap();
    let poses: Vec<_> = grasp_poses(&scene).unwrap().into_iter().enumerate().take(1).collect();
    run_grasps(&model, choose(&scene).unwrap().as_ref(), &poses, 2, &()).unwrap().remove(0)
}

fn tactus(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_tactus")).args(arguments).output().unwrap()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// A gel of 1 kPa under 4 N: corners of elements invert while det F at all quadrature points stays positive.
const CRUSHED: &str = "(object: (shape: Sphere(radius: 0.02)), loading: Squeeze(force: 4.0, frames: 3),
    gripper: (pads: GelSightMini(spacing: 6e-3), material: NeoHookean(young: 1e3, poisson: 0.45), opening: 0.08, friction: 0.8))";

#[test]
fn a_state_with_an_inverted_element_is_not_reached_and_says_which_element() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scene.ron");
    std::fs::write(&path, CRUSHED).unwrap();
    let output = tactus(&["run", text(&path), "--format", "json"]);
    assert_eq!(output.status.code(), Some(1), "nobody promised anything, and the run still does not end well");
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let grasp = &json["grasps"][0];
    assert_eq!(grasp["status"], "fault", "{grasp}");
    let reason = grasp["reason"].as_str().unwrap();
    assert!(reason.contains("element ") && reason.contains(" pad is inverted (det F -"), "{reason}");
    assert!(grasp["frames"].as_u64().unwrap() < 3, "the state that cannot be is not recorded: {grasp}");
    assert!(grasp["min_det_f"].as_f64().unwrap() > 0.0, "{grasp}");
}

#[test]
fn the_table_and_the_audit_mean_one_det_f() {
    let loading = "loading: Squeeze(force: 8.0, frames: 2), expect: [NoInversion]";
    let outcome = run(&format!(
        "(object: (shape: Sphere(radius: 0.015)), gripper: (pads: GelSightMini(spacing: 6e-3)), {loading})"
    ));
    let (seen, audited) = (outcome.summary.min_det_f.unwrap(), outcome.measured.findings.unwrap().min_det_f);
    assert!(0.0 < seen && seen < 0.95, "the pad is pressed hard: {seen}");
    assert!((seen - audited).abs() < 1e-12, "solver {seen}, audit {audited}");
}

/// A frictionless ellipsoid held at its end by the rims of the pads.
const SLICK: &str = "object: (shape: Ellipsoid(radii: (0.014, 0.02, 0.017)), density: 900.0),
    gripper: (pads: GelSightMini(spacing: 4e-3), friction: 0.0), grasps: List([(position: (0, 0, -0.125))]),
    loading: Squeeze(force: 6.0, frames: 3), record: (fields: [])";

#[test]
fn an_object_that_slips_out_is_dropped_wherever_it_is_told() {
    let dir = tempfile::tempdir().unwrap();
    let (path, out) = (dir.path().join("scene.ron"), dir.path().join("data"));
    let told = |scene: String| {
        std::fs::write(&path, scene).unwrap();
        let ran = tactus(&["run", text(&path), "--format", "json"]);
        let json: serde_json::Value = serde_json::from_slice(&ran.stdout).unwrap();
        let grasp = &json["grasps"][0];
        assert_eq!((ran.status.code(), &grasp["status"]), (Some(1), &"dropped".into()), "{grasp}");
        assert!(grasp["reason"].as_str().unwrap().contains("squeezed out"), "{grasp}");
        json
    };
    let promised = told(format!("({SLICK}, expect: [Dropped(contains: \"squeezed out\"), Fault(), ReachesForce])"));
    let held: Vec<_> = promised["expectations"].as_array().unwrap().iter().map(|e| e["held"].as_bool()).collect();
    assert_eq!(held, [Some(true), Some(false), Some(false)]);
    // Without expectations; condensed pads are quicker, and lose the object, too.
    let condensed = SLICK.replace("spacing: 4e-3", "spacing: 3e-3").replace("-0.125", "-0.123");
    told(format!("({condensed}, stepper: Fem(solver: Condensed()))"));
    let made = tactus(&["dataset", text(&path), "-o", text(&out), "--format", "json"]);
    let json: serde_json::Value = serde_json::from_slice(&made.stdout).unwrap();
    let object = &json["manifest"]["objects"][0];
    assert_eq!((&object["dropped"], &object["fault"]), (&1.into(), &0.into()), "{object}");
    let set = tactus::dataset::DataSet::open(&out).unwrap();
    assert_eq!(set.objects[0].status, [4], "codes 1 to 3 keep their meaning");
}

#[test]
fn the_bound_on_iterations_follows_from_the_steps() {
    assert_eq!(iteration_limit(40, 1), 2400);
    assert_eq!(iteration_limit(40, 10), 6000);
    assert_eq!(iteration_limit(10, 3), 800);
    assert_eq!(iteration_limit(u32::MAX, usize::MAX), u64::MAX, "no overflow");
}

#[test]
fn a_solver_out_of_effort_stops_where_it_was() {
    let pad = box_pad(0.016, 0.016, 4.5e-3, &Resolution::cells([4, 4, 2])).unwrap();
    let body = pad_body(&pad, true, Arc::new(NeoHookean::new(3e5, 0.45)));
    let object = Arc::new(Sphere { radius: 0.01 });
    let mut press = Press::new(Setup { body, object, start: DVec3::Z * 0.01, friction: 0.0 });
    let before = press.path.state.clone();
    press.path.newton.effort.iterations = 3;
    assert_eq!(press.path.advance(Load::Travel, 1e-3, &mut FullPads).unwrap_err(), Failure::Effort(3));
    assert_eq!((press.path.newton.profile.iterations, press.path.level), (3, 0.0));
    assert_eq!(press.path.state, before);
    press.path.newton.effort = Effort::within(Some(1e-9));
    assert_eq!(press.path.advance(Load::Travel, 1e-3, &mut FullPads).unwrap_err(), Failure::Time(1e-9));
    assert_eq!(press.path.state, before);
    press.path.newton.effort = Effort::default();
    press.path.advance(Load::Travel, 1e-4, &mut FullPads).expect("and may go on when it is given more");
}

#[test]
fn a_press_through_the_pad_is_refused() {
    let pad = "gripper: (pads: Box(size: (0.016, 0.016, 0.0045), cells: (2, 2, 1)))";
    let ball = "object: (shape: Sphere(radius: 0.005), motion: Fixed)";
    let built = Model::build(&scene(&format!("({ball}, {pad}, loading: Press(depth: 0.03, frames: 3))")));
    let Err(reason) = built else { panic!("not refused") };
    assert_eq!(reason.to_string(), "a press of 30 mm exceeds the thickness of the pad, 4.5 mm; give a smaller depth");
}

#[test]
fn what_no_pad_can_follow_ends_within_the_bound() {
    let small = "pads: Box(size: (0.016, 0.016, 0.0045), cells: (2, 2, 1)), opening: 0.08, friction: 0.8";
    for (object, gripper, loading) in [
        ("shape: Sphere(radius: 0.005), motion: Fixed", small.to_string(), "Press(depth: 0.0044, frames: 3)"),
        (
            "shape: Sphere(radius: 0.02)",
            format!("{small}, material: NeoHookean(young: 1, poisson: 0.45)"),
            "Squeeze(force: 4.0, frames: 3)",
        ),
    ] {
        let few = "stepper: Fem(max_iterations: 5)";
        let outcome = run(&format!("(object: ({object}), gripper: ({gripper}), loading: {loading}, {few})"));
        let s = &outcome.summary;
        println!("{loading}: {:?} after {} iterations, {:?}", s.status, s.newton_iterations, s.reason);
        assert!(s.newton_iterations <= iteration_limit(5, 3), "{s:?}");
        let reason = s.reason.as_deref().unwrap_or("");
        assert!(s.status == Status::Fault && reason.contains("within 400 Newton iterations"), "{s:?}");
    }
}

#[test]
fn a_limit_on_time_ends_a_grasp_as_a_fault_that_says_so() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scene.ron");
    std::fs::write(&path, format!("({SLICK})").replace("friction: 0.0", "friction: 0.8")).unwrap();
    let limited = tactus(&["run", text(&path), "--max-time", "1e-6"]);
    let table = String::from_utf8_lossy(&limited.stdout);
    assert_eq!(limited.status.code(), Some(1), "{table}");
    assert!(table.contains("fault") && table.contains("within 0.000001 s of wall time"), "{table}");
    let refused = tactus(&["run", text(&path), "--max-time", "0"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("--max-time"));
}

#[cfg(target_os = "linux")]
#[test]
fn a_stderr_that_cannot_be_written_changes_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let full = || Stdio::from(std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap());
    let run = |arguments: &[&str], stderr: Stdio| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tactus"));
        command.args(arguments).stdout(Stdio::null()).stderr(stderr).status().unwrap().code()
    };
    let (missing, path, out) = (dir.path().join("nothing.ron"), dir.path().join("s.ron"), dir.path().join("out"));
    assert_eq!(run(&["run", text(&missing)], full()), Some(2), "an error");
    assert_eq!(run(&["run"], full()), Some(2), "wrong arguments");
    // A notice that cannot be written does not prevent the work.
    let misses = "grasps: List([(position: (0, 0.2, -0.1))])";
    let scene = format!(
        "(object: (shape: Sphere(radius: 0.02)), gripper: (pads: GelSightMini(spacing: 8e-3)), {misses}, loading: Squeeze(force: 1, frames: 1))"
    );
    std::fs::write(&path, scene).unwrap();
    assert_eq!(run(&["dataset", text(&path), "-o", text(&out)], full()), Some(1), "one grasp that misses");
    assert!(out.join("manifest.json").exists());
    // A pipe whose reading end is closed.
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    assert_eq!(run(&["run", text(&missing)], Stdio::from(writer)), Some(2));
}
