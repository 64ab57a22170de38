//! Files of a run: complete, readable, valid after an interruption, free of NaN.

use crate::synthetic::{frame, pads, sphere};
use glam::DVec3;
use ndarray::{Array1, Array2, Array3};
use ndarray_npy::NpzReader;
use std::collections::BTreeMap;
use std::fs::{File, read, read_to_string};
use std::path::Path;
use std::time::Duration;
use tactus::record::{Frame, GraspSummary, PadTopology, RunReport, Status};
use tactus::world::run::{RecordingOptions, RunRecorder};

fn report() -> RunReport {
    RunReport::new("fem", 2, serde_json::json!({ "about": "test" }))
}

fn options() -> RecordingOptions {
    RecordingOptions { object_name: "sphere".into(), flush_after: Duration::ZERO, ..RecordingOptions::default() }
}

fn ramp(pads: &[PadTopology], frames: usize) -> Vec<Frame> {
    (0..frames).map(|i| frame(pads, i, 1e-3 * (i + 1) as f64 / frames as f64)).collect()
}

/// Records a complete run of one grasp into `dir`.
fn record(dir: &Path, pads: &[PadTopology], frames: &[Frame]) -> RunReport {
    let mut recorder = RunRecorder::create(dir, options(), report()).expect("created");
    let mut grasp = recorder.begin_grasp(0, pads, &sphere(12, crate::synthetic::RADIUS)).expect("begun");
    let mut summary = GraspSummary::new(Status::Reached, None);
    for frame in frames {
        grasp.frame(frame).expect("recorded");
        summary.observe(frame);
    }
    recorder.end_grasp(grasp, summary).expect("ended");
    recorder.finish(Vec::new(), BTreeMap::from([("solve".into(), 1.5)])).expect("finished")
}

#[test]
fn arrays_read_back_equal() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let (pads, nodes) = (pads(true), 2 * pads(true)[0].rest.len());
    let frames = ramp(&pads, 3);
    record(dir.path(), &pads, &frames);
    let mut npz = NpzReader::new(File::open(dir.path().join("grasp_000/arrays.npz")).expect("there")).expect("npz");
    for (name, field) in [("displacement_m", 0), ("position_m", 1), ("contact_force_n", 2)] {
        let array: Array3<f64> = npz.by_name(name).expect(name);
        assert_eq!(array.shape(), [3, nodes, 3]);
        let of = |f: &Frame| -> Vec<DVec3> {
            let pick = |p: &tactus::record::PadFrame| [&p.displacement, &p.position, &p.contact_force][field].clone();
            f.pads.iter().flat_map(pick).collect()
        };
        let wanted: Vec<f64> = frames.iter().flat_map(of).flat_map(|v| v.to_array()).collect();
        assert!(array.iter().eq(&wanted), "{name} is bit for bit what was recorded");
    }
    let stress: Array2<f64> = npz.by_name("von_mises_pa").expect("von_mises_pa");
    assert_eq!(stress[[2, nodes - 1]], *frames[2].pads[1].von_mises_node.last().expect("nodes"));
    let tets: Array2<u32> = npz.by_name("tets").expect("tets");
    assert_eq!(tets.shape(), [2 * pads[0].elements.len(), 10]);
    assert_eq!(*tets.iter().max().expect("tets") as usize, nodes - 1, "tets count nodes over both pads");
    let pose: Array2<f64> = npz.by_name("object_pose").expect("object_pose");
    let q = frames[0].object_rotation;
    assert_eq!(pose.row(0).to_vec(), [0.0, 0.0, 0.1, q.w, q.x, q.y, q.z]);
    let force: Array1<f64> = npz.by_name("force_n").expect("force_n");
    assert_eq!(force.to_vec(), frames.iter().map(|f| f.applied_force).collect::<Vec<_>>());
    let wrench: Array3<f64> = npz.by_name("wrench").expect("wrench");
    assert_eq!(wrench[[1, 1, 0]], frames[1].pads[1].wrench.force.x);
    let bonded: Array1<bool> = npz.by_name("bonded").expect("bonded");
    assert_eq!(bonded.iter().filter(|b| **b).count(), 2 * pads[0].bonded.iter().filter(|b| **b).count());
}

#[test]
fn csv_and_json_read_back_exactly_beside_a_picture() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let pads = pads(false);
    let frames = ramp(&pads, 4);
    let returned = record(dir.path(), &pads, &frames);
    let text = read_to_string(dir.path().join("grasp_000/frames.csv")).expect("csv");
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().expect("header").split(',').collect();
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 4);
    assert!(rows.iter().all(|row| row.len() == header.len()));
    let column = |name: &str| header.iter().position(|h| *h == name).unwrap_or_else(|| panic!("no column {name}"));
    let number = |row: usize, name: &str| rows[row][column(name)].parse::<f64>().expect("a number");
    for (row, frame) in frames.iter().enumerate() {
        assert_eq!(number(row, "force_n"), frame.applied_force);
        assert_eq!(number(row, "travel_left_m"), frame.travel[0]);
        assert_eq!(number(row, "travel_right_m"), frame.travel[1]);
        assert_eq!(number(row, "contact_force_right_x_n"), frame.pads[1].wrench.force.x);
        assert_eq!(number(row, "newton_iterations"), 3.0);
        assert_eq!(number(row, "min_gap_m"), 2e-5);
        assert_eq!(number(row, "object_qy"), frame.object_rotation.y);
    }
    let peak = frames[3].pads[0].von_mises_node.iter().copied().fold(0.0, f64::max);
    assert_eq!(number(3, "max_von_mises_left_pa"), peak);

    // The documented keys are those of a run in `run_cli.rs`.
    let text = read_to_string(dir.path().join("run.json")).expect("json");
    assert_eq!(text, returned.to_json().expect("finite"));
    let json: serde_json::Value = serde_json::from_str(&text).expect("valid");
    assert_eq!((&json["backend"], &json["finished"]), (&"fem".into(), &true.into()));
    assert_eq!(json["profile_s"]["solve"], 1.5);
    let grasp = &json["grasps"][0];
    assert_eq!((&grasp["status"], grasp["frames"].as_u64()), (&"reached".into(), Some(4)));
    assert_eq!(grasp["newton_iterations"], 12, "the sum over the frames");
    assert!(dir.path().join("grasp_000/pads.png").metadata().expect("picture").len() > 10_000);
}

#[test]
fn an_interrupted_run_leaves_readable_files() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let pads = pads(false);
    let recorder = RunRecorder::create(dir.path(), options(), report()).expect("created");
    let mut grasp = recorder.begin_grasp(0, &pads, &sphere(8, crate::synthetic::RADIUS)).expect("begun");
    for frame in ramp(&pads, 3) {
        grasp.frame(&frame).expect("recorded");
    }
    let npz_frames = || {
        let file = File::open(dir.path().join("grasp_000/arrays.npz")).expect("there");
        NpzReader::new(file)
            .expect("npz")
            .by_name::<ndarray::OwnedRepr<f64>, ndarray::Ix1>("force_n")
            .expect("force_n")
            .len()
    };
    // State after a kill at this point: the arrays have at least the first frame, all other files have all three.
    assert!((1..=3).contains(&npz_frames()));
    let pvd = read_to_string(dir.path().join("grasp_000/run.pvd")).expect("pvd");
    assert!(pvd.trim_end().ends_with("</VTKFile>"));
    let named: Vec<&str> = pvd.split("file=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    assert_eq!(named.len(), 6);
    for file in named {
        let text = read_to_string(dir.path().join("grasp_000").join(file)).expect("named file exists");
        assert!(text.ends_with("</VTKFile>\n"), "{file} is complete");
    }
    assert_eq!(read_to_string(dir.path().join("grasp_000/frames.csv")).expect("csv").lines().count(), 4);
    let json: serde_json::Value =
        serde_json::from_slice(&read(dir.path().join("run.json")).expect("json")).expect("valid");
    assert_eq!(json["finished"], false);
    // After an error (the recorder is dropped), the arrays have all frames, too.
    drop(grasp);
    assert_eq!(npz_frames(), 3);
    let left_over = std::fs::read_dir(dir.path().join("grasp_000")).expect("dir").flatten();
    assert!(left_over.map(|e| e.file_name()).all(|n| !n.to_string_lossy().ends_with(".part")));
}

#[test]
fn what_is_not_finite_or_does_not_fit_is_refused_by_name() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let pads = pads(false);
    let mut recorder = RunRecorder::create(dir.path(), options(), report()).expect("created");
    let mut grasp = recorder.begin_grasp(0, &pads, &sphere(8, crate::synthetic::RADIUS)).expect("begun");
    let good = frame(&pads, 0, 1e-3);
    let mut refused = |change: &dyn Fn(&mut Frame), words: &[&str]| {
        let mut bad = good.clone();
        change(&mut bad);
        let message = grasp.frame(&bad).expect_err("refused").to_string();
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    };
    refused(&|f| f.pads[1].displacement[5].y = f64::NAN, &["frame 0", "right", "displacement[5]", "grasp_000"]);
    refused(&|f| f.min_gap = f64::INFINITY, &["frame 0", "min_gap", "inf"]);
    refused(&|f| f.travel[1] = f64::NAN, &["travel[1]"]);
    refused(&|f| f.pads[0].von_mises_element.truncate(3), &["von_mises_element has 3 entries", "tetrahedra"]);
    refused(&|f| f.pads.truncate(1), &["pads has 1"]);
    refused(&|f| f.index = 4, &["frame 4 recorded, frame 0 is next"]);
    assert!(!dir.path().join("grasp_000/frames/frame_0000.vtu").exists(), "nothing of a refused frame is written");
    let summary = GraspSummary { wall_s: f64::NAN, ..GraspSummary::new(Status::Fault, Some("diverged".into())) };
    let message = recorder.end_grasp(grasp, summary).expect_err("refused").to_string();
    assert!(message.contains("grasp 0: wall_s"), "{message}");
    let mut torn = pads.clone();
    torn[1].surface[0][2] = 9999;
    let message = recorder.begin_grasp(1, &torn, &sphere(8, 0.01)).expect_err("refused").to_string();
    assert!(message.contains("pad 1 (right): surface refers to node 9999"), "{message}");
}

#[test]
fn a_file_in_the_way_is_an_actionable_error() {
    let dir = tempfile::tempdir().expect("temporary directory");
    let file = dir.path().join("out");
    std::fs::write(&file, "").expect("written");
    for target in [file.clone(), file.join("deeper")] {
        let message = RunRecorder::create(&target, options(), report()).expect_err("refused").to_string();
        assert!(message.contains("choose another output directory"), "{message}");
    }
}

#[test]
fn the_same_frames_write_the_same_bytes() {
    let (one, two) = (tempfile::tempdir().expect("dir"), tempfile::tempdir().expect("dir"));
    let pads = pads(true);
    let frames = ramp(&pads, 2);
    record(one.path(), &pads, &frames);
    record(two.path(), &pads, &frames);
    let files = ["arrays.npz", "frames.csv", "run.pvd", "pads.png", "frames/frame_0001.vtu", "frames/object_0000.vtu"];
    for file in files {
        let bytes = |dir: &Path| read(dir.join("grasp_000").join(file)).expect(file);
        assert_eq!(bytes(one.path()), bytes(two.path()), "{file}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_says_so() {
    let full = Path::new("/dev/full");
    let message = tactus::record::csv::FramesCsv::create(full, 2, false, false).expect_err("refused").to_string();
    assert!(message.contains("/dev/full") && message.contains("disk or your quota is full"), "{message}");
}
