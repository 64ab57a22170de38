//! A data set and a network so small that both take a second.
#![allow(dead_code, reason = "every test binary uses its own part")]

use super::dataset_tiny::Tiny;
use glam::{DQuat, DVec3};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, OnceLock};
use tactus::dataset::DataSet;
use tactus::gnn::graph::Layout;
use tactus::gnn::sample::{Sample, model_of};
use tactus::gnn::spec::Spec;
use tactus::gnn::train::data;
use tactus::grasp::GraspPose;
use tactus::model::Model;

pub const SPEC: &str = "Model(network: Face(latent: 8, rounds: 2, decoder: 8, depths: 3), \
                    training: (epochs: 6, batch: 2, levels: 2, frames: 2, validation: 0.3, seed: 3))";

/// The paper's network, as small.
pub const PAPER: &str = "Model(network: Paper(latent: 8, rounds: 2), \
                    training: (epochs: 2, batch: 2, levels: 2, frames: 2, validation: 0.3, mirror: false, seed: 3))";

/// One data set and one trained model for all tests.
pub struct Made {
    pub tiny: Tiny,
    pub spec: PathBuf,
    pub model: PathBuf,
}

pub fn made() -> &'static Made {
    static MADE: OnceLock<Made> = OnceLock::new();
    MADE.get_or_init(|| {
        let tiny = Tiny::new("Quadratic");
        tiny.make(&tiny.out("data"));
        let spec = tiny.out("m.ron");
        std::fs::write(&spec, SPEC).unwrap();
        let model = tiny.out("model");
        let made = Made { tiny, spec, model };
        train(&made, &made.model, &[]);
        made
    })
}

pub fn command(made: &Made, out: &Path, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tactus"));
    command.arg("train").arg(made.tiny.out("data")).arg("--model").arg(&made.spec).arg("-o").arg(out);
    command.args(["--format", "json"]).args(more);
    command
}

pub fn train(made: &Made, out: &Path, more: &[&str]) {
    let done = command(made, out, more).output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
}

pub fn set(made: &Made) -> DataSet {
    DataSet::open(made.tiny.out("data")).unwrap()
}

pub fn samples(made: &Made, layout: Layout) -> Vec<Sample> {
    let set = set(made);
    data::read(&set, &set.splits.poses.train, layout, 10).unwrap().0
}

/// The object "ball" of the data set: its model, and a grasp that was not simulated.
pub fn ball(made: &Made) -> (Arc<Model>, GraspPose) {
    let set = set(made);
    let turn = DQuat::from_scaled_axis(DVec3::new(0.3, 0.2, 0.5));
    let pose = GraspPose { position: turn * DVec3::new(0.001, 0.002, -0.1), rotation: turn };
    (model_of(&set.objects[0]).unwrap(), pose)
}

pub fn ron(text: &str) -> Spec {
    tactus::scene::load::options().from_str(text).unwrap()
}
