//! Every shipped scene runs and keeps its promises.

use std::path::{Path, PathBuf};
use tactus::grasp::poses_of;
use tactus::model::Model;
use tactus::runner::run_grasps;
use tactus::scene::leaf::Count;
use tactus::scene::{Loading, evaluate_all, load_set};
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

/// More grasps of an object than a test can run.
const LARGE: usize = 20;

#[test]
fn every_scene_keeps_its_promises() {
    let all = scenes(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes"));
    assert!(all.len() >= 8, "the shipped scenes are found: {all:?}");
    let mut broken = Vec::new();
    for path in all {
        let file = path.file_stem().unwrap().to_string_lossy().into_owned();
        let set = load_set(&path).unwrap_or_else(|e| panic!("{file}: {e}"));
        for mut named in set.scenes {
            let name = format!("{file}, {}", named.name.as_str());
            let scene = &mut named.scene;
            assert!(!scene.expect.is_empty(), "{name} promises something");
            let mut poses: Vec<_> = poses_of(scene).unwrap().into_iter().enumerate().collect();
            // A large data set stands for itself by one short grasp of its first object.
            let large = poses.len() > LARGE;
            if let (true, Loading::Squeeze(squeeze)) = (large, &mut scene.loading) {
                poses.truncate(1);
                squeeze.frames = Count::new(5).unwrap();
            }
            let model = Model::build(scene).unwrap_or_else(|e| panic!("{name}: {e}"));
            let stepper = choose(scene).unwrap();
            let outcomes = run_grasps(&model, stepper.as_ref(), &poses, 2, &()).unwrap();
            let measured: Vec<_> = outcomes.into_iter().map(|o| o.measured).collect();
            for expectation in &scene.expect {
                let held = evaluate_all(expectation, &measured);
                if !held.held {
                    broken.push(format!("{name}: {held:?}"));
                }
            }
            if large {
                break;
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}
