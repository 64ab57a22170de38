//! Squeezes an object and reads what the pads feel: `cargo run --release --example squeeze`.

use std::sync::Mutex;
use tactus::backend::choose;
use tactus::base::error::Result;
use tactus::model::Model;
use tactus::model::grasp::grasp_poses;
use tactus::record::Frame;
use tactus::scene::load;
use tactus::world::run::{Observer, run_grasps};

/// Prints every frame, and keeps the last one.
#[derive(Default)]
struct Watch(Mutex<Option<Frame>>);

impl Observer for Watch {
    fn frame(&self, _grasp: usize, frame: &Frame) -> Result<()> {
        let travel: Vec<String> = frame.travel.iter().map(|t| format!("{:.3} mm", 1e3 * t)).collect();
        println!("{:5.1} N: fingers travelled {}", frame.applied_force, travel.join(" and "));
        *self.0.lock().expect("no thread panics") = Some(frame.clone());
        Ok(())
    }
}

fn main() -> Result<()> {
    let scene = load("scenes/quickstart.ron")?.scene;
    let (model, backend, watch) = (Model::build(&scene)?, choose(&scene)?, Watch::default());
    let grasps: Vec<_> = grasp_poses(&scene)?.into_iter().enumerate().collect();
    let outcomes = run_grasps(&model, backend.as_ref(), &grasps, 2, &watch)?;
    println!("{}: {} Newton iterations", outcomes[0].summary.status.as_str(), outcomes[0].summary.newton_iterations);
    let Some(frame) = watch.0.into_inner().expect("no thread panics") else { return Ok(()) };
    for (pad, name) in frame.pads.iter().zip(["left", "right"]) {
        let stress = pad.von_mises_node.iter().copied().fold(0.0, f64::max);
        let touching = pad.contact_force.iter().filter(|f| f.length() > 0.0).count();
        println!("{name} pad: {touching} nodes touch, at most {:.1} kPa of von Mises stress", 1e-3 * stress);
    }
    Ok(())
}
