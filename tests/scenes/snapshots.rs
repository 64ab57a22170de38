//! A simulation continues bit for bit from a state that was written and read.

use std::path::Path;
use tactus::backend::choose;
use tactus::base::saved_state::{StateReader, StateWriter};
use tactus::model::Model;
use tactus::model::grasp::grasp_poses;
use tactus::record::Frame;
use tactus::scene::leaf::Count;
use tactus::scene::{Gnn, Loading, Scene, StepperChoice, load};
use tactus::world::environment::Environment;

/// Number of frames that run in total.
const FRAMES: usize = 6;

/// Transfers the state after 0, 1 and 3 frames into a new environment, and compares the following frames with those of
/// the uninterrupted run.
fn goes_on(what: &str, scene: &str, change: fn(&mut Scene)) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(scene);
    let mut scene = load(&path).unwrap_or_else(|e| panic!("{e}")).scene;
    change(&mut scene);
    let (model, stepper) = (Model::build(&scene).unwrap(), choose(&scene).unwrap());
    let pose = grasp_poses(&scene).unwrap()[0];
    let fresh = || Environment::new(&model, stepper.as_ref(), pose).unwrap();
    let mut truth = fresh();
    let mut sizes = Vec::new();
    let mut moved: Vec<(usize, Environment)> = Vec::new();
    let mut frames = 0;
    while frames < FRAMES && !truth.phase().is_final() {
        truth.step();
        frames += usize::from(truth.frame().is_some());
        for (since, other) in &mut moved {
            other.step();
            let same = |a: Option<&Frame>, b: Option<&Frame>| a == b;
            assert!(same(other.frame(), truth.frame()), "{what}: frame {frames}, moved after frame {since}");
            assert_eq!(other.phase(), truth.phase(), "{what}");
        }
        if [0, 1, 3].contains(&frames) {
            let mut history = StateWriter::default();
            truth.save_state(stepper.as_ref(), &mut history);
            let history = history.finish().unwrap();
            let mut other = fresh();
            other.restore_state(stepper.as_ref(), &mut StateReader(&history)).unwrap();
            moved.push((frames, other));
            if frames > 0 {
                sizes.push(history.len() as f64);
            }
            let cut = StateReader(&history[..history.len() / 2]).to_owned();
            assert!(fresh().restore_state(stepper.as_ref(), &mut { cut }).is_err(), "{what}: half of it is refused");
        }
    }
    assert!(frames == FRAMES && moved.len() > 3, "{what}: {frames} frames, {} moves", moved.len());
    let grown = sizes[sizes.len() - 1] / sizes[0];
    assert!(grown < 1.5, "{what}: the state is {grown} times as long after three frames as after one");
}

/// The condensed pads are at the rim of a cup, where the increments get smaller and larger again.
#[test]
fn a_state_that_was_written_and_read_goes_on_to_the_bit() {
    let longer = |scene: &mut Scene| {
        let Loading::Squeeze(squeeze) = &mut scene.loading else { panic!("a squeeze") };
        squeeze.frames = Count::new(FRAMES as u64).unwrap();
    };
    let network = |scene: &mut Scene| scene.stepper = StepperChoice::Gnn(Gnn::new("universe"));
    type Change = fn(&mut Scene);
    for (what, scene, change) in [
        ("whole pads around a free object", "torture/friction_1.ron", longer as Change),
        ("condensed pads around a free object", "torture/cup_rim.ron", |_| {}),
        ("motion in time with ground and drive", "dynamic/lift.ron", |_| {}),
        ("an object alone in free spin", "dynamic/free_spin.ron", |_| {}),
        ("the network", "quickstart.ron", network),
    ] {
        goes_on(what, scene, change);
    }
}
