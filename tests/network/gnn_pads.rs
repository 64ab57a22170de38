//! One network for several pad designs: it is trained on all, admits designs within their range, and refuses others.

use crate::gnn_made::SPEC;
use glam::DVec3;
use std::path::Path;
use std::process::{Command, Output};
use tactus::dataset::DataSet;
use tactus::model::Model;
use tactus::model::grasp::grasp_poses;
use tactus::net::infer::predict::Predictor;
use tactus::net::network::card::StoredModel;
use tactus::scene::{from_ron, load};

const UNIVERSE: &str = "Scene(
    universe: (objects: 6, grasps: 1, sensors: 3, seed: 2, families: [Sphere], heavy: 0, friction: (0.7, 0.9),
        pads: (cells: (12, 24), round: 0, domed: 0)),
    gripper: (opening: 0.12, stroke: 0.06),
    loading: Squeeze(force: 1.0, frames: 2),
    stepper: Fem(solver: Condensed(error: 0.02)),
)";

fn tactus(dir: &Path, arguments: &[&str]) -> Output {
    let done = Command::new(env!("CARGO_BIN_EXE_tactus")).args(arguments).current_dir(dir).output().unwrap();
    assert!(matches!(done.status.code(), Some(0 | 1)), "{arguments:?}: {}", String::from_utf8_lossy(&done.stderr));
    done
}

#[test]
fn one_network_learns_from_pads_of_several_kinds() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("universe.ron"), UNIVERSE).unwrap();
    std::fs::write(dir.path().join("m.ron"), SPEC.replace("epochs: 6", "epochs: 2")).unwrap();
    tactus(dir.path(), &["dataset", "universe.ron", "-o", "data"]);
    tactus(dir.path(), &["train", "data", "--split", "all", "--model", "m.ron", "-o", "model"]);
    tactus(dir.path(), &["eval", "data", "--split", "all", "--model", "model"]);
    let range = StoredModel::read(&dir.path().join("model")).unwrap().card.range;
    let set = DataSet::open(dir.path().join("data")).unwrap();
    let pads = range.pads;
    assert!(pads.length[0] < pads.length[1] && pads.width[0] < pads.width[1], "{pads:?}");
    set.objects.iter().for_each(|object| range.check_pad(&object.pads[0]).unwrap());

    let long = 2.0 * pads.length[1] * 4e-3;
    let text = format!(
        "(object: (shape: Sphere(radius: 0.02)), loading: Squeeze(force: 1.0, frames: 1),
          gripper: (pads: Box(size: ({long}, 0.02, 0.004), spacing: 4e-3)))"
    );
    std::fs::write(dir.path().join("long.ron"), text).unwrap();
    let model = Model::build(&load(dir.path().join("long.ron")).unwrap().scene).unwrap();
    let pad = &model.fingers[0].topology;
    let error = range.check_pad(pad).unwrap_err().to_string();
    assert!(
        error.contains("the length of its pads is ") && error.contains("times their thickness, the training range is"),
        "{error}"
    );
}

/// Positions of the nodes of the first pad with displacement and stress, and the travel, as the built-in network answers
/// for `pads` around an ellipsoid at 8 N.
fn answered(pads: &str) -> (Vec<(DVec3, DVec3, f64)>, f64) {
    let text = format!(
        "(object: (shape: Ellipsoid(radii: (0.03, 0.02, 0.016))), gripper: (pads: {pads}, friction: 0.8, opening: 0.08),
          loading: Squeeze(force: 8.0, frames: 1))"
    );
    let scene = from_ron(&text).unwrap();
    let model = Model::build(&scene).unwrap();
    let predictor = Predictor::open(Path::new("universe")).unwrap();
    let canonical = predictor.pads_if_in_range(&model, false).unwrap();
    let touch = canonical.first_contact(grasp_poses(&scene).unwrap()[0]).unwrap();
    let state = predictor.at(&predictor.encode_first_contact(&canonical, &touch), 4.0).unwrap();
    let pad = &state.pads[0];
    let nodes = model.fingers[0].topology.rest.iter().zip(&pad.displacement).zip(&pad.stress);
    (nodes.map(|((x, u), s)| (*x, *u, *s)).collect(), touch.travel[0] + pad.travel)
}

/// At nodes that two meshes have in common, displacement, stress and travel agree within 1 % (L2; of the travel since
/// contact), for a flat pad, a dome and a disc.
#[test]
fn two_meshes_of_one_pad_get_one_answer() {
    for (shape, meshes) in [
        ("Box(size: (0.024, 0.02, 0.004), MESH)", ["cells: (8, 8, 2)", "cells: (16, 16, 4)", "cells: (4, 4, 1)"]),
        ("GelSightMini(shape: Domed, MESH)", ["spacing: 3e-3", "spacing: 1.5e-3", "spacing: 1.5e-3, focus: 2.0"]),
        ("Disc(radius: 0.011, thickness: 0.004, MESH)", ["spacing: 2.6e-3", "spacing: 1.3e-3", "spacing: 2e-3"]),
    ] {
        let [first, others @ ..] = meshes.map(|mesh| answered(&shape.replace("MESH", mesh)));
        for (other, travel) in others {
            let shared = other.iter().filter_map(|(x, u, s)| {
                let (_, v, r) = first.0.iter().find(|(y, ..)| x.distance(*y) < 1e-7)?;
                Some([u.distance_squared(*v), v.length_squared(), (s - r).powi(2), r.powi(2)])
            });
            let shared: Vec<[f64; 4]> = shared.collect();
            let sum = |k: usize| shared.iter().map(|row| row[k]).sum::<f64>();
            let off = [(sum(0) / sum(1)).sqrt(), (sum(2) / sum(3)).sqrt(), (travel / first.1 - 1.0).abs()];
            assert!(shared.len() > 20 && off.iter().all(|off| *off < 0.01), "{shape}: {off:?} at {}", shared.len());
        }
    }
}
