//! Grippers that a robot's description names: URDF and MJCF say what a scene could spell out.

use crate::skipped::data;
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
        (changed("upper=\"0.04\"", "upper=\"1e9.0\""), "line 15: upper=\"1e9.0\" is no number"),
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

const SOFT: &str = "hand: \"hand\", pads: (\"left_pad\", \"right_pad\")";

/// Isaac Gym's `<fem>` names mesh, gel and the distance from the finger's shape within which nodes are bonded.
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
        let (mut a, mut b) = (read.gripper.like(side), spelt.gripper.like(side));
        let pads = [&mut a.pads, &mut b.pads].map(std::mem::take);
        assert_eq!(a, b, "gel, friction, opening, stroke and place of finger {side}");
        let [a, b] = pads.map(|pads| tactus::part::pad::build(&pads, &mut Vec::new()).unwrap().0);
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
        (refused("<youngs value=\"2e5\"/>", "<youngs value=\"\"/>", ""), "has <youngs value=\"\">; a number is needed"),
        (refused("<poissons value=\"0.45\"/>", "", ""), "\"left_pad\" has no <poissons"),
        (refused(block("collision"), "<none/>", ""), "\"left_pad\" is fixed to no link with a <collision>"),
        (refused(block("fem"), "<none/>", ""), "for one of the links \"left_pad\" and \"right_pad\", not for both"),
        (
            refused("attachDistance value=\"2e-4\"", "attachDistance value=\"0.05\"", ""),
            "all 363 nodes of the pad are glued",
        ),
        (refused("fingertip.tet", "nothing.tet", ""), "nothing.tet"),
        (refused("<robot", "<robot", "material: Preset(\"biotac\")"), "the robot says what the material is"),
    ] {
        assert!(message.contains(reason) && message.contains("scene.ron:"), "{message}");
    }
}

/// A Franka hand of Isaac Gym: its file says 1.57 for right angles, gives the two pads different gels, and closes by 80 mm.
#[test]
fn a_hand_of_isaac_gym_is_read() {
    let Some(pads) = data("pads/round_pad") else { return };
    let urdf = std::fs::read_to_string(pads.join("franka_panda_fem_simple_v4_with_arm.urdf")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    // Its meshes lie elsewhere, that of the fingers is not here, and a number of it is none.
    let mesh = pads.join("round_pad.tet");
    let urdf = urdf.replace("../meshes/custom/round_pad.tet", mesh.to_str().unwrap()).replace("1e9.0", "1e9");
    let shape = "franka_description/meshes/custom/full_fillet_finger.obj";
    let urdf = urdf.replace(shape, "plate.obj").replace("value=\"0.01\"", "value=\"1e-6\"");
    // The face of the finger that the pad lies on.
    let corners = ["-1 0.003 -1", "1 0.003 -1", "1 0.003 1", "-1 0.003 1"].map(|v| format!("v {v}\n")).concat();
    std::fs::write(folder.path().join("plate.obj"), format!("{corners}f 1 2 3 4\n")).unwrap();
    std::fs::write(folder.path().join("hand.urdf"), urdf).unwrap();
    let hand = "hand: \"panda_hand\", pads: (\"panda_left_finger_pad\", \"panda_right_finger_pad\")";
    let scene = scene(folder.path(), &format!("robot: (path: \"hand.urdf\", {hand})")).unwrap();
    for part in ["opening: 0.08", "stroke: 0.04", "outward: (0.0, 0.0, 1.0)", "young: 1552230.93", "young: 200000.0"] {
        assert!(scene.contains(part), "{part} is in {scene}");
    }
}
