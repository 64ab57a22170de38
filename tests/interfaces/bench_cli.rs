//! `tactus bench` on the command line: output and refusals. The tests check the structure of the output and no times.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::LazyLock;

fn tactus(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tactus"));
    command.args(arguments).current_dir(env!("CARGO_MANIFEST_DIR")).output().unwrap()
}

/// Writes the scene of a press into a coarse pad.
fn press(dir: &Path, loading: &str) -> PathBuf {
    let path = dir.join("press.ron");
    let text = format!(
        "(object: (shape: Sphere(radius: 6e-3), motion: Fixed),
          gripper: (pads: Box(size: (0.016, 0.016, 0.0045), cells: (4, 4, 2)), opening: 0.02, friction: 0.0,
                    fingers: One, material: NeoHookean(young: 3e5, poisson: 0.45)),
          loading: {loading})"
    );
    std::fs::write(&path, text).unwrap();
    path
}

fn json(output: &Output) -> Value {
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// A folder with the scene of a press and, in `out`, its bench, and the report that was printed, shared by tests.
pub static BENCH: LazyLock<(tempfile::TempDir, Value)> = LazyLock::new(|| {
    let dir = tempfile::tempdir().unwrap();
    let (scene, out) = (press(dir.path(), "Press(depths: [0.5e-3, 0.8e-3])"), dir.path().join("out"));
    let arguments = ["bench", scene.to_str().unwrap(), "--repeat", "1", "--threads", "1", "--format", "json"];
    let report = json(&tactus(&[&arguments[..], &["-o", out.to_str().unwrap()]].concat()));
    (dir, report)
});

#[test]
fn a_bench_reports_time_and_error_of_every_setting() {
    let (dir, report) = &*BENCH;
    let out = dir.path().join("out");
    let points = report["points"].as_array().unwrap();
    assert!(points.len() >= 6, "{}", points.len());
    let error = |p: &Value, name: &str| p[name].as_f64().unwrap_or_else(|| panic!("{name} of {p}"));
    for p in points {
        for name in ["time_per_grasp_s", "time_per_frame_s", "cold_s", "displacement_error", "stress_error"] {
            assert!(error(p, name) > 0.0, "{name} of {p}");
        }
        assert!(p["force_error"].is_f64() && p["dominated"].is_boolean() && p["backend"] == "fem");
        assert!(p["failed"].as_array().unwrap().is_empty());
        let spread = &p["errors"]["displacement"];
        assert!(error(spread, "median") <= error(spread, "p90") && error(spread, "p90") <= error(spread, "worst"));
        let shares: f64 = p["profile"].as_object().unwrap().values().map(|v| v.as_f64().unwrap()).sum();
        assert!((shares - 1.0).abs() < 1e-9, "the shares of the stages add up: {shares}");
        let beaten = points.iter().any(|q| {
            let better = |name: &str| error(q, name) <= error(p, name);
            q["label"] != p["label"] && better("time_per_grasp_s") && better("displacement_error")
        });
        assert_eq!(p["dominated"], beaten, "{}", p["label"]);
    }
    let of = |label: &str| error(points.iter().find(|p| p["label"] == label).unwrap(), "force_error");
    assert!(
        of("linear 4x4x2") > 3.0 * of("quadratic 4x4x2"),
        "linear tetrahedra lock at nu = 0.45: {} against {}",
        of("linear 4x4x2"),
        of("quadratic 4x4x2")
    );
    let ladder = &report["ladder"];
    let roles: Vec<_> = ladder["members"].as_array().unwrap().iter().map(|m| m["role"].as_str().unwrap()).collect();
    // Without friction the result is independent of the path, so there is no member for the path error.
    assert_eq!(roles, ["rung", "rung", "rung", "reference", "other"]);
    for name in ["displacement", "stress", "force"] {
        for (i, row) in ladder["distances"][name].as_array().unwrap().iter().enumerate() {
            let known: Vec<bool> = row.as_array().unwrap().iter().map(Value::is_f64).collect();
            let wanted: Vec<bool> = (0..roles.len()).map(|j| j > i).collect();
            assert_eq!(known, wanted, "{name}: each pair once, in row {i}");
        }
    }
    let estimate = &ladder["errors"]["displacement"];
    let mean = (error(estimate, "by_rungs") * error(estimate, "by_other")).sqrt();
    assert!((error(estimate, "error") / mean - 1.0).abs() < 1e-12, "{estimate}");
    let reference = error(report, "reference_error");
    assert_eq!(reference, error(estimate, "error"));
    let own = points.iter().find(|p| p["label"] == "quadratic 4x4x2").map(|p| error(p, "displacement_error"));
    assert!(own.is_some_and(|own| reference > 0.0 && reference <= (1.0 + 1e-12) * own), "{reference} against {own:?}");
    // Only condensed pads are compared for speed at equal error; the ratio may be below 1.
    let claims: Vec<&Value> = points.iter().filter(|p| p["contender"] == true).collect();
    assert!(!claims.is_empty() && claims.iter().all(|p| p["label"].as_str().unwrap().contains("condensed")));
    let best = claims.iter().filter_map(|p| p["speedup_at_equal_error"]["ratio"].as_f64()).reduce(f64::max);
    assert_eq!(report["speedup_at_equal_error"].as_f64(), best, "the headline is the best of the claims");

    let written: Value = serde_json::from_slice(&std::fs::read(out.join("bench.json")).unwrap()).unwrap();
    assert_eq!(written, *report, "bench.json is what is printed");
    let csv = std::fs::read_to_string(out.join("bench.csv")).unwrap();
    assert_eq!(csv.lines().count(), points.len() + 2, "a heading, the points, the reference");
    assert!(std::fs::read(out.join("bench.png")).unwrap().starts_with(b"\x89PNG"));
    let svg = std::fs::read_to_string(out.join("bench.svg")).unwrap();
    assert!(svg.contains("<svg") && svg.contains("quadratic 4x4x2") && svg.contains("Pareto"));
}

/// The estimated displacement error of the finest of three mesh levels is within a factor of two of its distance to a
/// mesh of half the spacing.
#[test]
#[ignore = "thorough: certified meshes"]
fn the_estimated_error_of_the_reference_is_within_a_factor_of_two() {
    let dir = tempfile::tempdir().unwrap();
    let scene = press(dir.path(), "Press(depths: [0.8e-3])");
    let certify = |rungs: &str| {
        let out = dir.path().join(rungs);
        let arguments = ["bench", scene.to_str().unwrap(), "--certify", "--rungs", rungs, "--format", "json"];
        json(&tactus(&[&arguments[..], &["-o", out.to_str().unwrap()]].concat()))["rows"][0].clone()
    };
    let (coarse, fine) = (certify("3"), certify("5"));
    let estimate = coarse["fields"]["displacement"]["error"].as_f64().unwrap();
    let truth = fine["distances"]["displacement"][2][4].as_f64().unwrap();
    let ratio = estimate / truth;
    assert!((0.5..2.0).contains(&ratio), "the error of the third rung is estimated as {estimate}, and is {truth}");
    for name in ["travel_m", "displacement_rms_m", "stress_mean_pa"] {
        let [own, truth] = [&coarse, &fine].map(|row| row["values"][name]["value"].as_f64().unwrap());
        let error = coarse["values"][name]["error"].as_f64().unwrap();
        assert!((own - truth).abs() <= 2.0 * error + 1e-12 * truth, "{name}: {own} +- {error}, and is {truth}");
    }
    let table = std::fs::read_to_string(dir.path().join("5/references.md")).unwrap();
    assert!(table.contains("| press |") && table.contains("mean von Mises stress, kPa"), "{table}");
}

#[test]
fn of_a_pad_from_a_file_a_bench_says_what_is_not_known() {
    let arguments = ["bench", "scenes/torture/duplicates.ron", "--repeat", "1", "--grasps", "1", "--format", "json"];
    let report = json(&tactus(&arguments));
    assert!(report["reference_error"].as_f64().is_some(), "the path is known");
    assert!(report["ladder"]["errors"]["displacement"]["by_rungs"].is_null());
    let findings = report["ladder"]["findings"].as_array().unwrap();
    assert!(findings.iter().any(|f| f.as_str().unwrap().contains("the pads have only one mesh")), "{findings:?}");
    assert!(report["points"].as_array().unwrap().iter().any(|p| p["label"].as_str().unwrap().starts_with("linear")));
}

#[test]
fn sizes_grow_and_cost_has_an_exponent() {
    let dir = tempfile::tempdir().unwrap();
    let scene = press(dir.path(), "Press(depth: 0.3e-3, frames: 2)");
    let arguments = ["bench", scene.to_str().unwrap(), "--sizes", "800,200", "--repeat", "1", "--format", "json"];
    let report = json(&tactus(&arguments));
    let nodes: Vec<_> = report["sizes"].as_array().unwrap().iter().map(|s| s["nodes"].as_u64().unwrap()).collect();
    assert!(nodes.len() == 2 && nodes[0] < nodes[1], "{nodes:?}");
    assert!(report["sizes"][0]["unknowns"].as_u64().unwrap() < 3 * nodes[0]);
    assert!(report["iteration_exponent"].is_f64() && report["frame_exponent"].is_f64());
}

#[test]
fn what_cannot_be_compared_is_refused_by_name() {
    let dir = tempfile::tempdir().unwrap();
    let scene = press(dir.path(), "Press(depth: 0.3e-3, frames: 2)");
    let refusal = |arguments: &[&str]| {
        let output = tactus(arguments);
        assert_eq!(output.status.code(), Some(2));
        String::from_utf8(output.stderr).unwrap()
    };
    let scene = scene.to_str().unwrap();
    let missing = refusal(&["bench", scene, "--model", "no/such/model"]);
    assert!(missing.contains("no/such/model"), "{missing}");
    let dynamic = refusal(&["bench", "scenes/dynamic/lift.ron"]);
    assert!(dynamic.contains("`Squeeze` and `Press`"), "{dynamic}");
    let both = refusal(&["bench", scene, "--sizes", "500", "--model", "m"]);
    assert!(both.contains("--sizes"), "{both}");
}

#[test]
fn a_bench_of_a_task_reports_steps_a_second() {
    let dir = tempfile::tempdir().unwrap();
    let (scene, out) = (dir.path().join("task.ron"), dir.path().join("out"));
    let task = "(object: (shape: Sphere(radius: 0.02)), gripper: (pads: GelSightMini(spacing: 8e-3)),
        stepper: Fem(element: Linear), loading: Squeeze(force: 2.0, frames: 2),
        task: (gravity: (0, -9.81, 0), force: (1.0, 2.0), start: 1.5, steps: 3, lift: 1, observe: [Wrench], reward: [Hold()]))";
    std::fs::write(&scene, task).unwrap();
    let arguments = ["bench", scene.to_str().unwrap(), "--envs", "1,3", "--threads", "2", "--repeat", "1"];
    let report = json(&tactus(&[&arguments[..], &["--format", "json", "-o", out.to_str().unwrap()]].concat()));
    let rates = report["rates"].as_array().unwrap();
    let sizes: Vec<_> = rates.iter().map(|r| (r["threads"].as_u64().unwrap(), r["envs"].as_u64().unwrap())).collect();
    assert_eq!(sizes, [(1, 1), (1, 3), (2, 1), (2, 3)]);
    assert!(rates.iter().all(|r| r["backend"] == "fem" && r["steps_per_s"].as_f64().unwrap() > 0.0));
    assert!(report["left_out"].as_array().unwrap().is_empty());
    let written: Value = serde_json::from_slice(&std::fs::read(out.join("envs.json")).unwrap()).unwrap();
    assert_eq!(written, report, "envs.json is what is printed");
    assert!(std::fs::read(out.join("envs.png")).unwrap().starts_with(b"\x89PNG"));
    assert!(std::fs::read_to_string(out.join("envs.svg")).unwrap().contains("threads: 2"));

    let none = tactus(&["bench", "scenes/quickstart.ron", "--envs", "2"]);
    assert_eq!(none.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&none.stderr).contains("--envs needs a scene with a task"));
}
