//! Data sets of drawn objects: each object has its own pads, friction, gel and loads, which its file stores.

use std::path::{Path, PathBuf};
use std::process::Command;
use tactus::dataset::DataSet;
use tactus::model::Model;
use tactus::scene::{LoadedSet, from_ron, load_set};

fn scene(dir: &Path, universe: &str) -> PathBuf {
    let text = format!(
        "Scene(
            universe: ({universe}, pads: (cells: (12, 20), thickness: (0.003, 0.006))),
            gripper: (opening: 0.12, stroke: 0.06),
            loading: Squeeze(force: 1.0, frames: 2),
            stepper: Fem(solver: Condensed(error: 0.02)),
        )"
    );
    let path = dir.join("universe.ron");
    std::fs::write(&path, text).unwrap();
    path
}

fn drawn(universe: &str) -> LoadedSet {
    let dir = tempfile::tempdir().unwrap();
    load_set(scene(dir.path(), universe)).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn more_objects_begin_with_those_of_fewer_and_seeds_differ() {
    let [few, many, other] = ["objects: 3, seed: 5", "objects: 30, seed: 5", "objects: 3, seed: 6"].map(drawn);
    assert_eq!(few.scenes[..], many.scenes[..3]);
    assert!(few.scenes.iter().zip(&other.scenes).all(|(a, b)| a.scene.gripper != b.scene.gripper));
    let pads = |set: &LoadedSet| {
        set.scenes.iter().map(|s| format!("{:?}", s.scene.gripper.pads)).collect::<std::collections::BTreeSet<_>>()
    };
    assert_eq!(pads(&drawn("objects: 60, sensors: 3")).len(), 3, "as many kinds of pads as asked for");
    for named in &many.scenes {
        let text = tactus::scene::to_ron(&named.scene).unwrap();
        assert_eq!(from_ron(&text).unwrap(), named.scene, "{} is what its file says", named.name.as_str());
        Model::build(&named.scene).unwrap_or_else(|e| panic!("{}: {e}", named.name.as_str()));
    }
}

#[test]
fn every_file_holds_the_pads_and_the_loads_of_its_object() {
    let dir = tempfile::tempdir().unwrap();
    let path = scene(dir.path(), "objects: 4, grasps: 1, seed: 3, families: [Sphere, Capsule], heavy: 0.5");
    let out = dir.path().join("out");
    let made =
        Command::new(env!("CARGO_BIN_EXE_tactus")).arg("dataset").arg(&path).arg("-o").arg(&out).output().unwrap();
    let said = String::from_utf8_lossy(&made.stderr).into_owned();
    assert!(matches!(made.status.code(), Some(0 | 1)), "{said}");
    let set = DataSet::open(&out).unwrap();
    assert!(set.damaged.is_empty() && set.objects.len() == 4, "{said}");
    let mut nodes = Vec::new();
    for (object, named) in set.objects.iter().zip(load_set(&path).unwrap().scenes) {
        let stored = from_ron(&object.scene).unwrap();
        assert_eq!(
            (&stored.gripper, &stored.loading, stored.gravity),
            (&named.scene.gripper, &named.scene.loading, named.scene.gravity)
        );
        let model = Model::build(&stored).unwrap();
        assert_eq!(object.sizes.nodes, model.fingers[0].topology.rest.len(), "{}", object.name);
        nodes.push(object.sizes.nodes);
        let unit = model.material.moduli().young * model.thickness().powi(2);
        let last = model.levels[1] / unit;
        assert!((0.4..=1.2).contains(&last), "{}: the last force is {last} E t^2", object.name);
        for grasp in object.reached() {
            let grasp = object.grasp(grasp).unwrap();
            let each = grasp.force[1] / model.fingers.len() as f64;
            assert!((each - model.levels[1]).abs() < 1e-9 * model.levels[1], "{}", object.name);
        }
    }
    assert!(nodes.windows(2).any(|w| w[0] != w[1]), "pads differ: {nodes:?} nodes");
    assert!(set.objects.iter().any(|object| object.reached().count() > 0), "{said}");
    let about = out.join("dgn_dataset").join(&set.objects[1].name);
    assert!(
        about.join(format!("{}_sensor.tet", set.objects[1].name)).exists(),
        "its own pad stands beside its surface"
    );
}

#[test]
fn ranges_that_do_not_fit_are_refused_at_their_place() {
    let dir = tempfile::tempdir().unwrap();
    for (universe, said) in [
        ("friction: (1.0, 0.5)", "universe.friction: the first number is the minimum"),
        ("poisson: (0.3, 0.5)", "universe.poisson: a gel has a Poisson's ratio below 0.5"),
        ("heavy: 1.5", "universe.heavy: a fraction of the objects"),
        ("families: []", "universe.families: an empty list"),
    ] {
        let error = load_set(scene(dir.path(), universe)).unwrap_err().to_string();
        assert!(error.contains(said) && error.contains("universe.ron:2:"), "{error}");
    }
}
