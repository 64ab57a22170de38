//! Grippers from robot descriptions: URDF and MJCF files give the same gripper as explicit fields of a scene.

pub mod bounds;
mod mjcf;
mod soft;
mod tolerance;
mod urdf;

use std::path::{Path, PathBuf};
use tactus::scene::{Gripper, load, to_ron};

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/robots").join(name)
}

/// Writes a scene whose gripper has these fields, loads it, and returns its complete text.
fn scene(folder: &Path, gripper: &str) -> Result<String, String> {
    let path = folder.join("scene.ron");
    let text = format!("(object: (shape: Sphere(radius: 0.02)), gripper: ({gripper}), loading: Squeeze(force: 5))");
    std::fs::write(&path, text).unwrap();
    load(&path).map(|loaded| to_ron(&loaded.scene).unwrap()).map_err(|error| error.to_string())
}

fn robot(path: &Path, more: &str) -> String {
    format!("robot: (path: {path:?}, hand: \"fr3_hand\", pads: (\"left_gel\", \"right_gel\")), {more}")
}

/// Writes `files` (name, text) into an empty folder, and returns the gripper of the first one with the link `hand` and
/// these two pads.
fn read(files: &[(&str, &str)], hand: &str, pads: [&str; 2]) -> Result<Gripper, String> {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    gripper_in(folder.path(), files[0].0, hand, pads)
}

fn gripper_in(folder: &Path, file: &str, hand: &str, [left, right]: [&str; 2]) -> Result<Gripper, String> {
    scene(folder, &format!("robot: (path: {file:?}, hand: {hand:?}, pads: ({left:?}, {right:?}))"))?;
    Ok(load(folder.join("scene.ron")).unwrap().scene.gripper)
}

/// Asserts that opening, stroke, y and z of a gripper are `expected` to within `within`, m.
#[track_caller]
fn measures(gripper: &Gripper, expected: [f64; 4], within: f64) {
    let place = &gripper.placement;
    let found = [gripper.opening.get(), gripper.stroke.get(), place.y.get(), place.z.get()];
    let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off <= within, "opening, stroke, y, z {found:?} m, not {expected:?} m");
}

#[track_caller]
fn refused(result: Result<Gripper, String>, reasons: &[&str]) {
    let message = result.expect_err("it is refused");
    reasons.iter().for_each(|reason| assert!(message.contains(reason), "{reason:?} is not in: {message}"));
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
        (changed("prismatic", "revolute"), "is connected to \"fr3_hand\" by a joint that does not slide"),
        (changed("axis xyz=\"0 1 0\"", "axis xyz=\"1 0 0\""), "must be parallel"),
        (
            changed("upper=\"0.04\" velocity=\"0.2\"/>\n    <mimic joint=\"fr3_finger_joint1\"/>", "upper=\"0.03\"/>"),
            "both must slide by the same distance",
        ),
        (changed("-0.005 0.0544", "-0.005 0.05"), "do not face each other"),
        (changed("link name=\"left_gel\"", "link name=\"gel\""), "left_mount"),
        (changed("<robot", "<robt"), "is not valid XML"),
        (
            changed("upper=\"0.04\"", "upper=\"1e9.0\""),
            "changed.urdf:15:37: <limit upper=\"1e9.0\">: \"1e9.0\" is not a number",
        ),
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
