//! Array names and units are those that `docs/data-format.md` lists, in `arrays.npz`, `meshes.npz`, `.vtu`,
//! `frames.csv` and data sets.

use ndarray::Array2;
use ndarray_npy::NpzReader;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::path::Path;
use std::process::Command;
use std::sync::LazyLock;
use tactus::dataset::arrays::ARRAYS;
use tactus::record::names;

/// Row of the table of arrays: unit, and shape in `arrays.npz`, data sets and `tactus.run` (empty where the array does
/// not occur).
struct Row {
    unit: String,
    places: [String; 3],
}

fn documented() -> BTreeMap<String, Row> {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/data-format.md")).unwrap();
    let table = text.split("\n## Arrays").nth(1).and_then(|rest| rest.split("\n## ").next()).unwrap();
    let rows = table.lines().filter(|line| line.starts_with("| `"));
    let row = |line: &str| {
        let cells: Vec<String> = line.replace("\\|", "").split('|').map(|cell| cell.trim().to_string()).collect();
        assert_eq!(cells.len(), 8, "{line}");
        let places = [3, 4, 5].map(|k| cells[k].clone());
        (cells[1].trim_matches('`').to_string(), Row { unit: cells[2].clone(), places })
    };
    rows.map(row).collect()
}

#[test]
fn every_name_is_listed_and_ends_in_its_unit() {
    let listed = documented();
    for (name, unit) in names::ALL {
        let row = listed.get(*name).unwrap_or_else(|| panic!("docs/data-format.md does not list {name}"));
        assert_eq!(row.unit, *unit, "{name}");
        let ending = match *unit {
            "m" => "_m",
            "N" => "_n",
            "Pa" => "_pa",
            "s" => "_s",
            "J" => "_j",
            _ => continue,
        };
        assert!(name.ends_with(ending), "{name} is in {unit}");
    }
    for array in ARRAYS {
        let row = listed.get(array.name).unwrap_or_else(|| panic!("docs/data-format.md does not list {}", array.name));
        assert_eq!(row.unit, array.unit, "{}", array.name);
        assert!(row.places[1].starts_with("(G"), "{} is in data sets", array.name);
    }
    let in_sets = listed.iter().filter(|(_, row)| row.places[1].starts_with("(G")).count();
    assert_eq!(in_sets, ARRAYS.len(), "no more than there are");
    assert_eq!(listed.values().filter(|row| !row.places[2].is_empty()).count(), 25, "tactus.run gives 25 arrays");
}

fn run(scene: &str, dir: &Path) {
    let path = dir.join("scene.ron");
    std::fs::write(&path, scene).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_tactus"));
    let output = command.arg("run").arg(&path).arg("-o").arg(dir.join("run")).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
}

fn archive(path: &Path) -> BTreeSet<String> {
    let mut npz = NpzReader::new(File::open(path).unwrap()).unwrap();
    npz.names().unwrap().iter().map(|n| n.trim_end_matches(".npy").to_string()).collect()
}

const SQUEEZE: &str = "(object: (shape: Sphere(radius: 0.02)), gripper: (pads: GelSightMini(spacing: 8e-3)),
    loading: Squeeze(force: 2.0, frames: 2),
    record: (fields: [Displacement, Stress, ContactForce, Gap, ObjectPose], pictures: false))";

/// Folder with a run of [`SQUEEZE`], shared by tests.
static SQUEEZED: LazyLock<tempfile::TempDir> = LazyLock::new(|| {
    let dir = tempfile::tempdir().unwrap();
    run(SQUEEZE, dir.path());
    dir
});

#[test]
fn a_run_writes_the_listed_names_and_no_others() {
    let (listed, dir) = (documented(), &*SQUEEZED);
    let grasp = dir.path().join("run/grasp_000");
    let wanted = |moving: bool| -> BTreeSet<String> {
        let here = listed.iter().filter(|(_, r)| !r.places[0].is_empty() && (moving || !r.places[0].ends_with('*')));
        here.map(|(name, _)| name.clone()).collect()
    };
    assert_eq!(archive(&grasp.join("arrays.npz")), wanted(false));
    let pad = ["rest_m", "tets", "surface", "sensing", "bonded"].map(|name| format!("pad/{name}"));
    let object = ["vertices_m", "triangles"].map(|name| format!("object/{name}"));
    assert_eq!(archive(&dir.path().join("run/meshes.npz")), pad.into_iter().chain(object).collect::<BTreeSet<_>>());
    for name in ["rest_m", "tets", "surface", "sensing", "bonded", "vertices_m", "triangles"] {
        let place = &listed[name].places[1];
        assert!(place.starts_with("pad ") || place.starts_with("object "), "{name}: {place}");
    }

    let csv = std::fs::read_to_string(grasp.join("frames.csv")).unwrap();
    let columns: Vec<&str> = csv.lines().next().unwrap().split(',').collect();
    let bare = ["frame", "newton_iterations", "min_det_f", "force_balance", "torque_balance"];
    let unit = |c: &str| ["_m", "_n", "_pa", "_s", "_j", "_n_m"].iter().any(|u| c.ends_with(u));
    let turn = |c: &str| ["_qw", "_qx", "_qy", "_qz"].iter().any(|q| c.ends_with(q));
    assert!(columns.iter().all(|c| bare.contains(c) || unit(c) || turn(c)), "{columns:?}");
    for name in ["force_n", "time_s", "energy_j", "residual_n", "min_gap_m", "min_det_f", "force_balance"] {
        assert!(columns.contains(&name) && listed.contains_key(name), "{name}");
    }

    let vtu = std::fs::read_to_string(grasp.join("frames/frame_0001.vtu")).unwrap();
    let fields = vtu.split("Name=\"").skip(1).map(|rest| rest.split('"').next().unwrap());
    let structure = ["pad", "Points", "connectivity", "offsets", "types"];
    let fields: BTreeSet<&str> = fields.filter(|name| !structure.contains(name)).collect();
    let wanted = ["contact_force_n", "displacement_m", "element_von_mises_pa", "gap_m", "von_mises_pa"];
    assert_eq!(fields, BTreeSet::from(wanted));
}

#[test]
fn dynamic_scenes_add_what_is_marked() {
    let dir = tempfile::tempdir().unwrap();
    run(
        "(object: (shape: Sphere(radius: 0.02)), gripper: (pads: GelSightMini(spacing: 8e-3)), gravity: (0, 0, -9.81),
          loading: Dynamic(motions: [Close(force: 2.0, duration: 0.02)], time_step: 2e-3, frames: 1), record: (pictures: false))",
        dir.path(),
    );
    let found = archive(&dir.path().join("run/grasp_000/arrays.npz"));
    let marked: BTreeSet<String> =
        documented().into_iter().filter(|(_, r)| r.places[0].ends_with('*')).map(|(name, _)| name).collect();
    assert_eq!(marked, BTreeSet::from(["ground_force_n", "hand_pose", "object_motion"].map(String::from)));
    assert!(marked.is_subset(&found), "{found:?}");
}

#[test]
fn rest_and_displacement_meet_in_the_hand() {
    let mut npz = NpzReader::new(File::open(SQUEEZED.path().join("run/grasp_000/arrays.npz")).unwrap()).unwrap();
    let rest: Array2<f64> = npz.by_name("rest_m").unwrap();
    let pose: Array2<f64> = npz.by_name("pad_pose").unwrap();
    let (position, displacement): (ndarray::Array3<f64>, ndarray::Array3<f64>) =
        (npz.by_name("position_m").unwrap(), npz.by_name("displacement_m").unwrap());
    let pad: ndarray::Array1<u32> = npz.by_name("pad_of_node").unwrap();
    // Rigid displacement of each pad: a translation along x, the closing direction, equal for all its nodes to 1e-12 m.
    let mut carried = [None; 2];
    for (i, pad) in pad.iter().enumerate() {
        let p = pose.row(*pad as usize);
        let q = glam::DQuat::from_xyzw(p[4], p[5], p[6], p[3]);
        let at = q * glam::DVec3::new(rest[[i, 0]], rest[[i, 1]], rest[[i, 2]]) + glam::DVec3::new(p[0], p[1], p[2]);
        let moved = glam::DVec3::from_array([0, 1, 2].map(|k| position[[1, i, k]] - displacement[[1, i, k]])) - at;
        let known = *carried[*pad as usize].get_or_insert(moved);
        assert!((moved - known).length() < 1e-12 && moved.y.abs() < 1e-12 && moved.z.abs() < 1e-12, "{moved}");
    }
    assert!(carried[0].unwrap().x > 1e-3 && carried[1].unwrap().x < -1e-3, "{carried:?}");
}

#[test]
fn a_fixed_object_is_written_once() {
    let objects = |motion: &str| {
        let dir = tempfile::tempdir().unwrap();
        run(&SQUEEZE.replace("(radius: 0.02))", &format!("(radius: 0.02), {motion})")), dir.path());
        let grasp = dir.path().join("run/grasp_000");
        let files = std::fs::read_dir(grasp.join("frames")).unwrap().flatten();
        let count = files.filter(|f| f.file_name().to_string_lossy().starts_with("object_")).count();
        (count, std::fs::read_to_string(grasp.join("run.pvd")).unwrap().matches("frames/object_0000.vtu").count())
    };
    assert_eq!(objects("motion: Fixed"), (1, 2), "one file, in both frames of the collection");
}

/// Rows of the table of tactile arrays: name, then unit and shape.
fn tactile() -> BTreeMap<String, (String, String)> {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/data-format.md")).unwrap();
    let table = text.split("\n## Tactile arrays").nth(1).and_then(|rest| rest.split("\n## ").next()).unwrap();
    let row = |line: &str| {
        let cells: Vec<String> = line.split('|').map(|cell| cell.trim().to_string()).collect();
        assert_eq!(cells.len(), 6, "{line}");
        (cells[1].trim_matches('`').to_string(), (cells[2].clone(), cells[3].clone()))
    };
    table.lines().filter(|line| line.starts_with("| `")).map(row).collect()
}

const TACTILE: &str = "tactile: [TaxelForce(rows: 5, cols: 3), TaxelDisplacement(rows: 5, cols: 3), Pressure(rows: 5, cols: 3),
    Shear(rows: 5, cols: 3), HeightMap(rows: 5, cols: 3), DepthMap(rows: 5, cols: 3), Markers(rows: 5, cols: 3), CenterOfPressure,
    ContactArea, Slip(rows: 5, cols: 3)]";

#[test]
fn tactile_arrays_are_those_that_are_listed_and_asked_for() {
    let dir = tempfile::tempdir().unwrap();
    run(&SQUEEZE.replace("pictures: false", &format!("{TACTILE}, pictures: false")), dir.path());
    let grasp = dir.path().join("run/grasp_000/arrays.npz");
    let listed = tactile();
    let plain: BTreeSet<String> = documented().into_keys().collect();
    let found: BTreeSet<String> = archive(&grasp).difference(&plain).cloned().collect();
    assert_eq!(found, listed.keys().cloned().collect::<BTreeSet<_>>());
    let mut npz = NpzReader::new(File::open(&grasp).unwrap()).unwrap();
    for (name, (unit, shape)) in &listed {
        let single = !unit.contains(',') && unit != "1";
        assert!(!single || name.ends_with(&format!("_{}", unit.to_lowercase())), "{name} is in {unit}");
        let array: ndarray::ArrayD<f32> = npz.by_name(name).unwrap();
        let sizes = shape.trim_matches(['(', ')']).split(", ").map(|size| match size {
            "F" | "P" => 2,
            "R" => 5,
            "C" => 3,
            number => number.parse().unwrap(),
        });
        assert_eq!(array.shape(), sizes.collect::<Vec<usize>>(), "{name}");
        assert!(array.iter().any(|v| *v != 0.0) || name == "slip", "{name}");
    }
}
