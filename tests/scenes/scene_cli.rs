//! The command line: exit codes, and which output goes to which stream.

use std::process::{Command, Output};

fn tactus(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_tactus")).args(arguments).current_dir(env!("CARGO_MANIFEST_DIR")).output().unwrap()
}

#[test]
fn refusals_go_to_stderr_with_code_two() {
    for arguments in [
        &["check", "nowhere.ron"][..],
        &["check", "scenes"],
        &["run", "scenes/quickstart.ron", "--backend", "gnn", "--model", "nowhere"],
        &["run", "scenes/press_sphere.ron", "--frames", "3"],
        &["run", "scenes/quickstart.ron", "--frames", "0"],
        &["run", "scenes/quickstart.ron", "--threads", "many"],
        &["run"],
        &["fly"],
    ] {
        let out = tactus(arguments);
        assert_eq!(out.status.code(), Some(2), "{arguments:?}");
        assert!(out.stdout.is_empty(), "{arguments:?}");
        assert!(String::from_utf8(out.stderr).unwrap().starts_with("error: "), "{arguments:?}");
    }
}

/// On the ball of the quickstart the fingers of the shipped network travel by 0.657 mm, the result of the finite
/// elements, to within 5 %.
#[test]
fn the_network_that_ships_presses_the_ball_of_the_quickstart() {
    let arguments = ["run", "scenes/quickstart.ron", "--backend", "gnn", "--no-pictures", "--format", "json"];
    let out = tactus(&arguments);
    let report: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
    let grasp = &report["grasps"][0];
    assert_eq!(grasp["status"], "reached", "{grasp}");
    let travel = grasp["travel_m"].as_f64().unwrap();
    assert!((travel / 0.657e-3 - 1.0).abs() < 0.05, "the fingers travel by {travel} m");
}

#[test]
fn the_volume_is_that_of_notes_and_never_of_results_or_errors() {
    let run = |volume: &[&str]| {
        let out = tactus(&[&["run", "scenes/fingertip.ron", "--frames", "1", "--force", "1"][..], volume].concat());
        assert_eq!(out.status.code(), Some(0), "{volume:?}");
        assert!(String::from_utf8(out.stdout).unwrap().contains("reached"));
        String::from_utf8(out.stderr).unwrap()
    };
    let (quiet, usual, verbose) = (run(&["-q"]), run(&[]), run(&["--verbose"]));
    assert!(quiet.is_empty(), "{quiet}");
    assert!(usual.contains("121 of 363 nodes are bonded") && !usual.contains("frame 0"), "{usual}");
    assert!(verbose.contains("121 of 363 nodes are bonded") && verbose.contains("grasp 0 frame 0: 1 N"), "{verbose}");
    let out = tactus(&["-q", "check", "nowhere.ron"]);
    assert!(String::from_utf8(out.stderr).unwrap().starts_with("error: "));
    assert_eq!(tactus(&["run", "scenes/quickstart.ron", "-q", "-v"]).status.code(), Some(2), "one of them");
}
