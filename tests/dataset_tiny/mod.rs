//! A data set so small that it is made in a second.
#![allow(dead_code)]

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use tactus::dataset::DataSet;

/// Two objects, six grasps, one of which misses; a grasp takes some 0.1 s.
pub const TINY: &str = r#"Scene(
    objects: [
        (name: "ball", object: (shape: Sphere(radius: 0.02)), grasps: Antipodal(count: 3, seed: 1)),
        (name: "box", object: (shape: Cuboid(size: (0.03, 0.04, 0.05), edge_radius: 0.004)), grasps: List([
            (position: (0, 0, -0.1)), (position: (0, 0.3, -0.1)),
            (position: (0.0, 0, -0.1), rotation: RpyDeg((0, 0, 90)))])),
    ],
    gripper: (pads: GelSightMini(spacing: 8e-3)),
    stepper: Fem(element: ELEMENT),
    loading: Squeeze(force: 2.0, frames: 2),
    expect: [ReachesForce, NoInversion, Travel(at_most: 1e-6)],
)"#;

pub struct Tiny {
    pub dir: tempfile::TempDir,
    pub scene: PathBuf,
}

impl Tiny {
    pub fn new(element: &str) -> Self {
        let dir = tempfile::tempdir().unwrap();
        let scene = dir.path().join("tiny.ron");
        std::fs::write(&scene, TINY.replace("ELEMENT", element)).unwrap();
        Self { dir, scene }
    }
    pub fn out(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }
    pub fn command(&self, out: &Path) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_tactus"));
        command.arg("dataset").arg(&self.scene).arg("-o").arg(out).args(["--format", "json"]);
        command
    }
    pub fn make(&self, out: &Path) -> Value {
        let done = self.command(out).output().unwrap();
        assert_eq!(done.status.code(), Some(1), "one grasp misses: {}", String::from_utf8_lossy(&done.stderr));
        serde_json::from_slice(&done.stdout).unwrap()
    }
    pub fn set(&self, name: &str) -> DataSet {
        self.make(&self.out(name));
        DataSet::open(self.out(name)).unwrap()
    }
}
