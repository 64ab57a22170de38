//! One network for several pad designs: it is trained on all, admits designs within their range, and refuses others.

use crate::gnn_made::SPEC;
use std::path::Path;
use std::process::{Command, Output};
use tactus::dataset::DataSet;
use tactus::model::Model;
use tactus::net::network::card::StoredModel;
use tactus::scene::load;

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
