//! Presses a ball into one pad, in a scene that is written here, and prints force against depth: `cargo run --release --example press`.

use std::sync::Mutex;
use tactus::backend::choose;
use tactus::base::error::Result;
use tactus::model::Model;
use tactus::model::grasp::grasp_poses;
use tactus::record::Frame;
use tactus::scene::from_ron;
use tactus::world::run::{Observer, run_grasps};

const SCENE: &str = r#"Scene(
    about: "A ball of 8 mm radius pressed into a flat pad, without friction.",
    object: (shape: Sphere(radius: 8e-3), motion: Fixed),
    gripper: (
        pads: Box(size: (0.02, 0.025, 0.0045), spacing: 2.5e-3),
        material: NeoHookean(young: 3e5, poisson: 0.45),
        fingers: One,
        friction: 0.0,
    ),
    loading: Press(depths: [0.25e-3, 0.5e-3, 0.75e-3, 1e-3]),
)"#;

/// Depth (m) and force (N) of every frame.
#[derive(Default)]
struct Curve(Mutex<Vec<[f64; 2]>>);

impl Observer for Curve {
    fn frame(&self, _grasp: usize, frame: &Frame) -> Result<()> {
        self.0.lock().expect("no thread panics").push([frame.travel[0], frame.applied_force]);
        Ok(())
    }
}

fn main() -> Result<()> {
    let scene = from_ron(SCENE)?;
    let (model, backend, curve) = (Model::build(&scene)?, choose(&scene)?, Curve::default());
    let grasps: Vec<_> = grasp_poses(&scene)?.into_iter().enumerate().collect();
    run_grasps(&model, backend.as_ref(), &grasps, 1, &curve)?;
    for [depth, force] in curve.0.into_inner().expect("no thread panics") {
        println!("{:.2} mm: {force:.4} N", 1e3 * depth);
    }
    Ok(())
}
