//! Data sets that are computed on a finer mesh and stored at the nodes of the scene's pads, and data sets of selected
//! grasps.

use tactus::backend::choose;
use tactus::dataset::{Campaign, DataSet, Selection};
use tactus::model::Model;
use tactus::model::grasp::grasp_poses;
use tactus::record::names;
use tactus::scene::load_set;

fn scene(dir: &std::path::Path, mesh: &str) -> std::path::PathBuf {
    let path = dir.join("scene.ron");
    let text = format!(
        "(object: (shape: Sphere(radius: 0.015)),
          gripper: (pads: Box(size: (0.02, 0.02, 0.004), spacing: 4e-3), friction: 0.5),
          grasps: Antipodal(count: 3, seed: 1), loading: Squeeze(force: 4.0, frames: 2),
          stepper: Fem(solver: Condensed(error: 0.01){mesh}))"
    );
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn results_of_a_finer_mesh_stand_at_the_nodes_of_the_pads_with_the_same_forces() {
    let dir = tempfile::tempdir().unwrap();
    let set = |name: &str, mesh: &str| {
        let set = load_set(scene(dir.path(), mesh)).unwrap();
        let out = dir.path().join(name);
        Campaign::plan(&set, &out, choose).unwrap().run(2, &()).unwrap();
        DataSet::open(&out).unwrap()
    };
    let (fine, own) = (set("fine", ", mesh: (finer: 1.6, focus: 1.5)"), set("own", ""));
    let (a, b) = (&fine.objects[0], &own.objects[0]);
    assert_eq!(a.pads, b.pads, "the pads are those of the scene");
    let (fine, own) = (a.grasp(0).unwrap(), b.grasp(0).unwrap());
    for (k, pad) in (0..2).flat_map(|k| (0..2).map(move |pad| (k, pad))) {
        let nodes = a.sizes.nodes;
        let first = (k * 2 + pad) * nodes * 3;
        let sum = |axis: usize| -> f64 {
            fine.contact_force[first..first + 3 * nodes].iter().skip(axis).step_by(3).map(|f| f64::from(*f)).sum()
        };
        for axis in 0..3 {
            let whole = fine.wrench[(k * 2 + pad) * 6 + axis];
            assert!((sum(axis) - whole).abs() < 1e-5, "{}: {} N of {whole} N", names::CONTACT_FORCE, sum(axis));
        }
    }
    let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|x| x * x).sum::<f64>().sqrt();
    let pairs = || fine.displacement.iter().zip(&own.displacement).map(|(a, b)| (f64::from(*a), f64::from(*b)));
    let off = norm(&mut pairs().map(|(a, b)| a - b)) / norm(&mut pairs().map(|(_, b)| b));
    assert!((0.005..0.3).contains(&off), "another mesh changes the displacement by {off}");
}

#[test]
fn a_selection_keeps_the_grasps_with_the_largest_scores() {
    let dir = tempfile::tempdir().unwrap();
    let set = load_set(scene(dir.path(), "")).unwrap();
    let poses = grasp_poses(&set.scenes[0].scene).unwrap();
    let wanted = poses[1];
    let score = move |_: &tactus::scene::Scene, poses: &[tactus::geometry::Pose]| {
        Ok(poses.iter().map(|pose| f64::from(u8::from(*pose == wanted))).collect())
    };
    let selection = Selection { keep: Some(1), score: &score };
    let out = dir.path().join("some");
    Campaign::plan_selected(&set, &out, choose, Some(&selection)).unwrap().run(2, &()).unwrap();
    let made = DataSet::open(&out).unwrap();
    let row = &made.objects[0].grasp(0).unwrap().grasp_pose;
    assert_eq!(made.objects[0].sizes.grasps, 1);
    assert_eq!(row[..3], wanted.position.to_array(), "the grasp with the largest score");
    assert!(Model::build(&set.scenes[0].scene).is_ok());
}
