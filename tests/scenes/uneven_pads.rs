//! Pads that differ: each finger has its own shape, gel and friction, and the grasp is in equilibrium.

use crate::keep::Keep;
use std::process::Command;
use tactus::backend::choose;
use tactus::model::Model;
use tactus::model::grasp::grasp_poses;
use tactus::record::{Frame, PadFrame};
use tactus::scene::{Scene, load};
use tactus::world::run::run_grasps;

const BOX: &str = "Box(size: (0.02, 0.016, 0.004), cells: (4, 4, 2))";
const SOFT: &str = "NeoHookean(young: 1e5, poisson: 0.45)";
const HARD: &str = "NeoHookean(young: 4e5, poisson: 0.45)";

/// Loads a scene that squeezes a ball to 4 N with these fields of the gripper and these further fields.
fn scene(gripper: &str, more: &str) -> Result<Scene, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ron");
    let text = format!(
        "(object: (shape: Sphere(radius: 0.012)), gripper: ({gripper}), loading: Squeeze(force: 4, frames: 2), {more})"
    );
    std::fs::write(&path, text).unwrap();
    load(&path).map(|loaded| loaded.scene).map_err(|e| e.to_string())
}

fn frames(gripper: &str) -> Vec<Frame> {
    let scene = scene(gripper, "expect: [Finite]").unwrap();
    let model = Model::build(&scene).unwrap();
    let poses: Vec<_> = grasp_poses(&scene).unwrap().into_iter().enumerate().collect();
    let frames = Keep::default();
    run_grasps(&model, choose(&scene).unwrap().as_ref(), &poses, 1, &frames).unwrap();
    let frames = frames.0.into_inner().unwrap();
    assert_eq!(frames.len(), 2, "{gripper} reaches its force");
    frames
}

/// Largest displacement of a node, m.
fn deepest(pad: &PadFrame) -> f64 {
    pad.displacement.iter().map(|u| u.length()).fold(0.0, f64::max)
}

#[test]
fn a_pair_that_is_alike_is_one_pad_bit_for_bit() {
    let one = frames(&format!("pads: {BOX}, material: {SOFT}, friction: 0.6"));
    let pair = frames(&format!(
        "pads: {BOX}, material: {SOFT}, friction: 0.6, right: (pads: {BOX}, material: {SOFT}, friction: 0.6)"
    ));
    assert_eq!(one, pair);
}

#[test]
fn the_softer_pad_gives_way_and_the_forces_balance() {
    let frame = frames(&format!("pads: {BOX}, material: {SOFT}, right: (material: {HARD})")).pop().unwrap();
    let [soft, hard] = [0, 1].map(|i| &frame.pads[i]);
    // Both carry the same force, proportional to E d^1.5 on a half space (Hertz) and to E d^3 on a thin incompressible
    // layer: the indentation d of a gel of a quarter of the modulus is larger by a factor of 4^(1/3) to 4^(2/3).
    let ratio = deepest(soft) / deepest(hard);
    assert!(ratio > 1.55 && ratio < 2.6, "the soft pad yields by {ratio} times as much");
    let [left, right] = [soft, hard].map(|pad| pad.wrench.force);
    assert!((left + right).length() < 1e-3 * 2.0, "{left} N and {right} N cancel to 1e-3 of 2 N");
    assert!((left.length() - 2.0).abs() < 2e-3, "{left} N is half of 4 N");
    assert!(frame.object_position.x.abs() > 1e-4, "the ball sinks into the soft pad: {} m", frame.object_position);
}

/// Swapping the fingers equals rotating the hand by 180 degrees about the approach, to which a ball is invariant:
/// displacement magnitudes agree to 1e-3 of the largest, positions of the ball to 1e-7 m.
#[test]
fn swapped_pads_give_the_swapped_answer() {
    let (a, b) = (
        format!("material: {SOFT}, friction: 0.5"),
        format!("pads: Disc(radius: 0.01, thickness: 0.003, spacing: 2.5e-3), material: {HARD}, friction: 0.9"),
    );
    let there = frames(&format!("pads: {BOX}, {a}, right: ({b})"));
    let back = frames(&format!("{b}, right: (pads: {BOX}, {a})"));
    for (there, back) in there.iter().zip(&back) {
        for (i, j) in [(0, 1), (1, 0)] {
            let (p, q) = (&there.pads[i], &back.pads[j]);
            assert_eq!(p.displacement.len(), q.displacement.len());
            let scale = deepest(p);
            for (u, v) in p.displacement.iter().zip(&q.displacement) {
                let off = (u.length() - v.length()).abs();
                assert!(off < 1e-3 * scale, "{u} m and {v} m are as long to 1e-3 of {scale} m");
            }
        }
        let moved = there.object_position.x + back.object_position.x;
        assert!(moved.abs() < 1e-7, "the ball moves to the other side, but for {moved} m");
    }
}

#[test]
fn what_knows_pads_alike_alone_refuses_others() {
    let right = format!("pads: {BOX}, right: (material: {SOFT})");
    let refused = |gripper: &str, more: &str| scene(gripper, more).unwrap_err();
    let message = refused(&format!("{right}, fingers: One"), "");
    assert!(message.contains("gripper.right: there is no right finger"), "{message}");
    let message = refused(&right, "record: (tactile: [Pressure(rows: 4, cols: 4)])");
    assert!(message.contains("record.tactile: tactile images need two identical pads"), "{message}");
    let message = refused(&format!("pads: {BOX}, right: (pads: Disc(radius: 1e-6, thickness: 0.003))"), "");
    assert!(message.contains("gripper.right.pads.radius"), "{message}");

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ron");
    let text =
        format!("(object: (shape: Sphere(radius: 0.012)), gripper: ({right}), loading: Squeeze(force: 4, frames: 2))");
    std::fs::write(&path, text).unwrap();
    let (path, out) = (path.to_str().unwrap(), folder.path().join("out"));
    let out = out.to_str().unwrap();
    for (arguments, says) in [
        (&["dataset", path, "-o", out, "--sensitivity", "1"][..], "a sensitivity needs two identical pads"),
        (&["bench", path], "a bench needs two identical pads"),
        (&["run", path, "--sensitivity"], "a sensitivity needs two identical pads"),
        (&["run", path, "--backend", "gnn"], "its two pads differ"),
    ] {
        let output = Command::new(env!("CARGO_BIN_EXE_tactus")).args(arguments).output().unwrap();
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && text.contains(says), "{arguments:?}: {text}");
    }
}
