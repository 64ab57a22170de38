//! A signal ends a command and keeps its finished results; the interrupt flag ends work inside the process.
#![cfg(unix)]

use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};
use tactus::backend::choose;
use tactus::base::error::Error;
use tactus::base::interrupt;
use tactus::env::{BatchConfig, BatchEnv};
use tactus::model::Model;
use tactus::model::grasp::grasp_poses;
use tactus::scene::{load, load_set};
use tactus::world::run::run_grasps;

/// A scene whose grasps take less than a second each and minutes in total.
const LONG: &str = r#"Scene(
    object: (shape: Sphere(radius: 0.02)),
    grasps: Antipodal(count: 400, seed: 1),
    gripper: (pads: GelSightMini(spacing: 4.0e-3)),
    loading: Squeeze(force: 10.0, frames: 5),
    stepper: Fem(element: Linear),
)"#;

/// Time limit of every wait, more than ten times what any of them takes.
const LIMIT: Duration = Duration::from_secs(120);

fn scene(dir: &Path, text: &str) -> std::path::PathBuf {
    let path = dir.join("long.ron");
    std::fs::write(&path, text).unwrap();
    path
}

/// Starts a command with SIGINT ignored, as a shell without job control does in the background.
fn start(args: &[&str]) -> Child {
    let mut command = Command::new("sh");
    command.args(["-c", "trap '' INT; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_tactus")]).args(args);
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

fn send(signal: &str, child: &Child) {
    assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
}

fn wait_until(what: &str, mut holds: impl FnMut() -> bool) {
    let clock = Instant::now();
    while !holds() {
        assert!(clock.elapsed() < LIMIT, "waited in vain: {what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn end(mut child: Child) -> (Output, Duration) {
    let clock = Instant::now();
    wait_until("the command ends", || child.try_wait().unwrap().is_some());
    (child.wait_with_output().unwrap(), clock.elapsed())
}

fn finished(run: &Path) -> usize {
    let text = std::fs::read(run.join("run.json")).unwrap_or_default();
    let report: Option<serde_json::Value> = serde_json::from_slice(&text).ok();
    report.and_then(|r| r["grasps"].as_array().map(Vec::len)).unwrap_or(0)
}

#[test]
fn a_run_keeps_its_finished_grasps() {
    for signal in ["-INT", "-TERM"] {
        let dir = tempfile::tempdir().unwrap();
        let (path, out) = (scene(dir.path(), LONG), dir.path().join("run"));
        let child = start(&["run", path.to_str().unwrap(), "-o", out.to_str().unwrap(), "--no-pictures"]);
        wait_until("three grasps", || finished(&out) >= 3);
        send(signal, &child);
        let (ended, took) = end(child);
        println!("{signal}: ended {} ms after the signal", took.as_millis());
        let stderr = String::from_utf8_lossy(&ended.stderr).into_owned();
        assert_eq!(ended.status.code(), Some(2), "{signal}: {stderr}");
        let kept = finished(&out);
        let said = format!("interrupted; {kept} of 400 grasps are finished in {}", out.display());
        assert!(stderr.trim_end().ends_with(&said), "{signal}: {stderr:?} does not say {said:?}");
        let report: serde_json::Value = serde_json::from_slice(&std::fs::read(out.join("run.json")).unwrap()).unwrap();
        assert_eq!(report["finished"], false);
        let all = report["grasps"].as_array().unwrap();
        assert!(all.iter().all(|g| g["status"] == "reached"), "no grasp counts as a fault: {all:?}");
    }
}

#[test]
fn a_data_set_goes_on_after_a_signal() {
    let dir = tempfile::tempdir().unwrap();
    let (path, out) = (scene(dir.path(), &LONG.replace("count: 400", "count: 24")), dir.path().join("set"));
    let args = ["dataset", path.to_str().unwrap(), "-o", out.to_str().unwrap(), "--threads", "1"];
    let child = start(&args);
    let progress = out.join(".progress").join("long");
    let record = |e: &std::fs::DirEntry| e.path().extension().is_some_and(|e| e == "json");
    let entered = || std::fs::read_dir(&progress).map_or(0, |d| d.flatten().filter(record).count());
    wait_until("two grasps", || entered() >= 2);
    send("-TERM", &child);
    let (ended, _) = end(child);
    let stderr = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert_eq!(ended.status.code(), Some(2), "{stderr}");
    let said = format!(
        "interrupted; {} of 24 grasps are finished in {}; the same command resumes from there",
        entered(),
        out.display()
    );
    assert!(stderr.trim_end().ends_with(&said), "{stderr:?} does not say {said:?}");
    let (whole, _) = end(start(&[&args[..], &["--format", "json"]].concat()));
    assert_eq!(whole.status.code(), Some(0), "{}", String::from_utf8_lossy(&whole.stderr));
    let report: serde_json::Value = serde_json::from_slice(&whole.stdout).unwrap();
    assert!(report["resumed"].as_u64().unwrap() >= 2, "what was finished did not run again");
    assert_eq!(report["manifest"]["objects"][0]["reached"], 24);
}

#[test]
fn the_flag_ends_grasps_and_environments() {
    let dir = tempfile::tempdir().unwrap();
    let path = scene(dir.path(), LONG);
    let loaded = load(&path).unwrap();
    let (model, stepper) = (Model::build(&loaded.scene).unwrap(), choose(&loaded.scene).unwrap());
    let grasps: Vec<_> = grasp_poses(&loaded.scene).unwrap().into_iter().enumerate().collect();
    let late = std::thread::spawn(|| {
        std::thread::sleep(Duration::from_millis(700));
        interrupt::request();
        Instant::now()
    });
    let error = run_grasps(&model, stepper.as_ref(), &grasps, 2, &()).unwrap_err();
    println!("grasps ended {} ms after the request", late.join().unwrap().elapsed().as_millis());
    assert!(matches!(error, Error::Interrupted(_)), "{error}");
    interrupt::clear();
    let some = run_grasps(&model, stepper.as_ref(), &grasps[..2], 2, &()).unwrap();
    assert!(some.iter().all(|o| o.summary.reason.is_none()), "cleared, it runs as ever");

    let set = load_set(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/tasks/hold.ron")).unwrap().scenes;
    let config = BatchConfig { num_envs: 2, objects: Some(vec!["sphere".into()]), ..BatchConfig::default() };
    let mut env = BatchEnv::new(&set, config).unwrap();
    let first = env.reset(Some(1), None).unwrap().obs("wrench").unwrap().to_vec();
    interrupt::request();
    let error = env.step(&[0.0; 2]).unwrap_err().to_string();
    interrupt::clear();
    assert!(error.starts_with("interrupted"), "{error}");
    let error = env.step(&[0.0; 2]).unwrap_err().to_string();
    assert!(error.contains("reset"), "no step counts for one environment and not for the other: {error}");
    assert_eq!(env.reset(Some(1), None).unwrap().obs("wrench").unwrap(), first);
}
