//! Grippers that a robot's description names: URDF and MJCF say what a scene could spell out.

use std::path::{Path, PathBuf};
use tactus::scene::{load, to_ron};

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/robots").join(name)
}

/// Writes a scene whose gripper has these fields, and loads it.
fn scene(folder: &Path, gripper: &str) -> Result<String, String> {
    let path = folder.join("scene.ron");
    let text = format!("(object: (shape: Sphere(radius: 0.02)), gripper: ({gripper}), loading: Squeeze(force: 5))");
    std::fs::write(&path, text).unwrap();
    load(&path).map(|loaded| to_ron(&loaded.scene).unwrap()).map_err(|error| error.to_string())
}

fn robot(path: &Path, more: &str) -> String {
    format!("robot: (path: {path:?}, hand: \"fr3_hand\", pads: (\"left_gel\", \"right_gel\")), {more}")
}

#[test]
fn urdf_and_mjcf_are_the_scene_that_spells_it_out() {
    let folder = tempfile::tempdir().unwrap();
    let spelt = scene(folder.path(), "opening: 0.07, stroke: 0.04, placement: (y: 0, z: 0.1128)").unwrap();
    for file in ["franka_gelsight.urdf", "franka_gelsight.xml"] {
        let read = scene(folder.path(), &robot(&shipped(file), "")).unwrap();
        assert_eq!(read, spelt, "{file}: what is the same scene gives the same grasp, bit for bit");
    }
}

#[test]
fn what_is_no_parallel_gripper_is_refused_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let urdf = std::fs::read_to_string(shipped("franka_gelsight.urdf")).unwrap();
    let changed = |from: &str, to: &str| {
        assert!(urdf.contains(from), "{from}");
        let path = folder.path().join("changed.urdf");
        std::fs::write(&path, urdf.replacen(from, to, 1)).unwrap();
        scene(folder.path(), &robot(&path, "")).unwrap_err()
    };
    let refused = [
        (changed("prismatic", "revolute"), "moves by a joint that does not slide"),
        (changed("axis xyz=\"0 1 0\"", "axis xyz=\"1 0 0\""), "must be parallel"),
        (changed("upper=\"0.04\"", "upper=\"0.03\""), "both must slide by as much"),
        (changed("-0.005 0.0544", "-0.005 0.05"), "do not face each other"),
        (changed("link name=\"left_gel\"", "link name=\"gel\""), "left_mount"),
        (changed("<robot", "<robt"), "no readable URDF"),
        (
            scene(folder.path(), &robot(&shipped("franka_gelsight.urdf"), "stroke: 0.03")).unwrap_err(),
            "leave one of them out",
        ),
        (scene(folder.path(), &robot(&shipped("franka.urdf"), "")).unwrap_err(), "no file at"),
        (
            scene(folder.path(), &robot(&shipped("franka_gelsight.xml"), "").replace("left_gel", "gel")).unwrap_err(),
            "has no link \"gel\"; it has",
        ),
    ];
    for (message, reason) in refused {
        assert!(message.contains(reason) && message.contains("scene.ron:1:"), "{message}");
    }
}
