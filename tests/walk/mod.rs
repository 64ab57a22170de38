//! Shared by the tests that walk scene files.
#![allow(dead_code, reason = "every test binary uses its own part")]

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use tactus::fem::continuation::Methods;
use tactus::grasp::poses_of;
use tactus::model::Model;
use tactus::runner::run_grasps;
use tactus::scene::leaf::Count;
use tactus::scene::{Loading, evaluate_all, load_set};
use tactus::stepper::choose;

/// Folder of the shipped scenes.
pub fn shipped() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes")
}

/// Scene files below `dir` but not in the folders named `without`; `common` holds includes, which are no scenes by themselves.
pub fn scenes(dir: &Path, without: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(dir).unwrap().map(|e| e.unwrap().path()) {
        let name = entry.file_name().unwrap().to_string_lossy().into_owned();
        if entry.is_dir() && name != "common" && !without.contains(&name.as_str()) {
            found.extend(scenes(&entry, without));
        } else if entry.extension().is_some_and(|e| e == "ron") {
            found.push(entry);
        }
    }
    found.sort();
    found
}

/// How often each method of the continuation was used by the scenes so far.
static METHODS: Mutex<Option<Methods>> = Mutex::new(None);

/// More grasps of an object than a test can run.
const LARGE: usize = 20;

/// Runs a scene on `threads` threads; the promises that it breaks. A large data set stands for itself by one short grasp of
/// its first object.
pub fn broken(path: &Path, threads: usize) -> Vec<String> {
    let file = path.file_stem().unwrap().to_string_lossy().into_owned();
    let set = load_set(path).unwrap_or_else(|e| panic!("{file}: {e}"));
    let mut broken = Vec::new();
    for named in set.scenes {
        let (name, mut scene) = (format!("{file}, {}", named.name.as_str()), named.scene);
        assert!(!scene.expect.is_empty(), "{name} promises something");
        let mut poses: Vec<_> = poses_of(&scene).unwrap().into_iter().enumerate().collect();
        let large = poses.len() > LARGE;
        if let (true, Loading::Squeeze(squeeze)) = (large, &mut scene.loading) {
            poses.truncate(1);
            squeeze.frames = Count::new(5).unwrap();
        }
        let model = Model::build(&scene).unwrap_or_else(|e| panic!("{name}: {e}"));
        let stepper = choose(&scene).unwrap();
        let outcomes = run_grasps(&model, stepper.as_ref(), &poses, threads, &()).unwrap();
        let mut methods = Methods::default();
        outcomes.iter().for_each(|o| methods += o.timings.methods);
        *METHODS.lock().unwrap().get_or_insert_default() += methods;
        let seconds: f64 = outcomes.iter().map(|o| o.summary.wall_s).sum();
        let measured: Vec<_> = outcomes.into_iter().map(|o| o.measured).collect();
        println!("{name}: {seconds:.1} s, {:?}", measured[0].findings);
        let held = scene.expect.iter().map(|e| evaluate_all(e, &measured));
        broken.extend(held.filter(|h| !h.held).map(|h| format!("{name}: {h:?}")));
        if large {
            break;
        }
    }
    broken
}

/// The promises that any of the scenes breaks; two scenes at a time, one thread each.
pub fn all_broken(paths: &[PathBuf]) -> Vec<String> {
    let (queue, failures) = (Mutex::new(paths.iter()), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let next = queue.lock().unwrap().next();
                    let Some(path) = next else { return };
                    let broken = broken(path, 1);
                    failures.lock().unwrap().extend(broken);
                }
            });
        }
    });
    // So that a method that no scene needs is seen.
    println!("methods of the continuation so far: {}", METHODS.lock().unwrap().unwrap_or_default());
    failures.into_inner().unwrap()
}
