//! Each shipped scene passes `check`, runs one frame and is planned as a data set; scenes that are too large or not
//! regular files are refused quickly with a message.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::Mutex;
use tactus::scene::load_set;

/// Processor time limit of a check or of the refusal of a hostile scene, s, which does not depend on the load of the
/// machine.
const SECONDS: u64 = 20;

fn tactus(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_tactus")).args(arguments).current_dir(env!("CARGO_MANIFEST_DIR")).output().unwrap()
}

/// As [`tactus`], with an address space of `megabytes` and the processor time [`SECONDS`].
fn within(megabytes: u64, arguments: &[&str]) -> Output {
    limited(&format!("ulimit -v {} && ulimit -t {SECONDS}", megabytes << 10), arguments)
}

/// As [`tactus`], after the shell commands `limits`.
fn limited(limits: &str, arguments: &[&str]) -> Output {
    let limited = format!("{limits} && exec \"$0\" \"$@\"");
    Command::new("sh")
        .args(["-c", &limited, env!("CARGO_BIN_EXE_tactus")])
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap()
}

fn errors(out: &Output) -> String {
    String::from_utf8_lossy(&out.stderr).into_owned()
}

fn file(dir: &Path, name: &str, text: &str) -> String {
    let path = dir.join(name);
    std::fs::write(&path, text).unwrap();
    path.to_string_lossy().into_owned()
}

/// Asserts that a command exits with code 2 within [`SECONDS`] and 3 GB, with a message that contains all of `says`.
#[track_caller]
fn refused_at_once(arguments: &[&str], says: &[&str]) {
    let out = within(3000, arguments);
    let error = errors(&out);
    assert_eq!(out.status.code(), Some(2), "{arguments:?}: {error}");
    assert!(error.len() < 4000, "{arguments:?}: a message of {} bytes", error.len());
    for part in says {
        assert!(error.contains(part), "{arguments:?}: expected {part:?} in\n{error}");
    }
}

fn all() -> Vec<PathBuf> {
    crate::promises::scenes(&crate::promises::shipped(), &["meshes"])
}

/// Calls `each` with every scene on two threads and collects the complaints that it returns.
fn complaints(scenes: Vec<PathBuf>, each: impl Fn(&str) -> Option<String> + Sync) -> Vec<String> {
    let (queue, found) = (Mutex::new(scenes), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some(scene) = { queue.lock().unwrap().pop() } {
                    let scene = scene.to_str().unwrap();
                    let complaint = each(scene).map(|text| format!("{scene}: {text}"));
                    found.lock().unwrap().extend(complaint);
                }
            });
        }
    });
    found.into_inner().unwrap()
}

/// Complaint about an exit code that is not one of `codes`.
fn other(out: &Output, codes: &[i32]) -> Option<String> {
    let fine = out.status.code().is_some_and(|code| codes.contains(&code));
    (!fine).then(|| format!("{:?}: {}", out.status.code(), errors(out)))
}

#[test]
fn every_shipped_scene_is_checked() {
    let found = complaints(all(), |scene| {
        // A check takes seconds for any number of objects and grasps.
        let out = limited(&format!("ulimit -t {SECONDS}"), &["check", scene]);
        let text = String::from_utf8_lossy(&out.stdout);
        // Some scenes demonstrate a start that is refused.
        let codes: &[i32] = if text.contains("Infeasible(") || text.contains("problem: ") { &[0, 2] } else { &[0] };
        other(&out, codes).or_else(|| (!text.contains("grasps can start")).then(|| "no findings".into()))
    });
    assert!(found.is_empty(), "{}", found.join("\n"));
}

/// Commands on every scene: `shipped.rs` and `torture.rs` run all frames of these scenes, of `dynamic` and of `torture`,
/// and judge their results.
#[test]
#[ignore = "thorough: every scene of the folder"]
fn every_shipped_scene_runs_one_frame() {
    let found =
        complaints(crate::promises::scenes(&crate::promises::shipped(), &["meshes", "torture", "dynamic"]), |scene| {
            // One object of a large set is enough: a test below covers runs of several objects.
            let set = load_set(scene).unwrap();
            let object = set.scenes[0].name.as_str();
            let first = if set.scenes.len() > 3 { &["--object", object][..] } else { &[] };
            let out = tactus(&[&["run", scene, "--frames", "1", "--grasp", "0", "--no-pictures"], first].concat());
            if errors(&out).contains("--frames is not allowed for a press with `depths`") {
                return other(&out, &[2]);
            }
            other(&out, &[0, 1])
        });
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
#[ignore = "thorough: every scene of the folder"]
fn every_shipped_scene_is_planned_as_a_data_set() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("set");
    let found = complaints(all(), |scene| {
        let planned = tactus(&["dataset", scene, "-o", out.to_str().unwrap(), "--dry-run"]);
        // A data set records the contact of the pads, so it needs fingers.
        if errors(&planned).contains("needs pads, and the scene has none") {
            let bare = String::from_utf8_lossy(&tactus(&["check", scene]).stdout).contains("fingers: r#None");
            return other(&planned, &[2]).or_else(|| (!bare).then(|| "has fingers".into()));
        }
        other(&planned, &[0])
    });
    assert!(found.is_empty(), "{}", found.join("\n"));
    assert!(!out.exists(), "a dry run writes nothing");
}

const FALL: &str =
    "(object: (shape: Cuboid(size: (0.02, 0.03, 0.04))), gripper: (fingers: None), gravity: (0, 0, -9.81),
    loading: Dynamic(motions: [Hold(duration: 0.01)], frames: 1))";

#[test]
fn a_scene_without_fingers_is_checked_and_refused_where_pads_are_needed() {
    let dir = tempfile::tempdir().unwrap();
    let scene = file(dir.path(), "fall.ron", FALL);
    let out = tactus(&["check", &scene]);
    assert_eq!(out.status.code(), Some(0), "{}", errors(&out));
    let out = tactus(&["run", &scene, "-o", dir.path().join("run").to_str().unwrap()]);
    assert_eq!(out.status.code(), Some(0), "{}", errors(&out));
    let page = dir.path().join("page.html");
    let out = tactus(&["report", dir.path().join("run").to_str().unwrap(), "-o", page.to_str().unwrap()]);
    assert_eq!(out.status.code(), Some(0), "{}", errors(&out));
    let set = dir.path().join("set");
    let set = set.to_str().unwrap();
    for (arguments, says) in [
        (&["dataset", &scene, "-o", set, "--dry-run"][..], "needs pads, and the scene has none"),
        (&["dataset", &scene, "-o", set][..], "needs pads, and the scene has none"),
        (&["bench", &scene, "--sizes", "500"][..], "needs pads, and the scene has none"),
        (&["bench", &scene][..], "the scene has none (`fingers: None`)"),
        (&["bench", &scene, "--envs", "1"][..], "task"),
        (&["run", &scene, "--backend", "gnn"][..], ""),
        (&["run", &scene, "--backend", "condensed"][..], "condensed pads have no inertia"),
    ] {
        let out = tactus(arguments);
        assert_eq!(out.status.code(), Some(2), "{arguments:?}: {}", errors(&out));
        assert!(errors(&out).contains(says), "{arguments:?}: {}", errors(&out));
    }
}

const TWO: &str = "(objects: [(name: \"ball\", object: (shape: Sphere(radius: 0.02))), (name: \"rod\", object: (shape: Cylinder(radius: 0.015, height: 0.06)))],
    gripper: (pads: Box(size: (0.02, 0.02, 0.004), cells: (4, 4, 2))), loading: Squeeze(force: 1, frames: 1), expect: [ReachesForce])";

#[test]
fn several_objects_are_checked_and_run_one_after_the_other() {
    let dir = tempfile::tempdir().unwrap();
    let scene = file(dir.path(), "two.ron", TWO);
    let out = tactus(&["check", &scene]);
    let text = String::from_utf8(out.stdout).unwrap();
    assert_eq!(out.status.code(), Some(0), "{}", String::from_utf8_lossy(&out.stderr));
    assert!(text.contains("// object ball\n") && text.contains("// object rod\n"), "{text}");
    assert_eq!(text.matches("1 of 1 grasps can start").count(), 2);

    let out = tactus(&["check", &scene, "--format", "json"]);
    let json: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
    assert_eq!(json["objects"][1]["name"], "rod");
    assert!(json["objects"][0]["unknowns"]["total"].as_u64().unwrap() > 0);
    let out = tactus(&["check", &scene, "--format", "json", "--object", "rod"]);
    let json: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
    assert_eq!(json["grasps"], 1, "one object is there by itself");

    let results = dir.path().join("out");
    let out = tactus(&["run", &scene, "-o", results.to_str().unwrap(), "--no-pictures", "--format", "json"]);
    assert_eq!(out.status.code(), Some(0), "{}", errors(&out));
    let json: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
    assert_eq!(json["objects"][0]["name"], "ball");
    assert_eq!(json["objects"][1]["grasps"][0]["status"], "reached");
    assert!(results.join("ball/run.json").exists() && results.join("rod/run.json").exists());
    let out = tactus(&["check", &scene, "--export", dir.path().join("x.obj").to_str().unwrap()]);
    assert!(errors(&out).contains("choose it with --object"), "{}", errors(&out));
}

#[test]
fn pads_that_do_not_fit_into_memory_are_refused_before_they_are_meshed() {
    let dir = tempfile::tempdir().unwrap();
    let scene = |spacing: &str| {
        let text = format!(
            "(object: (shape: Sphere(radius: 0.02)),\n gripper: (pads: GelSightMini(spacing: {spacing})), loading: Squeeze(force: 2, frames: 1))"
        );
        file(dir.path(), &format!("spacing_{spacing}.ron"), &text)
    };
    // Each factorisation alone takes about 60 GB.
    let fine = scene("3e-4");
    let set = dir.path().join("set");
    for arguments in
        [&["check", &fine][..], &["run", &fine], &["dataset", &fine, "-o", set.to_str().unwrap(), "--dry-run"]]
    {
        refused_at_once(arguments, &["nodes", "unknowns", "GB", "are free", "use a larger spacing", ".ron:2:18"]);
    }
    refused_at_once(&["check", &scene("1e-6")], &["use a larger spacing", ".ron:2:18"]);
}

#[test]
fn a_data_set_that_does_not_fit_on_the_disk_is_refused_before_it_begins() {
    let dir = tempfile::tempdir().unwrap();
    // 0.8 MB a frame, 10,000 frames a grasp.
    let poses = "(position: (0, 0, -0.1)),".repeat(20_000);
    let text = format!(
        "(object: (shape: Sphere(radius: 0.02)), gripper: (pads: Box(size: (0.02, 0.02, 0.004), cells: (20, 20, 3))),
        loading: Squeeze(force: 1, frames: 10000), grasps: List([{poses}]))"
    );
    let scene = file(dir.path(), "large.ron", &text);
    let set = dir.path().join("set");
    let out = tactus(&["dataset", &scene, "-o", set.to_str().unwrap()]);
    let error = errors(&out);
    assert_eq!(out.status.code(), Some(2), "{error}");
    assert!(
        error.contains("the data set needs up to") && error.contains("TB") && error.contains("free there"),
        "{error}"
    );
    assert!(!set.exists(), "nothing is laid out");
}

#[test]
fn hostile_texts_are_refused_in_bounded_time_and_memory() {
    let dir = tempfile::tempdir().unwrap();
    let object = "object: (shape: Sphere(radius: 0.02)), loading: Squeeze(force: 1)";
    let check = |name: &str, text: &str, says: &[&str]| {
        refused_at_once(&["check", &file(dir.path(), name, text)], says);
    };
    // A long key of a long list takes 14 GB if each element stores its own path.
    let (key, list) = ("k".repeat(300_000), "0,".repeat(150_000));
    check("key.ron", &format!("({object}, {key}: [{list}])"), &["unknown field `kkk", "key.ron:1:69"]);
    // Each object gets a copy of the shared expectations.
    let objects = |n: usize| -> String {
        (0..n).map(|i| format!("(name:\"o{i}\",object:(shape:Sphere(radius:0.02))),")).collect()
    };
    let promises = "Finite,".repeat(100_000);
    let text = format!("(loading: Squeeze(force: 1), objects: [{}], expect: [{promises}])", objects(9_000));
    check("shared.ron", &text, &["9000 objects with", "shared.ron:1:39"]);
    check("promises.ron", &format!("({object}, expect: [{promises}])"), &["100000 expectations", "at most 1000"]);
    check(
        "objects.ron",
        &format!("(loading: Squeeze(force: 1), objects: [{}])", objects(250_000)),
        &["250000 objects", "at most 10000"],
    );
    check(
        "values.ron",
        &format!("({object}, grasps: List([{}]))", "0,".repeat(3_000_000)),
        &["more than 2000000 values"],
    );
    let depths: String = (1..=20_000).map(|i| format!("{}e-7,", i)).collect();
    let press = "object: (shape: Sphere(radius: 0.02), motion: Fixed)";
    check("depths.ron", &format!("({press}, loading: Press(depths: [{depths}]))"), &["20000 depths"]);
    check(
        "name.ron",
        &format!("({object}, gripper: (material: Preset(\"{}\")))", "x".repeat(1_000_000)),
        &["name.ron:1:"],
    );
    check("nested.ron", &format!("({object}, x: {}", "[".repeat(1_000_000)), &["nested.ron:1:"]);
    let include = file(dir.path(), "half.ron", &format!("// {}\n(about: \"half\")", "x".repeat(9 << 20)));
    file(dir.path(), "other.ron", &std::fs::read_to_string(include).unwrap());
    check("both.ron", &format!("(include: [\"half.ron\", \"other.ron\"], {object})"), &["together larger than 16 MiB"]);
}

/// The scene itself, what it includes, and every field that names a file, one of a robot description among them. Meshes
/// that are read without a scene are tested in `mesh_bad_input.rs`.
#[cfg(unix)]
#[test]
fn what_is_no_regular_file_is_refused_by_name_wherever_it_is_named() {
    let dir = tempfile::tempdir().unwrap();
    for fifo in ["fifo", "fifo.xml"] {
        assert!(Command::new("mkfifo").arg(dir.path().join(fifo)).status().unwrap().success());
    }
    let fifo = dir.path().join("fifo");
    refused_at_once(&["check", fifo.to_str().unwrap()], &["fifo: is a fifo, not a scene file"]);
    refused_at_once(&["check", "/dev/zero"], &["/dev/zero: is a device, not a scene file"]);
    let robot = |include: &str, name: &str| {
        let text = crate::robots::bounds::with(&format!("<include file=\"{include}\"/>"));
        file(dir.path(), name, &text);
        format!("gripper: (robot: (path: \"{name}\", hand: \"fr3_hand\", pads: (\"left_gel\", \"right_gel\")))")
    };
    let pads = "gripper: (pads: File(path: \"fifo\", outward: (0, 0, 1), bonded: Plane(within: 1e-4)))";
    for (verb, field, says) in [
        ("check", "include: [\"fifo\"]", &["is a fifo, not a scene file", "field.ron:3:12"][..]),
        ("run", "include: [\"/dev/zero\"]", &["/dev/zero: is a device", "field.ron:3:12"]),
        ("check", "grasps: File(\"/dev/zero\")", &["/dev/zero is a device, not a file", "field.ron:3:"]),
        ("check", "grasps: File(\"fifo\")", &["fifo is a fifo, not a file", "field.ron:3:"]),
        ("check", "grasps: File(\"/\")", &["is a directory", "field.ron:3:"]),
        ("check", pads, &["fifo is a fifo, not a file", "field.ron:3:"]),
        ("check", &robot("fifo.xml", "a.xml"), &["fifo.xml", "a fifo", "not a regular file"]),
        ("check", &robot("/dev/zero", "b.xml"), &["/dev/zero", "a device", "not a regular file"]),
    ] {
        let text = format!("(object: (shape: Sphere(radius: 0.02)),\n loading: Squeeze(force: 1),\n {field})");
        refused_at_once(&[verb, &file(dir.path(), "field.ron", &text)], says);
    }
    let mesh = file(dir.path(), "mesh.ron", "(object: (shape: Mesh(\"fifo\")), loading: Squeeze(force: 1))");
    refused_at_once(&["check", &mesh], &["fifo is a fifo, not a file", "mesh.ron:1:23"]);
}

#[test]
fn what_a_scene_asks_of_a_network_is_said_apart() {
    let run = |arguments: &[&str]| {
        let out = tactus(&[&["run", "scenes/lemon.ron", "--no-pictures", "--grasp", "0"][..], arguments].concat());
        assert_eq!(out.status.code(), Some(0), "{}{}", String::from_utf8_lossy(&out.stdout), errors(&out));
        String::from_utf8(out.stdout).unwrap()
    };
    let json: serde_json::Value = serde_json::from_str(&run(&["--backend", "gnn", "--format", "json"])).unwrap();
    assert_eq!(json["promised_in"], "expect_network");
    let names: Vec<_> = json["expectations"].as_array().unwrap().iter().map(|e| e["name"].as_str().unwrap()).collect();
    assert!(names.contains(&"Penetration") && !names.contains(&"NoPenetration"), "{names:?}");
    assert!(run(&["--backend", "gnn"]).contains("expectations from expect_network:"));
    let json: serde_json::Value = serde_json::from_str(&run(&["--frames", "1", "--format", "json"])).unwrap();
    assert_eq!(json["promised_in"], "expect");
}

#[test]
fn messages_name_the_file_of_the_field_and_show_six_digits() {
    let dir = tempfile::tempdir().unwrap();
    file(dir.path(), "hand.ron", "(\n    gripper: (pads: Disc(radius: 0.01, thickness: 0.004, spacing: 1e-6)),\n)");
    let scene = file(
        dir.path(),
        "scene.ron",
        "(include: [\"hand.ron\"], object: (shape: Sphere(radius: 0.02)), loading: Squeeze(force: 1))",
    );
    refused_at_once(&["run", &scene], &["hand.ron:2:21", "gripper.pads: "]);
    let scene = file(
        dir.path(),
        "digits.ron",
        "(object: (shape: Annulus(outer: 0.0123456789123, inner: 0.0223456789123, height: 0.01)), loading: Squeeze(force: 1))",
    );
    refused_at_once(&["check", &scene], &["0.0223457 m", "0.0123457 m"]);
}

#[test]
fn a_pad_without_thickness_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let text = "(object: (shape: Sphere(radius: 0.02)), loading: Squeeze(force: 1),\n gripper: (pads: Box(size: (0.02, 0.02, 1e-300))))";
    refused_at_once(
        &["check", &file(dir.path(), "thin.ron", text)],
        &["1e-300 m is too small for a pad", "thin.ron:2:"],
    );
}

#[test]
fn a_check_tries_the_first_thousand_grasps() {
    let dir = tempfile::tempdir().unwrap();
    let text =
        "(object: (shape: Sphere(radius: 0.02)), gripper: (pads: Box(size: (0.02, 0.02, 0.004), cells: (2, 2, 2))),
        loading: Squeeze(force: 1, frames: 1), grasps: Antipodal(count: 1500))";
    let out = tactus(&["check", &file(dir.path(), "many.ron", text)]);
    let text = String::from_utf8_lossy(&out.stdout);
    assert!(text.contains(" of 1000 grasps can start; 500 more were not checked"), "{text}");
}

/// The size estimate equals the numbers of nodes and unknowns of the generated grid.
#[test]
fn the_size_of_a_pad_is_known_before_it_is_meshed() {
    use tactus::geometry::pad::{Resolution, box_pad};
    use tactus::model::limits::PadSize;
    use tactus::scene::Element;
    for cells in [[1, 1, 1], [4, 6, 2], [3, 2, 5]] {
        let pad = box_pad(0.02, 0.03, 0.004, &Resolution::cells(cells)).unwrap();
        for element in [Element::Linear, Element::Quadratic] {
            assert_eq!(PadSize::of_cells(cells, element), PadSize::of_pad(&pad, element), "{cells:?} {element:?}");
        }
    }
    let size = PadSize::of_cells([8, 10, 3], Element::Quadratic);
    assert_eq!(size.nodes, 17 * 21 * 7);
}
