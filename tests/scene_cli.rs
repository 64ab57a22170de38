//! The command line: exit codes, what goes to which stream.

use std::process::{Command, Output};

fn tactus(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_tactus")).args(arguments).current_dir(env!("CARGO_MANIFEST_DIR")).output().unwrap()
}

#[test]
fn check_prints_the_complete_scene() {
    let out = tactus(&["check", "scenes/quickstart.ron"]);
    assert_eq!(out.status.code(), Some(0));
    assert!(String::from_utf8(out.stdout).unwrap().contains("mean_dilatation: true"));
    let out = tactus(&["check", "scenes/lemon.ron", "--format", "json"]);
    let json: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
    assert_eq!(json["scene"]["loading"]["Squeeze"]["force"], 15.0);
    assert_eq!(json["sources"].as_array().unwrap().len(), 2);
}

#[test]
fn refusals_go_to_stderr_with_code_two() {
    for arguments in [
        &["check", "nowhere.ron"][..],
        &["check", "scenes"],
        &["run", "scenes/quickstart.ron", "--backend", "gnn"],
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
