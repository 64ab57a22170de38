//! Data sets: a reader gets what was simulated, damage is reported, and other HDF5 readers can read them.

use crate::dataset_tiny::{Tiny, linear, quadratic};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::process::{Command, Output};
use tactus::backend::choose;
use tactus::dataset::arrays::{ARRAYS, NumberKind};
use tactus::dataset::inspect::frame;
use tactus::dataset::{DataSet, Manifest, ObjectFile};
use tactus::model::Model;
use tactus::model::grasp::grasp_poses;
use tactus::record::Frame;
use tactus::scene::load;
use tactus::world::run::{Observer, run_grasps};

fn inspect(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_tactus")).args(["dataset", "inspect"]).args(arguments).output().unwrap()
}

#[derive(Default)]
struct Frames(std::sync::Mutex<BTreeMap<usize, Vec<Frame>>>);

impl Observer for Frames {
    fn frame(&self, index: usize, frame: &Frame) -> tactus::base::error::Result<()> {
        self.0.lock().unwrap().entry(index).or_default().push(frame.clone());
        Ok(())
    }
}

#[test]
fn what_is_read_is_what_was_simulated_and_the_scene_rebuilds_the_model() {
    let set = quadratic().set();
    assert!(set.damaged.is_empty());
    for object in &set.objects {
        // Rebuilds the model from the text in the file alone.
        let path = quadratic().tiny.out("again.ron");
        std::fs::write(&path, &object.scene).unwrap();
        let scene = load(&path).unwrap().scene;
        let model = Model::build(&scene).unwrap();
        assert_eq!(*model.fingers[0].topology, object.pads[0], "the same pad to the bit");
        assert_eq!(*model.object.surface, object.object);
        let frames = Frames::default();
        let grasps: Vec<_> = grasp_poses(&scene).unwrap().into_iter().enumerate().collect();
        run_grasps(&model, choose(&scene).unwrap().as_ref(), &grasps, 1, &frames).unwrap();
        for (number, original) in frames.0.into_inner().unwrap() {
            let grasp = object.grasp(number).unwrap();
            assert_eq!((grasp.frames, grasp.reason.as_str()), (original.len(), ""));
            for (k, was) in original.iter().enumerate() {
                let is = frame(object, &grasp, k);
                assert_eq!((is.applied_force, &is.travel), (was.applied_force, &was.travel));
                assert_eq!((is.object_position, is.object_rotation), (was.object_position, was.object_rotation));
                for (a, b) in is.pads.iter().zip(&was.pads) {
                    let far = |p: &[glam::DVec3], q: &[glam::DVec3]| {
                        p.iter().zip(q).map(|(p, q)| p.distance(*q)).fold(0.0, f64::max)
                    };
                    // Displacements of up to 1e-2 m in single precision.
                    assert!(far(&a.position, &b.position) < 1e-9, "positions, m");
                    assert!(far(&a.contact_force, &b.contact_force) < 1e-6, "contact forces, N");
                    assert!((a.wrench.force - b.wrench.force).length() < 1e-12, "wrench, N");
                    let worst = a.von_mises_node.iter().zip(&b.von_mises_node).map(|(a, b)| (a - b).abs());
                    assert!(worst.fold(0.0, f64::max) < 1e-1, "stress of up to 1e6 Pa, Pa");
                }
            }
        }
        loader_world(object);
    }
    let missed = set.objects[1].grasp(1).unwrap();
    assert!(
        missed.frames == 0 && missed.reason.contains("does not touch the object within its stroke"),
        "{}",
        missed.reason
    );
    let all: usize = set.splits.poses.train.values().chain(set.splits.poses.test.values()).map(Vec::len).sum();
    assert_eq!(all, 6, "every pose is in one of the sets");
    let without = set.splits.without("box");
    assert_eq!(set.select(&without.test), [(1, 0), (1, 2)], "reached grasps only");
    assert!(!without.train.contains_key("box") && without.train.values().all(|poses| poses.len() == 3), "{without:?}");
    let single = set.splits.single("box").unwrap();
    assert_eq!((single.train.len(), single.test.len()), (1, 1));
    assert!(set.splits.single("nobody").is_none());
    assert!(set.splits.without("bo").test.is_empty(), "a part of a name is no family");
    let both: Vec<&String> = set.objects.iter().map(|object| &object.name).collect();
    let all = set.splits.without(&format!("{},{}", both[0], both[1]));
    assert!(all.train.is_empty() && all.test.len() == 2, "several names: {all:?}");
}

/// In the arrays for the public loader, the bonded nodes of both pads are those of its undeformed pads, translated
/// along its closing axis, to 2e-7 m.
fn loader_world(object: &ObjectFile) {
    let dir = object.path.parent().unwrap().parent().unwrap();
    let tet = std::fs::read_to_string(dir.join("tactile_sensor.tet")).unwrap();
    let nodes = tet.lines().filter(|l| l.starts_with('v')).map(|l| {
        let x: Vec<f64> = l.split_whitespace().skip(1).map(|x| x.parse().unwrap()).collect();
        assert_eq!(x.len(), 4, "four columns: the loader drops the last");
        [x[0], x[1], x[2]]
    });
    let nodes: Vec<_> = nodes.collect();
    let hand = |[x, y, z]: [f64; 3], left: bool| match left {
        true => [z - 0.0006, -y + 0.0275, x + 0.099],
        false => [-z - 0.0006, y - 0.0275, -x + 0.099],
    };
    let world = |[x, y, z]: [f64; 3]| [x, z + 1.0, -y];
    let file = hdf5_pure::File::open(&object.path).unwrap();
    let positions = file.dataset("_1_stacked_positions").unwrap().read_f32_rows(0, 1).unwrap();
    let (first, _) = positions.split_at(2 * nodes.len() * 3);
    for left in [true, false] {
        let own = if left { &first[..nodes.len() * 3] } else { &first[nodes.len() * 3..] };
        let mut carried = None;
        for (i, node) in nodes.iter().enumerate().filter(|(_, n)| n[1] == 0.0) {
            let rest = world(hand(*node, left));
            let shift = [0, 1, 2].map(|a| f64::from(own[3 * i + a]) - rest[a]);
            // Positions of about 1 m in single precision.
            assert!(shift[0].abs() < 2e-7 && shift[1].abs() < 2e-7, "node {i}, left {left}: off by {shift:?} m");
            let along = *carried.get_or_insert(shift[2]);
            assert!((shift[2] - along).abs() < 2e-7, "node {i} is carried by {} instead of {along} m", shift[2]);
        }
    }
}

#[test]
fn promises_of_the_scene_are_judged_on_every_grasp_and_the_worst_is_kept() {
    let out = linear().folder();
    let manifest = Manifest::read(&out).unwrap().unwrap();
    for (object, grasps) in manifest.objects.iter().zip([vec![0, 1, 2], vec![0, 2]]) {
        let [inversion, travel] = object.expectations.as_slice() else { panic!("{:?}", object.expectations) };
        assert!(inversion.worst.held && inversion.broken_by.is_empty(), "{inversion:?}");
        // The grasp that misses has no frames, so it violates no other expectation.
        assert_eq!(travel.broken_by, grasps);
        assert_eq!((travel.worst.held, &*travel.worst.unit), (false, "m"));
        let set = DataSet::open(&out).unwrap();
        let file = set.objects.iter().find(|f| f.name == object.name).unwrap();
        // Travel of both fingers at the last frame.
        let most = grasps.iter().flat_map(|g| file.grasp(*g).unwrap().travel[2..4].to_vec()).fold(0.0, f64::max);
        assert!((travel.worst.value.unwrap() / most - 1.0).abs() < 1e-12, "{:?} m, {most} m", travel.worst.value);
    }
}

#[test]
fn damage_is_named_and_the_rest_stays_usable() {
    let folder = linear().copy("damaged");
    let set = DataSet::open(&folder).unwrap();
    let [ball, brick] = [&set.objects[0].path, &set.objects[1].path];
    let mut bytes = std::fs::read(ball).unwrap();
    // Flips a bit within the displacements, which are located by their bytes.
    let whole = set.objects[0].grasp(1).unwrap();
    let needle: Vec<u8> = whole.displacement[300..310].iter().flat_map(|x| x.to_le_bytes()).collect();
    let at = bytes.windows(needle.len()).position(|w| w == needle).unwrap();
    bytes[at] ^= 1;
    std::fs::write(ball, &bytes).unwrap();
    let cut = std::fs::read(brick).unwrap();
    std::fs::write(brick, &cut[..cut.len() - 1]).unwrap();

    let set = DataSet::open(&folder).unwrap();
    assert_eq!(set.objects.len(), 1);
    let refused = set.damaged[0].to_string();
    assert!(refused.contains("box_") && refused.contains("truncated"), "{refused}");
    let error = set.objects[0].grasp(1).unwrap_err().to_string();
    assert!(error.contains("ball_") && error.contains("grasp 1 is damaged"), "{error}");
    assert!(set.objects[0].grasp(0).is_ok() && set.objects[0].grasp(2).is_ok(), "the other grasps are read");
    let out = inspect(&[folder.to_str().unwrap(), "--format", "json"]);
    assert_eq!(out.status.code(), Some(1));
    let json: Value = serde_json::from_slice(&out.stdout).unwrap();
    assert_eq!(json["inspection"]["damaged"].as_array().unwrap().len(), 2);
    // Within the first 4096 bytes, a changed byte never causes a panic, and a cut gives an error.
    for at in (0..4096.min(cut.len())).step_by(7) {
        let mut changed = cut.clone();
        changed[at] ^= 0x55;
        std::fs::write(brick, &changed).unwrap();
        let _ = ObjectFile::open(brick).map(|o| o.grasp(0));
        std::fs::write(brick, &cut[..at]).unwrap();
        assert!(ObjectFile::open(brick).is_err());
    }
}

#[test]
fn inspection_counts_and_draws() {
    let (out, pictures) = (linear().folder(), linear().tiny.out("pictures"));
    let all =
        inspect(&[out.to_str().unwrap(), "--pictures", pictures.to_str().unwrap(), "--every", "2", "--frames", "1"]);
    assert_eq!(all.status.code(), Some(0), "{}", String::from_utf8_lossy(&all.stderr));
    let text = String::from_utf8(all.stdout).unwrap();
    assert!(
        text.contains("2 objects, 6 grasps (5 reached)") && text.contains("box grasp 1 (0 frames): the left"),
        "{text}"
    );
    assert_eq!(std::fs::read_dir(&pictures).unwrap().count(), 4, "grasps 0 and 2 of each object");
    let none = inspect(&[linear().tiny.dir.path().to_str().unwrap()]);
    assert_eq!(none.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&none.stderr).contains("contains no data set"));
}

#[test]
fn another_hdf5_reader_finds_what_is_documented() {
    for object in &quadratic().set().objects {
        let arrays = ARRAYS.iter().map(|a| {
            let shape: Vec<_> = std::iter::once(object.sizes.grasps).chain(a.row_shape(&object.sizes)).collect();
            let kind = match a.kind {
                NumberKind::U8 => "uint8",
                NumberKind::U32 => "uint32",
                NumberKind::F32 => "float32",
                NumberKind::F64 => "float64",
            };
            (a.name.to_string(), json!({"shape": shape, "dtype": kind, "unit": a.unit}))
        });
        let expected = Value::Object(arrays.collect());
        let script = r#"
import sys, json, h5py, numpy as np
with h5py.File(sys.argv[1], "r") as f:
    for name, want in json.loads(sys.argv[2]).items():
        d = f[name]
        got = {"shape": list(d.shape), "dtype": str(d.dtype), "unit": d.attrs["unit"].decode()}
        assert got == want, (name, got, want)
    for name in ["units", "hand_frame", "pad_frame", "force_convention", "scene", "young_pa", "poisson", "friction", "gravity_m_s2"]:
        assert name in f.attrs, name
    reached = f["status"][:] == 1
    assert np.allclose(f["_1_stacked_forces"][:][reached], f["force_n"][:][reached]), "forces"
    assert (f["_1_stacked_forces"][:][~reached] == 0).all()
    frame = f["_1_stacked_object_frame"][0, -1]
    assert abs(np.linalg.det(frame[:3, :3]) - 1) < 1e-6 and (frame[3] == [0, 0, 0, 1]).all()
print("ok")
"#;
        let python = Command::new("python3").args(["-c", "import h5py"]).output();
        if python.is_ok_and(|p| p.status.success()) {
            let path = object.path.to_str().unwrap();
            let out = Command::new("python3").args(["-c", script, path, &expected.to_string()]).output().unwrap();
            assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
            println!("{}: read by h5py", object.name);
        } else {
            let file = hdf5_pure::File::open(&object.path).unwrap();
            for (name, want) in expected.as_object().unwrap() {
                let dataset = file.dataset(name).unwrap();
                assert_eq!(json!(dataset.shape().unwrap()), want["shape"], "{name}");
                assert_eq!(dataset.attrs().unwrap()["unit"].as_str(), want["unit"].as_str(), "{name}");
            }
            println!("{}: h5py is not there; read by hdf5-pure", object.name);
        }
    }
}

/// The sensitivities of the grasps are written to a table in the folder of the data set; a second run adds rows to it.
#[test]
fn a_table_says_how_well_posed_the_grasps_are() {
    let tiny = Tiny::new("Linear");
    let out = tiny.out("posed");
    let table = |most: &str| {
        let done = tiny.command(&out).args(["--sensitivity", most]).output().unwrap();
        assert_eq!(done.status.code(), Some(1), "{}", String::from_utf8_lossy(&done.stderr));
        let report: Value = serde_json::from_slice(&done.stdout).unwrap();
        let text = std::fs::read_to_string(out.join("sensitivity.csv")).unwrap();
        (report["sensitivity"].as_array().unwrap().clone(), text)
    };
    let (first, text) = table("1");
    assert_eq!(first.len(), 8, "four changes of one grasp of two objects");
    assert!(
        text.starts_with("# plan ")
            && text.contains("object,grasp,change,status,displacement,object_m\nball,0,friction,reached,")
    );
    for row in &first {
        let displacement = row["displacement"].as_f64().unwrap();
        assert!(displacement.is_finite() && displacement >= 0.0, "{row}");
    }
    let (both, _) = table("2");
    assert_eq!(both.len(), 16);
    assert!(first.iter().all(|row| both.contains(row)));
    // A grasp that misses has a row without a value for every change.
    let missed = both.iter().filter(|row| row["object"] == "box" && row["grasp"] == 1);
    assert!(missed.clone().count() == 4 && missed.clone().all(|row| row["displacement"].is_null()));
    assert!(DataSet::open(&out).unwrap().damaged.is_empty());
}
