//! Includes: merging, precedence, and invalid includes.

use std::path::Path;
use tactus::scene::{Loading, ObjectShape, Pads, load};

fn write(dir: &Path, name: &str, text: &str) {
    std::fs::write(dir.join(name), text).unwrap();
}

#[test]
fn the_including_file_wins_and_later_includes_win_over_earlier_ones() {
    let dir = tempfile::tempdir().unwrap();
    write(dir.path(), "a.ron", "(about: \"a\", object: (shape: Sphere(radius: 0.01)), loading: Squeeze(force: 1))");
    write(dir.path(), "b.ron", "(about: \"b\", loading: Squeeze(force: 2))");
    write(dir.path(), "main.ron", "(include: [\"a.ron\", \"b.ron\"], about: \"main\")");
    let loaded = load(dir.path().join("main.ron")).unwrap();
    assert_eq!(loaded.scene.about, "main");
    assert!(matches!(loaded.scene.object.shape, ObjectShape::Sphere(s) if s.radius.get() == 0.01));
    assert!(matches!(loaded.scene.loading, Loading::Squeeze(s) if s.force.get() == 2.0));
    let names: Vec<_> = loaded.sources.iter().map(|p| p.file_name().unwrap().to_str().unwrap()).collect();
    assert_eq!(names, ["main.ron", "a.ron", "b.ron"]);
    assert_eq!(loaded.dir, dir.path());
}

#[test]
fn paths_start_at_the_file_that_names_them() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::create_dir(dir.path().join("parts")).unwrap();
    write(dir.path(), "parts/pad.tet", "");
    write(dir.path(), "parts/gripper.ron", "(gripper: (pads: File(\"pad.tet\")))");
    write(
        dir.path(),
        "main.ron",
        "(include: [\"parts/gripper.ron\"], object: (shape: Sphere(radius: 0.01)), loading: Squeeze(force: 1))",
    );
    let loaded = load(dir.path().join("main.ron")).unwrap();
    let pad = dir.path().join("parts/pad.tet");
    assert!(matches!(&loaded.scene.gripper.pads, Pads::File(f) if f.path == pad));
    write(
        dir.path(),
        "objects.ron",
        "(objects: [(name: \"ball\", object: (shape: Sphere(radius: 0.01)), gripper: (pads: File(\"parts/pad.tet\")))],
          loading: Squeeze(force: 1))",
    );
    let loaded = load(dir.path().join("objects.ron")).unwrap();
    assert!(matches!(&loaded.scene.gripper.pads, Pads::File(f) if f.path == pad));
}

#[test]
fn errors_point_into_the_file_that_gave_the_field() {
    let dir = tempfile::tempdir().unwrap();
    write(dir.path(), "grip.ron", "(\n  gripper: (fingers: One),\n)");
    write(
        dir.path(),
        "main.ron",
        "(include: [\"grip.ron\"], object: (shape: Sphere(radius: 0.01)), loading: Squeeze(force: 1))",
    );
    let error = load(dir.path().join("main.ron")).unwrap_err().to_string();
    assert!(error.contains("grip.ron:2:22\n"), "{error}");
    write(dir.path(), "grip.ron", "(\n  gripper: (finger: One),\n)");
    let error = load(dir.path().join("main.ron")).unwrap_err().to_string();
    assert!(error.contains("grip.ron:2:13\n") && error.contains("did you mean `fingers`?"), "{error}");
}

#[test]
fn circles_name_the_chain() {
    let dir = tempfile::tempdir().unwrap();
    write(dir.path(), "a.ron", "(\n include: [\"b.ron\"],\n)");
    write(dir.path(), "b.ron", "(\n include: [\"./a.ron\"],\n)");
    let error = load(dir.path().join("a.ron")).unwrap_err().to_string();
    assert!(error.contains("in a cycle: a.ron -> b.ron -> a.ron"), "{error}");
    assert!(error.contains("b.ron:2:12\n"), "{error}");
}

#[test]
fn too_deep_missing_and_too_many_includes_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    for i in 0..20 {
        write(dir.path(), &format!("{i}.ron"), &format!("(include: [\"{}.ron\"])", i + 1));
    }
    let error = load(dir.path().join("0.ron")).unwrap_err().to_string();
    assert!(error.contains("nested more than 16 deep: 0.ron -> 1.ron"), "{error}");
    let error = load(dir.path().join("15.ron")).unwrap_err().to_string();
    assert!(error.contains("include[0]: ") && error.contains("20.ron: cannot be opened: no such file"), "{error}");
    assert!(error.contains("19.ron:1:12\n"), "{error}");
    for i in 0..12 {
        write(dir.path(), &format!("{i}.ron"), &format!("(include: [\"{0}.ron\", \"{0}.ron\"])", i + 1));
    }
    write(dir.path(), "12.ron", "(about: \"\")");
    let error = load(dir.path().join("0.ron")).unwrap_err().to_string();
    assert!(error.contains("more than 256 files"), "{error}");
}
