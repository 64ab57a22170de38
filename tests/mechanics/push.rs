//! Pushes on a squeezed object: balance of forces and onset of slip by Coulomb's law.

use crate::keep::Keep;
use std::sync::LazyLock;
use tactus::backend::choose;
use tactus::model::Model;
use tactus::model::grasp::grasp_poses;
use tactus::record::{Frame, GraspSummary, Status};
use tactus::scene::from_ron;
use tactus::world::run::run_grasps;

/// Squeezes a block between pads with elements of `spacing` mm, pushes it, and returns the frames with the summary.
fn pushed(spacing: f64, push: &str, solver: &str) -> (Vec<Frame>, GraspSummary) {
    let text = format!(
        "(object: (shape: Cuboid(size: (0.02, 0.014, 0.014))),
          gripper: (pads: Box(size: (0.02, 0.02, 0.004), spacing: {spacing}e-3), friction: 0.4),
          loading: Squeeze(force: 8.0, frames: 2, push: ({push}, frames: 8)),
          record: (fields: [ContactForce]), stepper: Fem(solver: {solver}))"
    );
    let scene = from_ron(&text).unwrap();
    let model = Model::build(&scene).unwrap();
    let grasps: Vec<_> = grasp_poses(&scene).unwrap().into_iter().enumerate().collect();
    let frames = Keep::default();
    let mut ends = run_grasps(&model, choose(&scene).unwrap().as_ref(), &grasps, 2, &frames).unwrap();
    (frames.0.into_inner().unwrap(), ends.remove(0).summary)
}

/// A push that friction holds.
const HELD: &str = "force: (0, 1.5, -1), torque: (4e-3, 0, 0)";

/// Frames and summary of this push with whole pads, shared by tests.
static WHOLE: LazyLock<(Vec<Frame>, GraspSummary)> = LazyLock::new(|| pushed(2.5, HELD, "Full"));

#[test]
fn the_pads_carry_a_push_and_the_block_follows_it() {
    let (frames, end) = &*WHOLE;
    assert_eq!((frames.len(), end.status), (10, Status::Reached));
    for (k, frame) in frames.iter().enumerate() {
        let part = k.saturating_sub(1) as f64 / 8.0;
        let carried: glam::DVec3 = frame.pads.iter().map(|pad| pad.wrench.force).sum();
        let wanted = glam::DVec3::new(0.0, 1.5, -1.0) * part;
        assert!((carried - wanted).length() < 8e-3, "frame {k}: pads carry {carried} N of {wanted} N");
        assert!((frame.object_load.force - wanted).length() < 1e-12, "the frame names its push");
        assert!(frame.torque_balance < 1e-3, "frame {k}: {} of torque is left", frame.torque_balance);
    }
    let moved = frames[9].object_position - frames[1].object_position;
    assert!(moved.y > 1e-5 && moved.z < -1e-5, "moved by {moved} m");
    let turned = frames[9].object_rotation * frames[1].object_rotation.inverse();
    assert!(turned.to_scaled_axis().x > 1e-3, "turned by {} rad", turned.to_scaled_axis());
}

/// Flat faces pressed with 8 N in total at friction 0.4 hold at most 3.2 N tangentially, 80 % of the push of 4 N. The
/// load at which the block slips is found to 0.06 N within 400 iterations.
#[test]
fn a_block_slips_where_coulomb_says() {
    for solver in ["Full", "Condensed(error: 0.01)"] {
        let (frames, end) = pushed(4.0, "force: (0, 4, 0)", solver);
        assert_eq!(end.status, Status::Dropped, "{solver}");
        assert_eq!(frames.last().unwrap().object_load.force.y, 3.0, "{solver}: the last frame below 3.2 N");
        let reason = end.reason.unwrap();
        let held = reason.split(" % of the push, ").next().and_then(|before| before.rsplit(' ').next());
        let held = 4e-2 * held.and_then(|percent| percent.parse::<f64>().ok()).expect(&reason);
        assert!((3.2 - 0.06..=3.2 + 0.04).contains(&held), "{solver}: {held} N are held: {reason}");
        assert!(end.newton_iterations <= 400, "{solver}: {} iterations", end.newton_iterations);
    }
}

#[test]
fn condensed_pads_carry_a_push_as_whole_ones_do() {
    let (condensed, _) = pushed(2.5, HELD, "Condensed(error: 0.01)");
    let (a, b) = (&WHOLE.0[9].pads[0].displacement, &condensed[9].pads[0].displacement);
    let norm = |v: &mut dyn Iterator<Item = f64>| v.sum::<f64>().sqrt();
    let off = norm(&mut a.iter().zip(b).map(|(a, b)| a.distance_squared(*b)))
        / norm(&mut a.iter().map(|a| a.length_squared()));
    assert!(off < 0.02, "they differ by {off}");
}
