//! Asks the network that ships what a pad feels, at forces of your own: `cargo run --release --example predict`.

use std::path::Path;
use tactus::base::error::{Error, Result};
use tactus::model::Model;
use tactus::model::grasp::grasp_poses;
use tactus::net::DEFAULT_MODEL;
use tactus::net::infer::predict::Predictor;
use tactus::net::linear_response::GraspLoad;
use tactus::scene::load;

fn main() -> Result<()> {
    let scene = load("scenes/lemon.ron")?.scene;
    let pose = grasp_poses(&scene)?.into_iter().next().ok_or_else(|| Error::Start("the scene has no grasp".into()))?;
    let model = Model::build(&scene)?;
    // Refuses what lies outside the range of its training, and says why.
    let network = Predictor::open(Path::new(DEFAULT_MODEL))?;
    let pads = network.pads_if_in_range(&model, false)?;
    // Once per grasp: where the pads first touch, and the messages that pass on them.
    let encoded = network.encode_first_contact(&pads, &pads.first_contact(pose)?);
    // Then any number of forces, per finger.
    let forces = [1.0, 2.5, 5.0, 7.5];
    for (force, state) in forces.iter().zip(network.states(&encoded, &forces.map(GraspLoad::from))?) {
        let pads = &state.pads;
        let stress = pads.iter().flat_map(|pad| &pad.stress).copied().fold(0.0, f64::max);
        let travel: Vec<String> = pads.iter().map(|pad| format!("{:.3}", 1e3 * pad.travel)).collect();
        println!("{force:.1} N per finger: travel {} mm, at most {:.1} kPa", travel.join(" and "), 1e-3 * stress);
    }
    Ok(())
}
