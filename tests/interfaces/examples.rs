//! The examples and the commands of the tutorial run.

use crate::dataset_tiny::linear;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Runs a program of `examples/`, which is built into a folder next to the binary `tactus`.
fn example(name: &str, arguments: &[&str]) -> String {
    let program: PathBuf = Path::new(env!("CARGO_BIN_EXE_tactus")).with_file_name("examples").join(name);
    let ran = Command::new(&program).args(arguments).current_dir(root()).output();
    let Output { status, stdout, stderr } = ran.unwrap_or_else(|e| panic!("{}: {e}", program.display()));
    assert!(status.success(), "{name}: {}", String::from_utf8_lossy(&stderr));
    String::from_utf8(stdout).unwrap()
}

#[test]
fn a_squeeze_prints_its_frames() {
    let text = example("squeeze", &[]);
    assert!(text.contains(" 15.0 N: fingers travelled 0.65") && text.contains("reached: "), "{text}");
}

#[test]
fn a_press_prints_its_curve() {
    let forces: Vec<f64> =
        example("press", &[]).lines().map(|line| line.split(' ').nth(2).unwrap().parse().unwrap()).collect();
    assert_eq!(forces.len(), 4);
    assert!(forces.is_sorted() && forces[0] > 0.0, "{forces:?}");
}

#[test]
fn environments_step_and_are_restored() {
    let text = example("environments", &[]);
    assert_eq!(text.matches("force on the left pad").count(), 10, "{text}");
}

#[test]
fn a_data_set_is_read() {
    let dir = linear().folder();
    let text = example("data_set", &[dir.to_str().unwrap()]);
    assert!(text.contains("ball: 3 grasps reached their force") && text.contains("largest displacement"), "{text}");
}

#[test]
fn the_network_that_ships_is_asked() {
    assert_eq!(example("predict", &[]).matches("N per finger: travel").count(), 4);
}

/// Runs every command of the tutorial in order, in a folder with links to the repository's scenes and models.
#[test]
#[cfg(unix)]
fn the_tutorial_runs() {
    let text = std::fs::read_to_string(root().join("docs/tutorial.md")).unwrap();
    let dir = tempfile::tempdir().unwrap();
    for folder in ["scenes", "models"] {
        std::os::unix::fs::symlink(root().join(folder), dir.path().join(folder)).unwrap();
    }
    std::fs::create_dir(dir.path().join("out")).unwrap();
    let scene = text.split("```ron\n").nth(1).and_then(|rest| rest.split("```").next()).expect("a scene");
    std::fs::write(dir.path().join("out/thing.ron"), scene).unwrap();
    let commands: Vec<_> = text.lines().filter_map(|line| line.strip_prefix("    cargo run --release -- ")).collect();
    assert!(commands.len() >= 8, "{commands:?}");
    for command in commands {
        let mut tactus = Command::new(env!("CARGO_BIN_EXE_tactus"));
        let ran = tactus.args(command.split_whitespace()).current_dir(dir.path()).output().unwrap();
        assert_eq!(ran.status.code(), Some(0), "{command}: {}", String::from_utf8_lossy(&ran.stderr));
    }
}
