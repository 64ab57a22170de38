//! Data sets, runs and pages of two different pads: each pad has its own mesh and results.

use crate::report::{checked, data_of, good, numbers, tactus, text};
use glam::DVec3;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use tactus::dataset::inspect::frame;
use tactus::dataset::{DataSet, ObjectFile};
use tactus::record::{Frame, PadTopology, meshes, read};

/// A box with a coarse mesh and a disc with a finer one of more nodes, with different gels.
const SCENE: &str = "(object: (shape: Sphere(radius: 0.012)), grasps: Antipodal(count: 4, seed: 1),
    gripper: (pads: Box(size: (0.02, 0.016, 0.004), cells: (4, 4, 2)), material: NeoHookean(young: 1e5, poisson: 0.45),
              right: (pads: Disc(radius: 0.01, thickness: 0.003, spacing: 2.8e-3), material: NeoHookean(young: 4e5, poisson: 0.45))),
    loading: Squeeze(force: 4, frames: 2), record: (pictures: false), expect: [ReachesForce])";

struct Made {
    dir: tempfile::TempDir,
    scene: PathBuf,
    data: PathBuf,
    run: PathBuf,
}

/// One data set and one run of its first grasp for all tests.
static MADE: LazyLock<Made> = LazyLock::new(|| {
    let dir = tempfile::tempdir().unwrap();
    let [scene, data, run] = ["pads.ron", "data", "run"].map(|name| dir.path().join(name));
    std::fs::write(&scene, SCENE).unwrap();
    good(&["dataset", text(&scene), "-o", text(&data)]);
    good(&["run", text(&scene), "--grasp", "0", "-o", text(&run)]);
    Made { dir, scene, data, run }
});

fn set() -> DataSet {
    let set = DataSet::open(&MADE.data).unwrap();
    assert!(set.damaged.is_empty(), "{:?}", set.damaged);
    set
}

/// Pads and frames of the run.
fn run() -> (Vec<PadTopology>, Vec<Frame>) {
    let pads = meshes::read(&MADE.run, 2).unwrap().0;
    let nodes: Vec<usize> = pads.iter().map(|pad| pad.rest.len()).collect();
    let frames = read::frames(&MADE.run.join("grasp_000/arrays.npz"), &nodes).unwrap();
    (pads, frames)
}

/// Largest distance between corresponding vectors of two fields.
fn apart(a: &[DVec3], b: &[DVec3]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

#[test]
fn a_data_set_holds_both_pads_as_they_were_run() {
    let (set, (pads, frames)) = (set(), run());
    let file = &set.objects[0];
    assert_eq!(file.pads, pads, "the meshes of the run to the bit");
    let [left, right] = pads.as_slice() else { panic!("two pads") };
    assert!(left.rest.len() < right.rest.len(), "{} nodes and {}", left.rest.len(), right.rest.len());
    let grasp = file.grasp(0).unwrap();
    assert_eq!(grasp.frames, frames.len());
    for (k, was) in frames.iter().enumerate() {
        for (is, was) in frame(file, &grasp, k).pads.iter().zip(&was.pads) {
            // Displacements of up to 1e-3 m, forces of up to 1 N and stresses of up to 1e5 Pa in single precision.
            assert!(apart(&is.displacement, &was.displacement) < 1e-9, "displacements, m");
            assert!(apart(&is.position, &was.position) < 1e-9, "positions, m");
            assert!(apart(&is.contact_force, &was.contact_force) < 1e-6, "contact forces, N");
            let stress = is.von_mises_node.iter().zip(&was.von_mises_node).map(|(a, b)| (a - b).abs());
            assert!(stress.fold(0.0, f64::max) < 0.05, "stresses, Pa");
        }
        // Padding of the rows of the smaller pad.
        let beyond = &grasp.displacement[3 * (2 * k * right.rest.len() + left.rest.len())..]
            [..3 * (right.rest.len() - left.rest.len())];
        assert!(beyond.iter().all(|u| *u == 0.0), "rows of the smaller pad end in zeros");
    }
}

#[test]
fn the_array_of_other_loaders_holds_the_corners_of_both() {
    let (set, (pads, frames)) = (set(), run());
    let file = hdf5_pure::File::open(&set.objects[0].path).unwrap();
    let positions = file.dataset("_1_stacked_positions").unwrap();
    let corners: usize = pads.iter().map(|pad| pad.corner_count).sum();
    assert_eq!(positions.shape().unwrap()[2..], [corners as u64, 3]);
    // First grasp: the world frame of the array is the hand frame with permuted axes and a shifted origin.
    let rows: Vec<DVec3> = positions.read_f32().unwrap().as_chunks::<3>().0[..corners]
        .iter()
        .map(|p| DVec3::from_array(p.map(f64::from)))
        .collect();
    let hand = frames[0].pads.iter().zip(&pads).flat_map(|(frame, pad)| &frame.position[..pad.corner_count]);
    let turned: Vec<DVec3> = hand.map(|p| DVec3::new(p.y, p.z, p.x)).collect();
    let offset = rows[0] - turned[0];
    let moved: Vec<DVec3> = turned.iter().map(|p| *p + offset).collect();
    assert!(apart(&rows, &moved) < 1e-6, "corner nodes, m");
}

#[test]
fn a_data_set_is_inspected_and_drawn() {
    let pictures = MADE.dir.path().join("pictures");
    let told = good(&["dataset", "inspect", text(&MADE.data), "--pictures", text(&pictures)]);
    let nodes = set().objects[0].pads.iter().map(|pad| pad.rest.len()).max().unwrap();
    assert!(told.contains(&nodes.to_string()), "{nodes} nodes of the larger pad: {told}");
    assert_eq!(std::fs::read_dir(&pictures).unwrap().count(), 4, "a picture of every grasp");
}

/// First grasp and meshes of the page of `dir`.
fn shown(dir: &Path) -> (Value, Value) {
    let page = dir.with_extension("html");
    good(&["report", text(dir), "--grasps", "1", "-o", text(&page)]);
    let data = data_of(&std::fs::read_to_string(&page).unwrap());
    (data["grasps"][0].clone(), data["meshes"].clone())
}

fn shows(dir: &Path, file: &ObjectFile, truth: &Frame) {
    let (grasp, meshes) = shown(dir);
    let places: Vec<usize> = grasp["pads"].as_array().unwrap().iter().map(|p| p.as_u64().unwrap() as usize).collect();
    assert!(places.len() == 2 && places[0] != places[1], "a mesh each: {places:?}");
    let state = &grasp["states"][0];
    let ((u, step), (touching, _)) = (numbers(&state["displacement"]), numbers(&state["contact_force"]["nodes"]));
    let (forces, df) = numbers(&state["contact_force"]["values"]);
    let last = &forces[forces.len() - 3 * touching.len()..];
    let rest = places.iter().map(|place| numbers(&meshes[*place]["rest"]));
    let rest: Vec<(Vec<f64>, f64)> = rest.collect();
    let all: usize = rest.iter().map(|(rest, _)| rest.len()).sum();
    let mut first = 0;
    for (k, ((rest, coarse), pad)) in rest.iter().zip(&file.pads).enumerate() {
        let own = &u[u.len() - all + 3 * first..][..rest.len()];
        let rotation = file.pad_poses[k].rotation;
        for (x, u) in rest.as_chunks::<3>().0.iter().zip(own.as_chunks::<3>().0) {
            let near = |n: &usize| (pad.rest[*n] - DVec3::from_array(*x)).abs().max_element() <= 1.01 * coarse;
            let node = (0..pad.rest.len()).find(near).expect("a node of this pad");
            let off =
                (rotation.inverse() * truth.pads[k].displacement[node] - DVec3::from_array(*u)).abs().max_element();
            assert!(off <= 1.01 * step + 1e-9, "pad {k}, node {node}: off by {off} m, the step is {step} m");
        }
        let nodes = first..first + rest.len() / 3;
        let on_pad =
            || touching.iter().zip(last.as_chunks::<3>().0).filter(|(node, _)| nodes.contains(&(**node as usize)));
        let force: DVec3 = on_pad().map(|(_, force)| DVec3::from_array(*force)).sum();
        let off = (rotation * force - truth.pads[k].wrench.force).abs().max_element();
        assert!(off <= 1.1 * df * on_pad().count() as f64 + 1e-4, "pad {k}: {force} N on the page, {off} N off");
        first = nodes.end;
    }
}

#[test]
fn pages_of_the_run_and_of_the_data_set_show_both_pads() {
    let (set, (_, frames)) = (set(), run());
    let file = &set.objects[0];
    shows(&MADE.run, file, frames.last().unwrap());
    let (grasp, _) = shown(&MADE.data);
    let number: usize = grasp["name"].as_str().unwrap().rsplit(' ').next().unwrap().parse().unwrap();
    let stored = file.grasp(number).unwrap();
    shows(&MADE.data, file, &frame(file, &stored, stored.frames - 1));
}

#[test]
fn in_a_browser_both_pads_are_drawn() {
    let page = MADE.dir.path().join("browser.html");
    good(&["report", text(&MADE.run), "-o", text(&page)]);
    let Some((found, _)) = checked(&page) else { return };
    assert!(found["drawn"].as_f64().unwrap() > 0.05, "part of the picture that is not empty");
    assert_eq!((&found["glError"], &found["tip"]), (&Value::from(0), &Value::Bool(true)));
    for control in ["frame", "turn", "stress", "contact_force", "mesh", "gain", "open"] {
        assert_eq!(found["changes"][control], true, "{control} changes the picture");
    }
}

#[test]
fn a_training_refuses_them_with_the_line_of_the_scene() {
    let model = MADE.dir.path().join("model.ron");
    std::fs::write(&model, crate::gnn_made::SPEC).unwrap();
    let out = MADE.dir.path().join("model");
    for arguments in [
        &["train", text(&MADE.data), "--model", text(&model), "-o", text(&out)][..],
        &["eval", text(&MADE.data), "--model", "universe"],
        &["report", text(&MADE.data), "--model", "universe", "-o", text(&out)],
        &["predict", text(&MADE.scene)],
    ] {
        let output = tactus(arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        if arguments[0] == "predict" {
            assert!(said.contains("its two pads differ"), "{said}");
            continue;
        }
        assert!(said.contains("gripper.right: a network needs two identical pads"), "{arguments:?}: {said}");
        // The line in the scene that the object file stores.
        let scene = &set().objects[0].scene;
        let line =
            1 + scene.lines().position(|line| line.trim_start().starts_with("right:")).expect("the right finger");
        assert!(said.contains(&format!(".h5:{line}:")), "{arguments:?}: line {line} in {said}");
    }
}
