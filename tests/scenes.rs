//! Every shipped scene runs and keeps its promises.

use std::path::{Path, PathBuf};
use tactus::grasp::poses_of;
use tactus::model::Model;
use tactus::runner::run_grasps;
use tactus::scene::{evaluate_all, load};
use tactus::stepper::choose;

/// Scene files below `dir`; `common` holds includes, which are no scenes by themselves.
fn scenes(dir: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(dir).unwrap().map(|e| e.unwrap().path()) {
        if entry.is_dir() && entry.file_name().unwrap() != "common" {
            found.extend(scenes(&entry));
        } else if entry.extension().is_some_and(|e| e == "ron") {
            found.push(entry);
        }
    }
    found.sort();
    found
}

#[test]
fn every_scene_keeps_its_promises() {
    let all = scenes(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes"));
    assert!(all.len() >= 8, "the shipped scenes are found: {all:?}");
    let mut broken = Vec::new();
    for path in all {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let scene = load(&path).unwrap_or_else(|e| panic!("{name}: {e}")).scene;
        assert!(!scene.expect.is_empty(), "{name} promises something");
        let model = Model::build(&scene).unwrap_or_else(|e| panic!("{name}: {e}"));
        let poses: Vec<_> = poses_of(&scene).unwrap().into_iter().enumerate().collect();
        let stepper = choose(&scene).unwrap();
        let outcomes = run_grasps(&model, stepper.as_ref(), &poses, 2, &()).unwrap();
        let measured: Vec<_> = outcomes.into_iter().map(|o| o.measured).collect();
        for expectation in &scene.expect {
            let held = evaluate_all(expectation, &measured);
            if !held.held {
                broken.push(format!("{name}: {held:?}"));
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}
