//! Complete scenes: invariance under rotation of the object's frame and exchange of the fingers, force monotonic in
//! travel, the limit of small weight, and loss of an object that rotates out of the grasp.

use crate::common::Random;
use crate::keep::Keep;
use glam::{DQuat, DVec3};
use std::path::Path;
use tactus::backend::choose;
use tactus::geometry::mesh::TriMesh;
use tactus::geometry::mesh::io::write_obj;
use tactus::geometry::shape::ShapeKind;
use tactus::model::Model;
use tactus::model::grasp::grasp_poses;
use tactus::record::{Frame, Status};
use tactus::scene::load;
use tactus::world::run::run_grasps;

/// Runs the single grasp of a scene, which must reach its force, and returns its frames.
fn frames(path: &Path, text: &str) -> Vec<Frame> {
    let (status, reason, frames) = outcome(path, text);
    assert_eq!(status, Status::Reached, "{reason}");
    frames
}

/// Runs the single grasp of a scene and returns its status, the reason, and its frames.
fn outcome(path: &Path, text: &str) -> (Status, String, Vec<Frame>) {
    std::fs::write(path, text).unwrap();
    let scene = load(path).unwrap_or_else(|e| panic!("{e}")).scene;
    let model = Model::build(&scene).unwrap();
    let poses: Vec<_> = grasp_poses(&scene).unwrap().into_iter().enumerate().collect();
    let keep = Keep::default();
    let outcomes = run_grasps(&model, choose(&scene).unwrap().as_ref(), &poses, 2, &keep).unwrap();
    let summary = &outcomes[0].summary;
    (summary.status, summary.reason.clone().unwrap_or_default(), keep.0.into_inner().unwrap())
}

const GRIPPER: &str = "gripper: (pads: GelSightMini(spacing: 4e-3)), record: (fields: [])";

/// Returns the frames of a squeeze of an irregular object, its mesh file and the hand (at `hand`) rotated by `turn`.
fn turned(folder: &Path, turn: DQuat, hand: DQuat) -> Vec<Frame> {
    let kind = ShapeKind::Potato { semi_axes: DVec3::new(0.02, 0.024, 0.028), roughness: 0.05, seed: 3 };
    let surface = kind.build(32).unwrap().surface;
    let vertices = surface.vertices.iter().map(|v| turn * *v).collect();
    write_obj(folder.join("object.obj"), &TriMesh { vertices, triangles: surface.triangles.clone() }).unwrap();
    let q = turn * hand;
    let p = q * DVec3::new(0.0, 0.0, -0.1);
    let text = format!(
        "Scene(object: (shape: Mesh(\"object.obj\")), {GRIPPER}, loading: Squeeze(force: 8.0, frames: 3),
         stepper: Fem(tolerance: (force: 1e-5, displacement: 1e-6)),
         grasps: List([(position: ({:e}, {:e}, {:e}), rotation: ({:e}, {:e}, {:e}, {:e}))]))",
        p.x, p.y, p.z, q.w, q.x, q.y, q.z
    );
    frames(&folder.join("scene.ron"), &text)
}

/// Returns the largest difference of nodal displacements over the largest displacement; `swap` compares left and right.
fn difference(a: &[Frame], b: &[Frame], swap: bool) -> f64 {
    let half_turn = DQuat::from_rotation_z(std::f64::consts::PI);
    let (mut wrong, mut largest) = (0.0_f64, 0.0_f64);
    for (a, b) in a.iter().zip(b) {
        for i in 0..2 {
            let other = if swap { 1 - i } else { i };
            for (u, v) in a.pads[i].displacement.iter().zip(&b.pads[other].displacement) {
                let v = if swap { half_turn * *v } else { *v };
                wrong = wrong.max((*u - v).length());
                largest = largest.max(u.length());
            }
        }
    }
    wrong / largest
}

#[test]
fn a_scene_turned_as_a_whole_gives_the_same_pads() {
    let folder = tempfile::tempdir().unwrap();
    let upright = turned(folder.path(), DQuat::IDENTITY, DQuat::IDENTITY);
    let mut random = Random(11);
    for _ in 0..2 {
        let error = difference(&upright, &turned(folder.path(), random.rotation(), DQuat::IDENTITY), false);
        println!("turned: displacements differ by {error:.1e} of the largest");
        assert!(error < 1e-5, "displacements differ by {error:e} of the largest");
    }
    let swapped = turned(folder.path(), DQuat::IDENTITY, DQuat::from_rotation_z(std::f64::consts::PI));
    let error = difference(&upright, &swapped, true);
    println!("fingers swapped: displacements differ by {error:.1e} of the largest");
    assert!(error < 1e-5, "with the fingers swapped displacements differ by {error:e} of the largest");
}

#[test]
fn force_grows_with_travel() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ron");
    for shape in ["Sphere(radius: 0.015)", "Cuboid(size: (0.02, 0.03, 0.03), edge_radius: 0.002)"] {
        let text = format!("Scene(object: (shape: {shape}), {GRIPPER}, loading: Squeeze(force: 12.0, frames: 16))");
        let frames = frames(&path, &text);
        let curve: Vec<(f64, f64)> = frames.iter().map(|f| (f.travel[0] + f.travel[1], f.applied_force)).collect();
        let mut slope = 0.0;
        for pair in curve.windows(2) {
            let (more, stronger) = (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
            assert!(more > 0.0, "{shape}: the fingers close on as the force rises: {curve:?}");
            // The gel stiffens (to 2 %): the contact area grows, and a thinner layer is stiffer.
            assert!(stronger / more > 0.98 * slope, "{shape}: stiffness falls from {slope} to {} N/m", stronger / more);
            slope = stronger / more;
        }
        println!("{shape}: {:.3} mm at {} N, last stiffness {slope:.0} N/m", 1e3 * curve[15].0, curve[15].1);
    }
}

#[test]
fn next_to_no_weight_changes_next_to_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ron");
    let hanging = |density: f64| {
        let object = format!("(shape: Ellipsoid(radii: (0.014, 0.02, 0.017)), density: {density})");
        let loads = "loading: Squeeze(force: 8.0, frames: 3), gravity: (0, 0, 9.81)";
        let text = format!("Scene(object: {object}, {GRIPPER}, {loads})");
        frames(&path, &text)
    };
    // The weight of the gel is the same in all cases; the lightest object is practically weightless.
    let (weightless, light, heavy) = (hanging(1e-6), hanging(1e-2), hanging(900.0));
    let error = difference(&weightless, &light, false);
    println!("a weight of 2 uN: displacements differ by {error:.1e} of the largest");
    assert!(error < 1e-4, "a weight of 2 uN changes displacements by {error:e} of the largest");
    // An object of 0.18 N sinks after its release by 1 to 100 um.
    let sunk = |frames: &[Frame]| (frames[2].object_position - weightless[2].object_position).z;
    assert!(heavy[0].object_fixed && !heavy[2].object_fixed, "let go at half of the last force");
    println!("a weight of 0.18 N sinks by {:.1e} m", sunk(&heavy));
    assert!(sunk(&heavy) > 1e-6 && sunk(&heavy) < 1e-4, "0.18 N sink by {} m", sunk(&heavy));
}

#[test]
fn an_object_that_swings_out_of_the_hand_is_not_held() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ron");
    // A bar held 25 mm from its centre, whose moment only torsion of the pads can balance.
    let held = |density: f64, solver: &str| {
        let object = format!("(shape: Cuboid(size: (0.02, 0.02, 0.1), edge_radius: 0.005), density: {density})");
        let grasps = "grasps: List([(position: (0, 0.1, 0.025), rotation: (0.70710678, 0.70710678, 0, 0))])";
        let loads = "loading: Squeeze(force: 8.0, frames: 1), gravity: (0, 9.81, 0)";
        let stepper = format!("stepper: Fem(solver: {solver})");
        outcome(&path, &format!("Scene(object: {object}, {GRIPPER}, {grasps}, {loads}, {stepper})"))
    };
    let [whole, condensed] = ["Full", "Condensed()"].map(|solver| {
        let (status, reason, _) = held(6000.0, solver);
        assert_eq!(status, Status::Dropped);
        assert!(reason.contains("moves farther than a held object may"), "{solver}: {reason}");
        let (status, reason, frames) = held(1500.0, solver);
        assert_eq!(status, Status::Reached, "{solver}: {reason}");
        frames[0].object_rotation.angle_between(DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2))
    });
    println!("0.6 N hang 25 mm beside the pads: turned by {whole:.4} rad, condensed pads {condensed:.4} rad");
    assert!((0.001..0.02).contains(&whole), "turned by {whole} rad");
    assert!((whole - condensed).abs() < 0.02 * whole, "{whole} rad, condensed {condensed} rad");
}
