//! Each invalid scene gives one message with the error, its place (line and column) and the allowed values.

use std::path::Path;
use tactus::scene::load;

const OBJECT: &str = "object: (shape: Sphere(radius: 0.02)),";
const LOADING: &str = "loading: Squeeze(force: 15),";

/// Loads `text` as `broken.ron` in an empty folder and returns the error.
fn error_of(text: impl AsRef<[u8]>) -> String {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("broken.ron");
    std::fs::write(&path, text).unwrap();
    load(&path).expect_err("this scene must be refused").to_string()
}

/// Asserts that a scene whose line 3 is `line` gives an error at `3:column` that contains all of `says`.
#[track_caller]
fn line_three(line: &str, column: usize, says: &[&str]) {
    refused(&format!("(\n{OBJECT}{LOADING}\n{line}\n)"), 3, column, says);
}

#[track_caller]
fn refused(text: &str, line: usize, column: usize, says: &[&str]) {
    let error = error_of(text);
    assert!(error.starts_with("error: "), "{error}");
    assert!(error.contains(&format!("broken.ron:{line}:{column}\n")), "expected {line}:{column} in\n{error}");
    for part in says {
        assert!(error.contains(part), "expected {part:?} in\n{error}");
    }
    for jargon in ["Expected", "Unexpected", "struct ", "variant", "r#", "unsigned"] {
        assert!(!error.contains(jargon), "parser jargon {jargon:?} in\n{error}");
    }
}

#[test]
fn unknown_fields_list_the_allowed_ones() {
    line_three(
        "  colour: 3,",
        3,
        &["unknown field `colour` in Scene", "allowed: include, about, object, objects, universe, split, gripper"],
    );
    line_three("gripper: (openning: 0.08),", 11, &["did you mean `opening`?", "in Gripper"]);
    line_three("stepper: Fem(tolerance: (torque: 1)),", 26, &["in Tolerance", "allowed: force, displacement"]);
    line_three("record: (png: true),", 10, &["in Record", "allowed: fields, tactile, pictures, arrays, vtu"]);
    line_three("grasps: Antipodal(count: 3, sed: 4),", 29, &["did you mean `seed`?"]);
}

/// The error on a field of a former version names its replacement.
#[test]
fn former_fields_name_their_successors() {
    line_three(
        "gripper: (pads: File(path: \"a.tet\", attach_distance: 1e-3)),",
        37,
        &["unknown field `attach_distance` in File", "`bonded: Plane(within: ...)`"],
    );
}

/// Parentheses that hold one value have no fields; the message shows the correct place of a field.
#[test]
fn fields_beside_a_single_value_are_shown_their_place() {
    let beside = "fields of object are written next to `shape`: `shape: Mesh(...), scale: ...`";
    let says = &["object.shape: `Mesh(...)` takes one value and has no field `scale`", beside];
    refused(&format!("(object: (shape: Mesh(\"a.obj\", scale: 1e-3)),\n{LOADING})"), 1, 32, says);
    refused(&format!("(object: (shape: Mesh(scale: 1e-3, \"a.obj\")),\n{LOADING})"), 1, 23, says);
    line_three(
        "grasps: List(position: (0, 0, 0)),",
        14,
        &["grasps: `List(...)` takes one value and has no field `position`"],
    );
}

#[test]
fn poses_have_one_place() {
    let says = &["grasps[1]: a pose needs `position`", "or `centre`", "for any rotation of the hand"];
    line_three("grasps: List([(centre: (0, 0, 0)), (rotation: (1, 0, 0, 0))]),", 36, says);
    line_three("grasps: List([(centre: (0, 0, 0)), (position: (0, 0, 0), centre: (0, 0, 0))]),", 36, says);
}

#[test]
fn only_files_are_repaired() {
    let text = format!("(object: (shape: Sphere(radius: 0.02), repair: true),\n{LOADING})");
    refused(&text, 1, 48, &["only a surface from a file can be repaired", "shape: Mesh("]);
}

#[test]
fn unknown_names_list_the_allowed_ones() {
    let text = format!("(object: (shape: Spher(radius: 1)),\n{LOADING})");
    refused(&text, 1, 18, &["unknown Shape `Spher`", "did you mean `Sphere`?", "Mesh, Sphere, Cuboid"]);
    line_three("gripper: (fingers: Three),", 20, &["unknown Fingers `Three`", "allowed: Both, One, None"]);
    line_three("expect: [ForceBallance(relative: 1)],", 10, &["did you mean `ForceBalance`?"]);
    line_three(
        "gripper: (material: Preset(\"jelly\")),",
        28,
        &["\"jelly\"", "\"gelsight_mini\", \"tacgrasp\", \"biotac\""],
    );
    refused(&format!("Scen(\n{OBJECT}{LOADING})"), 1, 1, &["expected `Scene(...)`, found `Scen`"]);
}

#[test]
fn numbers_that_are_none_are_refused() {
    for number in ["NaN", "inf", "-inf", "1e999", "NaNf64", "inff64"] {
        let text = format!("(object: (shape: Sphere(radius: {number})),\n{LOADING})");
        refused(&text, 1, 33, &["object.shape.radius: must be a finite number"]);
        line_three(&format!("gravity: (0, 0, {number}),"), 17, &["gravity[2]: must be a finite number"]);
    }
    line_three("grasps: List([(position: (0, 0, 0), rotation: (NaN, 0, 0, 1))]),", 48, &["must be a finite number"]);
}

#[test]
fn material_constants_are_checked() {
    let material = |young: &str, nu: &str| format!("gripper: (material: NeoHookean(young: {young}, poisson: {nu})),");
    line_three(
        &material("1e5", "0.5"),
        53,
        &["below 0.5, found 0.5", "use 0.49 (mean dilatation handles up to 0.499)"],
    );
    line_three(&material("1e5", "-1"), 53, &["above -1"]);
    line_three(&material("-1e5", "0.4"), 39, &["gripper.material.young: must be above zero, found -100000"]);
    line_three(&material("0.435", "0.4"), 39, &["0.435 MPa is 435000"]);
    line_three("gripper: (friction: -0.1),", 21, &["gripper.friction: must be zero or above"]);
}

#[test]
fn lengths_in_millimetres_are_noticed() {
    let text = format!("(object: (shape: Sphere(radius: 20)),\n{LOADING})");
    refused(&text, 1, 33, &["lengths are in metres: 20 mm is 0.02"]);
    refused(&text.replace("20", "0"), 1, 33, &["must be above zero"]);
}

#[test]
fn counts_are_whole_and_bounded() {
    for (frames, found) in [("0", "found 0"), ("-3", "found `-3`"), ("2.5", "found `2.5`"), ("10001", "found 10001")] {
        let text = format!("({OBJECT}\nloading: Squeeze(force: 1, frames: {frames}))");
        refused(&text, 2, 36, &["loading.frames", "a whole number from 1 to 10000", found]);
    }
}

#[test]
fn wrong_types_name_the_field() {
    let text = format!("(object: (shape: Sphere(radius: \"big\")),\n{LOADING})");
    refused(&text, 1, 33, &["object.shape.radius: expected a number, found `\"big\"`"]);
    line_three("about: 3,", 8, &["about: expected a string in double quotes, found `3`"]);
    line_three("record: (pictures: 1),", 20, &["record.pictures: expected `true` or `false`"]);
    line_three("expect: NoInversion,", 9, &["expect: expected a list `[...]`, found `NoInversion`"]);
    line_three("gravity: 9.81,", 10, &["gravity: expected 3 numbers (x, y, z), found `9.81`"]);
    line_three("gravity: (0, 9.81),", 10, &["gravity: expected 3 numbers (x, y, z), found only 2"]);
    line_three("gravity: (0, 0, 0, 1),", 10, &["expected 3 numbers, found more"]);
    line_three("grasps: File(3),", 14, &["expected a path in quotes"]);
}

#[test]
fn rotations_are_checked() {
    let pose = |rotation: &str| format!("grasps: List([(position: (0, 0, 0), rotation: {rotation})]),");
    line_three(&pose("(0, 0, 0, 0)"), 47, &["grasps[0].rotation: a quaternion of length zero", "(w, x, y, z)"]);
    line_three(&pose("(1, 0, 0)"), 47, &["a rotation (w, x, y, z) or RpyDeg"]);
    line_three(&pose("(1, 0, 0, 0, 0)"), 47, &["expected four numbers"]);
    line_three(&pose("RpyRad((0, 0, 1))"), 47, &["unknown form of rotation `RpyRad`", "RpyDeg((roll, pitch, yaw))"]);
    line_three(&pose("((0, 0, 1))"), 47, &["a rotation by angles needs a name"]);
    line_three(&pose("RpyDeg(1, 0, 0, 0)"), 47, &["double parentheses"]);
}

#[test]
fn missing_fields_are_named_at_the_closing_bracket() {
    refused(&format!("(\n{OBJECT}\n)"), 3, 1, &["missing field `loading`"]);
    refused(&format!("(\n{LOADING}\n)"), 3, 1, &["missing field `object`"]);
    refused(
        &format!("(object: (shape: Cylinder(radius: 0.1)),{LOADING})"),
        1,
        38,
        &["missing field `height` in Cylinder"],
    );
    refused(&format!("(object: (shape: Sphere),{LOADING})"), 1, 18, &["`Sphere` needs its fields: Sphere(...)"]);
}

#[test]
fn syntax_slips_are_explained() {
    refused(&format!("(\n{OBJECT}\n{OBJECT}\n{LOADING})"), 3, 1, &["field `object` is given twice"]);
    refused(&format!("({OBJECT}\nloading: Squeeze(force: 15 N))"), 2, 28, &["expected `,` before `N`", "no unit"]);
    refused(
        &format!("({OBJECT}\nloading: Squeeze(force: 15)\ngravity: (0, 0, 1))"),
        3,
        1,
        &["expected `,` before `gravity`"],
    );
    refused(&format!("({OBJECT}\n{LOADING}"), 2, 29, &["ends too early", "`)` or `]` is missing"]);
    refused(&format!("({OBJECT}\n{LOADING}) x"), 2, 31, &["unexpected text after the end"]);
    refused("{\"object\": 3}", 1, 1, &["expected the fields of Scene"]);
    refused("", 1, 1, &["the scene is empty", "a minimal scene"]);
    refused("// nothing yet\n", 1, 1, &["the scene is empty"]);
}

#[test]
fn fields_that_do_not_go_together_are_named() {
    let object = |shape: &str| format!("(object: (shape: {shape}),\n{LOADING})");
    refused(&object("Annulus(outer: 0.01, inner: 0.02, height: 0.1)"), 1, 46, &["object.shape.inner: the hole"]);
    refused(&object("Cuboid(size: (0.1, 0.1, 0.02), edge_radius: 0.02)"), 1, 62, &["edge_radius", "at most 0.01"]);
    refused(&object("Cup(radius: 0.03, height: 0.1, wall: 0.03)"), 1, 55, &["leaves no cavity"]);
    refused(
        &object("Revolve(profile: [(0, 0), (0.1, 0.1)])"),
        1,
        44,
        &["profile[1]: a profile starts and ends on the axis"],
    );
    refused(
        &object("Sweep(path: [(0, 0, 0), (0, 0, 1), (0, 1, 1)], radii: [0.1, 0.1])"),
        1,
        72,
        &["2 radii for 3 points"],
    );
    line_three("gripper: (fingers: One),", 20, &["cannot hold a free object", "motion: Fixed"]);
    line_three(
        "gripper: (pads: Box(size: (0.1, 0.1, 0.1), cells: (1, 1, 1), spacing: 0.1)),",
        51,
        &["give one of them"],
    );
    line_three("expect: [NoInversion, Travel()],", 23, &["expect[1]: Travel needs at_least, at_most or both"]);
    line_three("expect: [Force(at_least: 2, at_most: 1)],", 10, &["no value satisfies both"]);
    line_three("grasps: List([]),", 14, &["an empty list of grasps"]);
    line_three("grasps: Antipodal(count: 3, tilt_deg: 95),", 39, &["grasps.tilt_deg: must be at most 90 degrees"]);
}

#[test]
fn lists_of_objects_are_checked() {
    let ball = "(name: \"ball\", object: (shape: Sphere(radius: 0.02)))";
    let set = |objects: &str| format!("(objects: [\n{objects}],\nloading: Squeeze(force: 5))");
    refused(&set(&format!("{ball},\n{ball}")), 3, 8, &["objects[1].name: two objects are named \"ball\""]);
    refused(&set(&ball.replace("ball", "a_b")), 2, 8, &["is not a valid name of an object", "no `_`"]);
    refused(&set(&ball.replace("ball", "")), 2, 8, &["is not a valid name of an object"]);
    refused("(objects: [], loading: Squeeze(force: 5))", 1, 11, &["an empty list of objects"]);
    let both = format!("(objects: [{ball}],\n{OBJECT}{LOADING})");
    refused(&both, 1, 11, &["object and objects are both given"]);
    let tube = "(name: \"tube\", object: (shape: Annulus(outer: 0.01, inner: 0.02, height: 0.03)))";
    refused(&set(&format!("{ball},\n{tube}")), 3, 60, &["objects[1].object.shape.inner: the hole"]);
    let mesh = "(name: \"m\", object: (shape: Mesh(\"none.obj\")))";
    refused(&set(mesh), 2, 34, &["objects[0].object.shape", "no file at"]);
}

#[test]
fn a_squeeze_begins_below_its_force() {
    let text = format!("({OBJECT}\nloading: Squeeze(force: 6, from: 6))");
    refused(&text, 2, 34, &["loading.from: the first frame is at 6 N, the last at 6 N", "allowed: below force"]);
}

#[test]
fn presses_are_checked() {
    let press = |arguments: &str| format!("({OBJECT}\nloading: Press({arguments}))");
    refused(&press(""), 2, 10, &["a press needs `depth` or `depths`"]);
    refused(&press("depth: 1e-3, depths: [1e-3]"), 2, 37, &["give one of them"]);
    refused(&press("depths: [1e-3, 1e-3]"), 2, 31, &["loading.depths[1]: depths must increase"]);
    refused(&press("depths: [1e-3], frames: 4"), 2, 40, &["`depths` already defines"]);
    refused(&press("depth: 0.1"), 2, 10, &["longer than the finger's stroke (0.04 m)"]);
}

#[test]
fn files_that_are_named_must_exist() {
    let text = format!("(object: (shape: Mesh(\"nowhere.obj\")),\n{LOADING})");
    refused(&text, 1, 23, &["object.shape: no file at", "nowhere.obj", "are relative to the folder of the scene file"]);
    line_three("grasps: File(\"no.h5\"),", 14, &["no file at"]);
    line_three("grasps: File(path: \".\"),", 20, &["is a directory"]);
    line_three("gripper: (pads: File(path: \"no.tet\", outward: (0, 1, 0))),", 28, &["gripper.pads.path: no file at"]);
}

#[test]
fn selections_are_checked() {
    let select = |s: &str| format!("grasps: File(path: \"broken.ron\", select: {s}),");
    line_three(&select("0..=3"), 42, &["an inclusive range (`=`) is not supported here", "write 0..10"]);
    line_three(&select("[]"), 42, &["selects no grasp"]);
    line_three(&select("[0, -1]"), 46, &["expected a whole number"]);
    assert!(error_of(format!("({OBJECT}{LOADING}{})", select("5..5"))).contains("range 5..5 selects no grasp"));
    assert!(error_of(format!("({OBJECT}{LOADING}{})", select("5.."))).contains("has no end"));
}

#[test]
fn files_that_are_no_text_are_refused() {
    assert!(error_of([0x89, b'H', 0, 1, 2]).contains("is not a text file (zero byte at offset 2)"));
    assert!(error_of(b"(about: \"\n\xff\xfe\")").contains("is not UTF-8 text (line 2, byte offset 10)"));
    assert!(error_of(vec![b' '; 16 * 1024 * 1024 + 1]).contains("is larger than 16 MiB"));
    let dir = tempfile::tempdir().unwrap();
    assert!(load(dir.path()).unwrap_err().to_string().contains("is a directory"));
    assert!(
        load(dir.path().join("none.ron")).unwrap_err().to_string().contains("none.ron: cannot be opened: no such file")
    );
    assert!(load(Path::new("")).unwrap_err().to_string().contains("no such file"));
}

#[test]
fn deep_nesting_does_not_overflow_the_stack() {
    for open in ["(", "[", "{", "Some(", "/*", "(gravity: ((", "\"\\"] {
        let n = 1_000_000 / open.len();
        error_of(open.repeat(n));
        error_of(format!("(gravity: {}", open.repeat(n)));
        error_of(format!("(expect: [Force(at_most: {}", open.repeat(n)));
        error_of(format!("(grasps: File({}", open.repeat(n)));
        error_of(format!("(grasps: List([(position: (0,0,0), rotation: {}", open.repeat(n)));
    }
}

#[test]
fn words_of_motion_are_checked() {
    let dynamic = |motions: &str| format!("(\n{OBJECT}\nloading: Dynamic(motions: [{motions}]),\n)");
    refused(
        &dynamic("Hop(duration: 1)"),
        3,
        28,
        &["unknown Motion `Hop`", "Close, Lift, Move, Hold, Shake, Rotate, Repeat"],
    );
    refused(&dynamic("Hold(duration: 0)"), 3, 43, &["must be above zero"]);
    refused(&dynamic("Hold(duration: 2000)"), 3, 43, &["must be at most 1000 s", "2000 ms is 2"]);
    refused(&dynamic("Lift(height: 0.1, duration: 1)"), 3, 28, &["a lift needs gravity", "Move(by: (x, y, z), ...)"]);
    refused(&dynamic("Close(force: -1, duration: 1)"), 3, 41, &["must be zero or above"]);
    refused(
        &dynamic("Rotate(angle_deg: 9, axis: (0, 0, 0), duration: 1)"),
        3,
        55,
        &["a direction of length zero", "(0, 0, 1) is along +z"],
    );
    refused(&dynamic("Repeat(times: 3, motions: [])"), 3, 28, &["repeats an empty list of motions"]);
    refused(&dynamic(""), 3, 27, &["an empty list of motions", "Hold(duration: 0.5)"]);
    line_three("ground: Plane(),", 9, &["only a dynamic scene has this", "loading: Dynamic"]);
    line_three("expect: [ObjectHeld(slip_at_most: 1e-3)],", 10, &["ObjectHeld needs loading: Dynamic"]);
    line_three("gripper: (fingers: None),", 20, &["this loading needs fingers"]);
    let text =
        format!("({OBJECT} gripper: (fingers: None),\nloading: Dynamic(motions: [Close(force: 1, duration: 1)]))");
    refused(&text, 2, 27, &["this motion needs fingers"]);
    let object = "object: (shape: Sphere(radius: 0.02), motion: Fixed, spin: (0, 0, 1)),";
    refused(
        &format!("({object}\nloading: Dynamic(motions: [Hold(duration: 1)]))"),
        1,
        48,
        &["a fixed object has neither"],
    );
}
