//! Soft pads in Isaac Gym's dialect of URDF.

use super::{scene, shipped};
use crate::skipped::data;
use std::path::Path;
use std::process::Command;
use tactus::scene::load;

const SOFT: &str = "hand: \"hand\", pads: (\"left_pad\", \"right_pad\")";

/// Isaac Gym's `<fem>` gives mesh, gel and the distance from the shape of the finger within which nodes are bonded. The
/// pads are those of the equivalent scene: the same bonded nodes, positions to 1e-12 m.
#[test]
fn soft_pads_of_a_urdf_are_the_scene_that_spells_them_out() {
    let folder = tempfile::tempdir().unwrap();
    let load = |gripper: &str| {
        scene(folder.path(), gripper)?;
        Ok::<_, String>(load(folder.path().join("scene.ron")).unwrap().scene)
    };
    let read = load(&format!("robot: (path: {:?}, {SOFT}), friction: 0.7", shipped("fingertips.urdf"))).unwrap();
    let [pad, core] = ["fingertip.tet", "core.obj"].map(|name| shipped("../pads").join(name));
    let spelt = load(&format!(
        "pads: File(path: {pad:?}, across: (0, 1, 0), bonded: NearMesh(path: {core:?}, within: 2e-4)),
         material: Corotational(young: 2e5, poisson: 0.45, density: 1000),
         right: (material: Corotational(young: 4e5, poisson: 0.45, density: 1000)),
         opening: 0.08, stroke: 0.04, placement: (y: 0, z: 0.1), friction: 0.7"
    ))
    .unwrap();
    for side in [0, 1] {
        let (mut a, mut b) = (read.gripper.with_equal_fingers(side), spelt.gripper.with_equal_fingers(side));
        let pads = [&mut a.pads, &mut b.pads].map(std::mem::take);
        let notice = a.notice.0.take().expect("1.57 is told");
        assert!(notice.contains("errors of up to 8.0e-4 rad"), "{notice}");
        assert_eq!(a, b, "gel, friction, opening, stroke and place of finger {side}");
        let [a, b] = pads.map(|pads| tactus::model::part::pad::build(&pads, &mut Vec::new()).unwrap().0);
        assert_eq!(a.bonded, b.bonded, "what the distance to the core bonds on finger {side}");
        let off = a.mesh.nodes.iter().zip(&b.mesh.nodes).map(|(p, q)| p.distance(*q)).fold(0.0, f64::max);
        assert!(off < 1e-12, "the nodes of finger {side} lie where they should, but for {off} m");
    }
}

#[test]
fn soft_pads_that_say_too_little_are_refused_with_the_reason() {
    let folder = tempfile::tempdir().unwrap();
    let urdf = std::fs::read_to_string(shipped("fingertips.urdf")).unwrap();
    let urdf = urdf.replace("../pads", shipped("../pads").to_str().unwrap());
    let refused = |from: &str, to: &str, more: &str| {
        assert!(urdf.contains(from), "{from}");
        let path = folder.path().join("changed.urdf");
        std::fs::write(&path, urdf.replacen(from, to, 1)).unwrap();
        scene(folder.path(), &format!("robot: (path: {path:?}, {SOFT}), {more}")).unwrap_err()
    };
    let block = |tag: &str| {
        let start = urdf.find(&format!("<{tag}>")).unwrap();
        &urdf[start..urdf.find(&format!("</{tag}>")).unwrap() + tag.len() + 3]
    };
    for (message, reason) in [
        (refused("<youngs value=\"2e5\"/>", "<youngs value=\"\"/>", ""), "<youngs value=\"\">: 0 numbers; 1 needed"),
        (refused("<poissons value=\"0.45\"/>", "", ""), "\"left_pad\" has no <poissons value"),
        (
            refused(block("collision"), "<none/>", ""),
            "<link name=\"left_pad\"> is not fixed to a link with a <collision>",
        ),
        (refused(block("fem"), "<none/>", ""), "for one of the links \"left_pad\" and \"right_pad\", not for both"),
        (
            refused("attachDistance value=\"2e-4\"", "attachDistance value=\"0.05\"", ""),
            "all 363 nodes of the pad are bonded",
        ),
        (refused("fingertip.tet", "nothing.tet", ""), "nothing.tet"),
        (refused("<robot", "<robot", "material: Preset(\"biotac\")"), "the material is already defined by the robot"),
    ] {
        assert!(message.contains(reason) && message.contains("scene.ron:"), "{message}");
    }
}

/// A Franka hand for Isaac Gym: its file writes 1.57 for right angles, has different gels on its pads, and an opening
/// of 80 mm.
#[test]
fn a_hand_of_isaac_gym_is_read() {
    let Some(pads) = data("pads/round_pad") else { return };
    let urdf = std::fs::read_to_string(pads.join("franka_panda_fem_simple_v4_with_arm.urdf")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    // Replaces the paths of its meshes, the missing mesh of the fingers, and an invalid number.
    let mesh = pads.join("round_pad.tet");
    let urdf = urdf.replace("../meshes/custom/round_pad.tet", mesh.to_str().unwrap()).replace("1e9.0", "1e9");
    let shape = "franka_description/meshes/custom/full_fillet_finger.obj";
    let urdf = urdf.replace(shape, "plate.obj").replace("value=\"0.01\"", "value=\"1e-6\"");
    // The face of the finger under the pad.
    let corners = ["-1 0.003 -1", "1 0.003 -1", "1 0.003 1", "-1 0.003 1"].map(|v| format!("v {v}\n")).concat();
    std::fs::write(folder.path().join("plate.obj"), format!("{corners}f 1 2 3 4\n")).unwrap();
    std::fs::write(folder.path().join("hand.urdf"), urdf).unwrap();
    let hand = "hand: \"panda_hand\", pads: (\"panda_left_finger_pad\", \"panda_right_finger_pad\")";
    let scene = scene(folder.path(), &format!("robot: (path: \"hand.urdf\", {hand})")).unwrap();
    for part in ["opening: 0.08", "stroke: 0.04", "outward: (0.0, 0.0, 1.0)", "young: 1552230.93", "young: 200000.0"] {
        assert!(scene.contains(part), "{part} is in {scene}");
    }
}

fn fingertips(changes: &[(&str, &str)]) -> Result<(), String> {
    let folder = tempfile::tempdir().unwrap();
    let mut urdf = std::fs::read_to_string(shipped("fingertips.urdf")).unwrap();
    urdf = urdf.replace("../pads", shipped("../pads").to_str().unwrap());
    for (from, to) in changes {
        assert!(urdf.contains(from), "{from}");
        urdf = urdf.replace(from, to);
    }
    std::fs::write(folder.path().join("tips.urdf"), urdf).unwrap();
    scene(folder.path(), &format!("robot: (path: \"tips.urdf\", {SOFT})")).map(|_| ())
}

/// A surface flattened by its scale would bond only nodes in its plane, or none, so it is refused.
#[test]
fn shapes_without_volume_and_words_that_are_no_numbers_are_refused_with_their_place() {
    let mesh = "core.obj\"/>";
    for (from, to, reason) in [
        (mesh, "core.obj\" scale=\"0 0 0\"/>", "and therefore no volume; each factor must be nonzero"),
        (mesh, "core.obj\" scale=\"1 1 0\"/>", "and therefore no volume"),
        (mesh, "core.obj\" scale=\"nan 1 1\"/>", "tips.urdf:8:"),
        (mesh, "core.obj\" scale=\"nan 1 1\"/>", "\"nan\" is not a number"),
        ("xyz=\"0 0 0.1\" rpy", "xyz=\"0 oops 0 0.1\" rpy", "<origin xyz=\"0 oops 0 0.1\">: \"oops\" is not a number"),
        ("xyz=\"0 0 0.1\" rpy", "xyz=\"0,0 0 0 0.1\" rpy", "\"0,0\" is not a number"),
        ("xyz=\"0 0 0.1\" rpy", "xyz=\"0 0 0 0.1\" rpy", "4 numbers; 3 needed"),
        ("rpy=\"1.57 0 0\"", "rpy=\"90 0 0\"", "angles are in radians here, 90 degrees are 1.5707963"),
        ("rpy=\"1.57 0 0\"", "rpy=\"inf 0 0\"", "\"inf\" is not a number"),
    ] {
        let message = fingertips(&[(from, to)]).unwrap_err();
        assert!(message.contains(reason), "{reason:?} is not in: {message}");
    }
}

/// A mirrored core is accepted: the core is symmetric, so its mirror image bonds the same nodes unless its orientation
/// is inverted.
#[test]
fn a_mirrored_shape_is_the_mirror_image_and_not_inside_out() {
    fingertips(&[("core.obj\"/>", "core.obj\" scale=\"-1 1 1\"/>")]).unwrap();
}

/// A ROS package has descriptions and meshes in separate folders; `file://` precedes a path.
#[test]
fn meshes_are_found_in_packages_and_by_file_uris() {
    let folder = tempfile::tempdir().unwrap();
    let urdf = std::fs::read_to_string(shipped("fingertips.urdf")).unwrap();
    let pads = shipped("../pads").canonicalize().unwrap();
    let write = |path: &str, root: &str| {
        let path = folder.path().join(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, urdf.replace("../pads", root)).unwrap();
        scene(folder.path(), &format!("robot: (path: {path:?}, {SOFT})")).map(|_| ())
    };
    let copy = |to: &str| copy_pads(&folder.path().join(to));
    copy("tips_description/meshes");
    write("tips_description/urdf/p.urdf", "package://tips_description/meshes").expect("the folder has its name");
    write("arm_description/urdf/p.urdf", "package://tips_description/meshes").expect("it lies beside another one");
    copy("checkout/meshes");
    let manifest = "<package format=\"3\">\n  <name> fingers </name>\n</package>";
    std::fs::write(folder.path().join("checkout/package.xml"), manifest).unwrap();
    write("checkout/urdf/p.urdf", "package://fingers/meshes").expect("its package.xml has its name");
    write("uri.urdf", &format!("file://{}", pads.display())).expect("file:// is stripped");
    let message = write("none.urdf", "package://nowhere/meshes").unwrap_err();
    assert!(
        message.contains("not found in a package \"nowhere\"") && message.contains("ROS_PACKAGE_PATH"),
        "{message}"
    );
}

/// Copies the meshes of a pad and of its core into the new folder `folder`.
fn copy_pads(folder: &Path) {
    std::fs::create_dir_all(folder).unwrap();
    for name in ["fingertip.tet", "core.obj"] {
        std::fs::copy(shipped("../pads").join(name), folder.join(name)).unwrap();
    }
}

/// `ROS_PACKAGE_PATH` lists packages and folders of packages. Without it the package is not found.
#[test]
fn packages_are_found_in_the_path_of_ros() {
    let folder = tempfile::tempdir().unwrap();
    let urdf = std::fs::read_to_string(shipped("fingertips.urdf")).unwrap();
    std::fs::write(folder.path().join("p.urdf"), urdf.replace("../pads", "package://tips/meshes")).unwrap();
    copy_pads(&folder.path().join("workspace/src/tips/meshes"));
    let refused = scene(folder.path(), &format!("robot: (path: \"p.urdf\", {SOFT})")).unwrap_err();
    assert!(refused.contains("not found in a package \"tips\""), "{refused}");
    let found = |listed: &[&str]| {
        let listed = listed.iter().map(|root| folder.path().join(root));
        let checked = Command::new(env!("CARGO_BIN_EXE_tactus"))
            .args(["check", "scene.ron"])
            .current_dir(folder.path())
            .env("ROS_PACKAGE_PATH", std::env::join_paths(listed).unwrap())
            .output();
        checked.unwrap().status.code() == Some(0)
    };
    assert!(found(&["missing", "workspace/src"]), "a folder that holds the package");
    assert!(found(&["workspace/src/tips"]), "the package itself");
    assert!(!found(&["workspace"]), "not two folders below");
}
