//! `tactus run`, `check` and `predict` on the command line: exit codes, JSON, files, and the files of a killed run.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tactus"));
    command.args(arguments).current_dir(env!("CARGO_MANIFEST_DIR"));
    command
}

fn tactus(arguments: &[&str]) -> Output {
    command(arguments).output().unwrap()
}

fn both(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

fn write(dir: &Path, frames: usize, more: &str) -> PathBuf {
    let path = dir.join("scene.ron");
    let text = format!(
        "(object: (shape: Sphere(radius: 0.02)), gripper: (pads: GelSightMini(spacing: 4e-3)),
          loading: Squeeze(force: 6.0, frames: {frames}), record: (pictures: false), {more})"
    );
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn exit_codes_say_whether_expectations_held() {
    let dir = tempfile::tempdir().unwrap();
    let code = |more: &str| {
        let scene = write(dir.path(), 2, more);
        tactus(&["run", scene.to_str().unwrap()]).status.code()
    };
    assert_eq!(code("expect: [ReachesForce, NoPenetration]"), Some(0));
    assert_eq!(code(""), Some(0), "no expectation: all grasps reached");
    assert_eq!(code("expect: [Travel(at_most: 1e-6)]"), Some(1));
    assert_eq!(code("grasps: List([(position: (0, 0.2, -0.1))])"), Some(1), "no expectation, and a grasp that misses");
    assert_eq!(
        code(
            "grasps: List([(position: (0, 0.2, -0.1))]), expect: [Infeasible(contains: \"does not touch the object\")]"
        ),
        Some(0)
    );
    assert_eq!(code("stepper: Gnn(model: \"m\")"), Some(2));
}

#[test]
fn options_replace_what_the_scene_says() {
    let dir = tempfile::tempdir().unwrap();
    let scene = write(dir.path(), 4, "");
    let run = |options: &[&str]| tactus(&[&["run", scene.to_str().unwrap(), "--format", "json"], options].concat());
    let json = |options: &[&str]| serde_json::from_slice::<Value>(&run(options).stdout).unwrap();
    let changed = json(&["--force", "3", "--frames", "2", "--backend", "condensed"]);
    let grasp = &changed["grasps"][0];
    assert!((grasp["force_n"].as_f64().unwrap() - 3.0).abs() < 1e-9, "N, of {grasp}");
    assert_eq!((grasp["frames"].as_u64(), &changed["scene"]["loading"]["Squeeze"]["frames"]), (Some(2), &2.into()));
    assert!(changed["backend"].as_str().unwrap().contains("condensed"), "{}", changed["backend"]);
    let unchecked = |json: &Value| json["notices"].to_string().contains("after its release");
    assert!(unchecked(&changed), "condensed pads of a free object: {}", changed["notices"]);
    assert!(!unchecked(&json(&["--force", "3", "--frames", "1"])), "whole pads");
    let network = json(&["--backend", "gnn", "--frames", "1", "--extrapolate"]);
    assert_eq!(network["scene"]["stepper"]["Gnn"]["model"], "universe", "the one that ships");
    let refused = |options: &[&str], reason: &str| {
        let out = run(options);
        let said = String::from_utf8_lossy(&out.stderr);
        assert!(out.status.code() == Some(2) && said.contains(reason), "{said}");
    };
    refused(&["--force", "0"], "error: --force must be above zero");
    refused(&["--backend", "fem", "--model", "universe"], "--model is allowed only for a network; add --backend gnn");
    refused(&["--extrapolate"], "--error-at-most and --extrapolate are allowed only for a network");
    refused(&["--grasp", "1"], "--grasp 1: the scene has 1 grasp, 0 to 0");
    let press = tactus(&["run", "scenes/press_sphere.ron", "--force", "3"]);
    assert!(String::from_utf8_lossy(&press.stderr).contains("--force is allowed only for a squeeze"));
}

#[test]
fn json_has_the_documented_keys_and_earlier_runs_are_overwritten_if_asked_and_then_completely() {
    let dir = tempfile::tempdir().unwrap();
    let scene = write(dir.path(), 2, "expect: [ReachesForce]");
    let (scene, out) = (scene.to_str().unwrap(), dir.path().join("out"));
    let arguments = ["run", scene, "-o", out.to_str().unwrap(), "--format", "json"];
    let run = tactus(&arguments);
    assert_eq!(run.status.code(), Some(0), "{}", String::from_utf8_lossy(&run.stderr));
    let json: Value = serde_json::from_slice(&run.stdout).unwrap();
    assert!(json["backend"].as_str().unwrap().starts_with("fem"));
    let grasp = &json["grasps"][0];
    for key in "force_n travel_m frames min_det_f min_gap_m force_balance newton_iterations wall_s".split(' ') {
        assert!(grasp[key].is_number(), "{key}");
    }
    assert_eq!((grasp["status"].as_str(), grasp["frames"].as_u64()), (Some("reached"), Some(2)));
    assert!(grasp.get("reason").is_some_and(Value::is_null) && json["finished"] == true, "{json}");
    assert_eq!(json["expectations"][0]["name"], "ReachesForce");
    assert_eq!(json["expectations"][0]["held"], true);
    let written: Value = serde_json::from_slice(&std::fs::read(out.join("run.json")).unwrap()).unwrap();
    assert_eq!(written, json, "run.json is what is printed");
    for file in ["frames.csv", "run.pvd", "arrays.npz", "frames/frame_0001.vtu"] {
        assert!(out.join("grasp_000").join(file).exists(), "{file}");
    }
    let again = tactus(&arguments);
    assert_eq!(again.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&again.stderr).contains("earlier run"));
    // Overwritten completely, except for what is not of a run.
    std::fs::write(out.join("grasp_000/stale"), "").unwrap();
    std::fs::write(out.join("grasp_notes"), "mine").unwrap();
    let mut arguments = arguments.to_vec();
    arguments.push("--overwrite");
    assert_eq!(tactus(&arguments).status.code(), Some(0));
    assert!(!out.join("grasp_000/stale").exists() && out.join("grasp_notes").exists());
}

#[test]
fn a_killed_run_leaves_readable_files() {
    let dir = tempfile::tempdir().unwrap();
    let scene = write(dir.path(), 2000, "");
    let out = dir.path().join("out");
    let mut child = command(&["run", scene.to_str().unwrap(), "-o", out.to_str().unwrap()])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let csv = out.join("grasp_000/frames.csv");
    let rows = || std::fs::read_to_string(&csv).map_or(0, |text| text.lines().count());
    let clock = Instant::now();
    while rows() < 4 && clock.elapsed() < Duration::from_secs(120) {
        std::thread::sleep(Duration::from_millis(20));
    }
    // SIGKILL, so the process cannot clean up.
    child.kill().unwrap();
    child.wait().unwrap();
    let run: Value = serde_json::from_slice(&std::fs::read(out.join("run.json")).unwrap()).unwrap();
    assert_eq!(run["finished"], false);
    let text = std::fs::read_to_string(&csv).unwrap();
    let columns = text.lines().next().unwrap().split(',').count();
    assert!(text.lines().count() >= 4 && text.ends_with('\n'));
    assert!(text.lines().all(|line| line.split(',').count() == columns), "whole rows only");
}

#[test]
fn check_says_what_will_run() {
    let out = tactus(&["check", "scenes/quickstart.ron"]);
    assert_eq!(out.status.code(), Some(0));
    let text = String::from_utf8(out.stdout).unwrap();
    let complete = "mean_dilatation: true";
    for part in [
        complete,
        "worst",
        "in tetrahedron",
        "unknowns:",
        "watertight",
        "1 of 1 grasps",
        "of processor time for 1 grasp",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let verbose = String::from_utf8(tactus(&["check", "scenes/quickstart.ron", "-v"]).stdout).unwrap();
    for part in ["fem::systems::advance_level", "components: "] {
        assert!(verbose.contains(part) && !text.contains(part), "{part}: {text}");
    }
    let dir = tempfile::tempdir().unwrap();
    let copy = dir.path().join("copy.ron");
    std::fs::write(&copy, &text).unwrap();
    tactus::scene::load(&copy).unwrap_or_else(|e| panic!("what check prints is a scene: {e}"));

    let out = tactus(&["check", "scenes/quickstart.ron", "--format", "json"]);
    let json: Value = serde_json::from_slice(&out.stdout).unwrap();
    for key in ["systems", "components", "unknowns", "problems", "quality", "object", "expected_processor_s"] {
        assert!(json.get(key).is_some(), "{key}");
    }
    assert_eq!(json["unknowns"]["pose"], 6);
    assert!(json["components"]["Position"].as_u64().unwrap() > 100);
    let out = tactus(&["check", "scenes/lemon.ron", "--format", "json"]);
    let json: Value = serde_json::from_slice(&out.stdout).unwrap();
    assert_eq!(json["scene"]["loading"]["Squeeze"]["force"], 15.0);
    assert_eq!(json["sources"].as_array().unwrap().len(), 2, "the scene and what it includes");
}

#[test]
fn check_names_the_grasps_that_cannot_start_and_run_says_the_same() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("s.ron");
    // A plate 0.4 mm thick at the rim of domed pads, which meet at their centres before they touch it; a block wider
    // than the opening.
    for (object, pads, says) in [
        (
            "shape: Cuboid(size: (0.0004, 0.03, 0.004))",
            "GelSightMini(shape: Domed, spacing: 3.0e-3)",
            "touch each other next to the object",
        ),
        ("shape: Cuboid(size: (0.1, 0.03, 0.03))", "GelSightMini(spacing: 3.0e-3)", "overlaps the object by"),
    ] {
        let text = format!(
            "(object: ({object}), gripper: (pads: {pads}, stroke: 0.045), grasps: List([(position: (0, 0, -0.111))]),\n\
             loading: Squeeze(force: 1, frames: 1))"
        );
        std::fs::write(&path, text).unwrap();
        let check = both(&tactus(&["check", path.to_str().unwrap()]));
        let run = both(&tactus(&["run", path.to_str().unwrap(), "--no-pictures"]));
        let reason = check.lines().find_map(|l| l.split_once("problem: grasp 0: ")).expect(&check).1;
        assert!(reason.contains(says), "{reason}");
        assert!(check.contains("0 of 1 grasps can start"), "{check}");
        assert!(run.contains(reason) && run.contains("infeasible"), "{run}");
    }
    let check = |grasps: &str| {
        let scene = write(dir.path(), 2, &format!("grasps: List([{grasps}])"));
        let out = tactus(&["check", scene.to_str().unwrap(), "--format", "json"]);
        let json: Value = serde_json::from_slice(&out.stdout).unwrap();
        (out.status.code(), json["problems"].as_array().unwrap().clone())
    };
    let (code, problems) = check("(position: (0, 0, -0.1)), (position: (0, 0.2, -0.1))");
    assert_eq!((code, problems.len()), (Some(0), 1));
    assert!(problems[0].as_str().unwrap().starts_with("grasp 1: the left finger does not touch the object"));
    assert_eq!(check("(position: (0, 0.2, -0.1))").0, Some(2), "nothing could run");
}

/// A modulus in kPa, a force of 10 kN and a time step of 1 ns are each reported in the last line of `check`.
#[test]
fn check_ends_with_what_is_absurd() {
    let dir = tempfile::tempdir().unwrap();
    let check = |pads: &str, rest: &str| {
        let path = dir.path().join("scene.ron");
        let text = format!(
            "(object: (shape: Sphere(radius: 0.02)), gripper: (pads: GelSightMini(spacing: 4e-3){pads}), {rest})"
        );
        std::fs::write(&path, text).unwrap();
        let out = tactus(&["check", path.to_str().unwrap()]);
        let text = String::from_utf8(out.stdout).unwrap();
        assert_eq!(out.status.code(), Some(0), "{text}");
        (text.lines().last().unwrap().to_string(), text.matches("problem: ").count())
    };
    let young = |young: f64| format!(", material: NeoHookean(young: {young:?}, poisson: 0.49)");
    let squeeze = |force: f64| format!("loading: Squeeze(force: {force:?}, frames: 3)");
    for (pads, force) in [(young(435.0), 10.0), (String::new(), 1e4)] {
        let (last, problems) = check(&pads, &squeeze(force));
        assert!(last.starts_with("// problem: a force of") && last.contains("the force is 720 E t^2"), "{last}");
        assert_eq!(problems, 1);
    }
    let (last, problems) = check(&young(435e3), &squeeze(10.0));
    assert!(problems == 0 && last.starts_with("// unknowns:"), "{last}");
    let motions = |step: f64| {
        format!(
            "gravity: (0, 0, -9.81), loading: Dynamic(motions: [Close(force: 8, duration: 0.2), Hold(duration: 1)], time_step: {step:?})"
        )
    };
    let (last, problems) = check("", &motions(1e-9));
    assert!(last.starts_with("// problem: a grasp takes about") && last.contains("has 1.2e9 time steps"), "{last}");
    assert_eq!((problems, check("", &motions(1e-3)).1), (1, 0));
}

/// A run is refused before its output folder is created, so the next run can use the folder.
#[test]
fn a_refused_run_leaves_nothing_behind() {
    let dir = tempfile::tempdir().unwrap();
    let (scene, out) = (write(dir.path(), 1, ""), dir.path().join("out"));
    let run =
        |options: &[&str]| tactus(&[&["run", scene.to_str().unwrap(), "-o", out.to_str().unwrap()], options].concat());
    // The force is outside the training range of the network.
    let refused = run(&["--backend", "gnn", "--force", "200"]);
    assert_eq!(refused.status.code(), Some(2), "{}", String::from_utf8_lossy(&refused.stdout));
    assert!(!out.exists(), "a refused run leaves no folder");
    let ran = run(&["--force", "1"]);
    assert_eq!(ran.status.code(), Some(0), "{}", String::from_utf8_lossy(&ran.stderr));
}

#[cfg(unix)]
#[test]
fn scenes_come_from_standard_input() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("pads.ron"), "(gripper: (pads: GelSightMini(spacing: 4e-3)))").unwrap();
    let text =
        "(include: [\"pads.ron\"], object: (shape: Sphere(radius: 0.015)), loading: Squeeze(force: 5, frames: 2))";
    let check = |script: &str, text: &str| {
        let mut command = Command::new("bash");
        command.args(["-c", script, "bash", env!("CARGO_BIN_EXE_tactus"), text]).current_dir(dir.path());
        let out = command.output().unwrap();
        (out.status.code(), String::from_utf8_lossy(&out.stdout).into_owned() + &String::from_utf8_lossy(&out.stderr))
    };
    for source in ["- <<< \"$2\"", "- < <(echo \"$2\")", "/dev/stdin <<< \"$2\"", "<(echo \"$2\")"] {
        let (code, said) = check(&format!("\"$1\" check {source}"), text);
        assert!(code == Some(0) && said.contains("spacing: 0.004"), "{source}: {said}");
    }
    let (code, said) = check("\"$1\" check - <<< \"$2\"", "(object: (shape: Ball(1)))");
    assert!(code == Some(2) && said.contains("<stdin>:1:"), "{said}");
    for endless in ["/dev/zero", "<(yes)"] {
        let (code, said) = check(&format!("\"$1\" check - < {endless}"), "");
        assert!(code == Some(2) && said.contains("<stdin> is larger than 16 MiB"), "{endless}: {said}");
    }
}

#[test]
fn an_open_mesh_is_refused_with_its_file() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("open.obj"), "v 0 0 0\nv 0.02 0 0\nv 0 0.02 0\nf 1 2 3\n").unwrap();
    let scene = dir.path().join("scene.ron");
    std::fs::write(&scene, "(object: (shape: Mesh(\"open.obj\")), loading: Squeeze(force: 5))").unwrap();
    for verb in ["check", "run"] {
        let out = tactus(&[verb, scene.to_str().unwrap()]);
        let text = String::from_utf8(out.stderr).unwrap();
        assert_eq!(out.status.code(), Some(2), "{text}");
        assert!(text.contains("open.obj"), "{text}");
    }
}

#[test]
fn predictions_of_many_grasps_come_as_a_table_as_json_and_as_arrays() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("arrays");
    let run = tactus(&["predict", "scenes/lemon.ron", "--format", "json", "-o", out.to_str().unwrap()]);
    assert_eq!(run.status.code(), Some(0), "{}", String::from_utf8_lossy(&run.stderr));
    let json: Value = serde_json::from_slice(&run.stdout).unwrap();
    let object = &json["objects"][0];
    assert_eq!((object["name"].as_str(), object["loads"].as_u64()), (Some("lemon"), Some(5)));
    let grasps = object["grasps"].as_array().unwrap();
    assert_eq!(grasps.len(), 2);
    for grasp in grasps {
        let travel = grasp["travel_mm"].as_f64();
        assert!(travel.is_some_and(|travel| (0.1..3.0).contains(&travel)), "{grasp}");
    }
    let mut npz = ndarray_npy::NpzReader::new(std::fs::File::open(out.join("lemon.npz")).unwrap()).unwrap();
    let displacement: ndarray::ArrayD<f32> = npz.by_name("displacement_m").unwrap();
    assert_eq!(displacement.shape()[..3], [2, 5, 2]);
    let again = |options: &[&str]| {
        tactus(&[&["predict", "scenes/lemon.ron", "--frames", "1", "-o", out.to_str().unwrap()], options].concat())
    };
    let refused = again(&[]);
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(refused.status.code() == Some(2) && said.contains("lemon.npz: contains an earlier prediction"), "{said}");
    assert_eq!(again(&["--overwrite"]).status.code(), Some(0));

    let scene = write(dir.path(), 2, "grasps: List([(position: (0, 0, -0.1)), (position: (0, 0.2, -0.1))])");
    let run = tactus(&["predict", scene.to_str().unwrap(), "--extrapolate"]);
    let text = String::from_utf8_lossy(&run.stdout);
    assert_eq!(run.status.code(), Some(1), "{text}{}", String::from_utf8_lossy(&run.stderr));
    assert!(text.contains("does not touch the object") && text.contains("1 of 2 grasps in"), "{text}");
    assert_eq!(tactus(&["predict", "scenes/lemon.ron", "--grasps", "5"]).status.code(), Some(0));
    assert_eq!(tactus(&["predict", "scenes/lemon.ron", "--model", "nobody"]).status.code(), Some(2));
}

#[test]
fn completions_and_manual_name_every_command() {
    let completions = tactus(&["completions", "bash"]);
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(tactus(&["man", "-o", folder.path().to_str().unwrap()]).status.code(), Some(0));
    let shown = String::from_utf8(completions.stdout).unwrap();
    for command in ["run", "predict", "check", "dataset", "train", "eval", "bench", "fit", "report"] {
        assert!(shown.contains(&format!("tactus,{command}")), "completions miss {command}");
        let page = std::fs::read_to_string(folder.path().join(format!("tactus-{command}.1"))).unwrap();
        assert!(page.contains("OPTIONS"), "{command}: {page}");
    }
    let version = String::from_utf8(tactus(&["--version"]).stdout).unwrap();
    assert!(version.contains("data set layout") && version.contains(env!("CARGO_PKG_VERSION")), "{version}");
}
