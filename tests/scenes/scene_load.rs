//! Valid scenes: the shipped ones, defaults, and alternative spellings.

use glam::{DQuat, DVec3};
use proptest::prelude::*;
use std::path::{Path, PathBuf};
use tactus::scene::*;

const SMALLEST: &str = "(object: (shape: Sphere(radius: 0.02)), loading: Squeeze(force: 15))";

fn scene_of(text: &str) -> Scene {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scene.ron");
    std::fs::write(&path, text).unwrap();
    load(&path).unwrap_or_else(|e| panic!("{e}")).scene
}

fn scenes(dir: &Path) -> Vec<PathBuf> {
    let files = std::fs::read_dir(dir).unwrap().map(|e| e.unwrap().path());
    let mut files: Vec<_> = files.filter(|p| p.extension().is_some_and(|e| e == "ron")).collect();
    files.sort();
    files
}

#[test]
fn every_shipped_scene_loads_says_what_it_is_and_survives_being_written_out() {
    let files = scenes(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes"));
    assert!(files.len() >= 6);
    for file in files {
        for scene in load_set(&file).unwrap_or_else(|e| panic!("{e}")).scenes.into_iter().map(|named| named.scene) {
            assert!(!scene.about.is_empty() && !scene.expect.is_empty(), "{}", file.display());
            assert_eq!(scene, scene_of(&to_ron(&scene).unwrap()), "{}", file.display());
            serde_json::to_string(&scene).unwrap();
        }
    }
}

#[test]
fn a_file_of_several_objects_is_one_scene_for_each() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("two.ron");
    let text = "(objects: [
        (name: \"ball\", object: (shape: Sphere(radius: 0.02))),
        (name: \"lemon\", object: (shape: Lemon()), grasps: Antipodal(count: 3))],
        grasps: List([(position: (0, 0, -0.1))]), split: (test: 0.5, seed: 3), loading: Squeeze(force: 15))";
    std::fs::write(&path, text).unwrap();
    let set = load_set(&path).unwrap();
    assert_eq!((set.split.test.get(), set.split.seed), (0.5, 3));
    assert!(matches!(set.scenes[0].scene.grasps, Grasps::List(_)), "grasps of the scene");
    assert!(matches!(set.scenes[1].scene.grasps, Grasps::Antipodal(_)), "grasps of its own");
    assert_eq!(load_object(&path, Some("lemon")).unwrap().scene, set.scenes[1].scene);
    let refused = |object| load_object(&path, object).unwrap_err().to_string();
    assert!(refused(None).contains("choose one with --object: ball, lemon"));
    assert!(refused(Some("pear")).contains("has no object \"pear\"; it has: ball, lemon"));
    // the only object of a file is named after the file
    let set = load_set(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/press_sphere.ron")).unwrap();
    assert_eq!(set.scenes[0].name.as_str(), "press-sphere");
}

/// Frames are at equal force steps from `from`, by default one step; the last frame is exactly at `force`.
#[test]
fn a_squeeze_begins_where_it_is_told() {
    let levels = |squeeze: &str| {
        scene_of(&format!("(object: (shape: Sphere(radius: 0.02)), loading: Squeeze({squeeze}))")).loading.levels()
    };
    assert_eq!(levels("force: 15, frames: 3"), [5.0, 10.0, 15.0]);
    assert_eq!(levels("force: 15, from: 9, frames: 3"), [9.0, 12.0, 15.0]);
    assert_eq!(levels("force: 15, from: 9, frames: 1"), [15.0]);
}

#[test]
fn defaults_survive_being_written_out() {
    let scene = scene_of(SMALLEST);
    let text = to_ron(&scene).unwrap();
    assert_eq!(scene, scene_of(&text), "{text}");
    assert_eq!(scene.gripper, Gripper::default());
    assert_eq!(scene.stepper, StepperChoice::Fem(Fem::default()));
    assert_eq!(
        (scene.grasps.clone(), scene.gravity, scene.record.clone()),
        (Grasps::Identity, None, Record::default())
    );
    assert_eq!(scene.loading.levels().len(), 50);
    assert_eq!(scene.loading.levels()[49], 15.0);
    // an empty group is the same as none
    let spelled =
        "Scene(object: (shape: Sphere(radius: 0.02)), loading: Squeeze(force: 15), gripper: (pads: GelSightMini()),
        stepper: Fem(tolerance: ()), record: (), expect: [])";
    assert_eq!(scene, scene_of(spelled));
}

#[test]
fn defaults_pass_their_own_checks() {
    // the printed scene is checked when it is read, and with it every default
    for shape in ["Lemon()", "Strawberry()", "Banana()", "Potato()", "Pear()", "Cuboid(size: (0.1, 0.1, 0.1))"] {
        let scene = scene_of(&SMALLEST.replace("Sphere(radius: 0.02)", shape));
        assert_eq!(scene, scene_of(&to_ron(&scene).unwrap()));
    }
    for pads in [
        "Disc(radius: 0.01, thickness: 0.004)",
        "Box(size: (0.02, 0.02, 0.004))",
        "Box(size: [0.02, 0.02, 0.004], cells: [8, 8, 4])",
    ] {
        let scene = scene_of(&SMALLEST.replacen('(', &format!("(gripper: (pads: {pads}),"), 1));
        assert_eq!(scene, scene_of(&to_ron(&scene).unwrap()));
    }
}

#[test]
fn vectors_and_rotations_have_two_spellings() {
    let with = |grasps: &str| {
        let scene = scene_of(&SMALLEST.replacen('(', &format!("(grasps: List([{grasps}]),"), 1));
        let Grasps::List(poses) = scene.grasps else { panic!("a list") };
        (poses[0].position.unwrap().dvec3(), poses[0].rotation.quat())
    };
    let (position, rotation) = with("(position: [1, -2.5, 3e-1], rotation: [0, 0, 0, 2])");
    assert_eq!(position, DVec3::new(1.0, -2.5, 0.3));
    assert_eq!(rotation, DQuat::from_xyzw(0.0, 0.0, 1.0, 0.0));
    assert_eq!(with("(position: (1, -2.5, 3e-1), rotation: (0, 0, 0, 2))"), (position, rotation));
    assert_eq!(with("(position: (1, -2.5, 3e-1))").1, DQuat::IDENTITY);
    // roll first, then pitch, then yaw, about fixed axes
    for text in ["RpyDeg((90, 0, 90))", "RpyDeg([90.0, 0, 90])", "RpyDeg( /* turned */ ( 90, 0, 90, ) )"] {
        let (_, q) = with(&format!("(position: (0, 0, 0), rotation: {text})"));
        assert!((q * DVec3::Y - DVec3::Z).length() < 1e-12 && (q * DVec3::X - DVec3::Y).length() < 1e-12, "{text}");
    }
}

#[test]
fn materials_come_down_to_young_and_poisson() {
    let close = |a: f64, b: f64| assert!((a - b).abs() <= 1e-9 * b, "{a} {b}");
    let gel = MaterialChoice::default().spec();
    assert_eq!((gel.law, gel.poisson), (Law::NeoHookean, 0.49));
    // E = 6 C10 for an incompressible gel; nu is 0.49 here
    close(gel.young, 0.435e6 * 1.49 / 1.5);
    let same = scene_of(&SMALLEST.replacen('(', "(gripper: (material: NeoHookeanC10(c10: 72500, poisson: 0.49)),", 1));
    assert_eq!(same.gripper.material.spec(), gel);
    assert_eq!(Preset::BioTac.spec().young, 1.552231e6);
    assert_eq!(Preset::TacGrasp.spec().poisson, 0.4);
}

#[test]
fn a_byte_order_mark_and_windows_lines_are_fine() {
    assert_eq!(scene_of(&format!("\u{feff}{}", SMALLEST.replace(", ", ",\r\n"))), scene_of(SMALLEST));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// A scene with any part cut out or replaced loads or gives an error, and never panics.
    #[test]
    fn damaged_scenes_never_panic(
        which in 0usize..100, at in 0.0f64..1.0, length in 0usize..30,
        put in "(\\PC{0,6}|[(){}\\[\\],:\"'/*#r\\\\\n-]{0,4}|NaN|inf|0x|1e400|\\.\\.=?|RpyDeg\\(|//|r#\")",
    ) {
        let files = scenes(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes"));
        let text = std::fs::read_to_string(&files[which % files.len()]).unwrap();
        let chars: Vec<char> = text.chars().collect();
        let start = (at * chars.len() as f64) as usize;
        let end = (start + length).min(chars.len());
        let damaged: String = chars[..start].iter().chain(&put.chars().collect::<Vec<_>>()).chain(&chars[end..]).collect();
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("scene.ron");
        std::fs::write(&path, damaged).unwrap();
        if let Err(e) = load(&path) {
            prop_assert!(e.to_string().starts_with("error: "));
        }
    }
}
