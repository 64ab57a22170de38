//! Derivatives of the input features of the face network with respect to force, friction and pose of the hand.

use glam::{DQuat, DVec3};
use tactus::geometry::Pose;
use tactus::net::DEFAULT_MODEL;
use tactus::net::infer::input_derivatives::{DerivativeDirection, GraspParameters, SceneInputs};
use tactus::net::infer::inputs::Array;
use tactus::scene::from_ron;

const SCENE: &str = "(object: (shape: Sphere(radius: 0.02)), gripper: (pads: GelSightMini(spacing: 2.9e-3)),
    loading: Squeeze(force: 6.0, frames: 2))";
/// Distance of the ball from the origin of the hand, m.
const REACH: f64 = 0.1;

/// Returns the inputs for a ball between the fingers, which close along x, and their derivative along `change`.
fn ball(change: DerivativeDirection) -> [Vec<Array<f32>>; 2] {
    let inputs = SceneInputs::new(&from_ron(SCENE).unwrap(), DEFAULT_MODEL.as_ref(), false).unwrap();
    let (force, friction) = inputs.scene_forces_and_friction();
    let pose = Pose { position: DVec3::NEG_Z * REACH, rotation: DQuat::IDENTITY };
    inputs.grasps(&[GraspParameters { pose, force, friction }], &[change]).unwrap().remove(0).unwrap()
}

fn named<'a>(arrays: &'a [Array<f32>], name: &str) -> &'a [f32] {
    &arrays.iter().find(|array| array.name == name).unwrap().numbers
}

/// Returns the L2 norm of `a + by * b`.
fn norm(a: &[f32], by: f64, b: &[f32]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (f64::from(*a) + by * f64::from(*b)).powi(2)).sum::<f64>().sqrt()
}

#[test]
fn the_pressing_force_grows_with_the_force_alone() {
    let [inputs, slopes] = ball(DerivativeDirection::Force);
    let pressing = named(&inputs, "pressing_n");
    assert_eq!(pressing.len(), 4, "two loads, two pads");
    let off = norm(named(&slopes, "pressing_n"), -1.0, pressing) / norm(pressing, 0.0, pressing);
    // Rounding error of f32 over the finite-difference step.
    assert!(off < 4e-4, "{off} of the force");
    assert!(named(&slopes, "node").iter().all(|slope| *slope == 0.0), "first contact knows no force");
    let [_, slopes] = ball(DerivativeDirection::Friction);
    assert!(named(&slopes, "pressing_n").iter().all(|slope| *slope == 0.0));
}

#[test]
fn fingers_center_a_free_ball_and_a_turn_of_the_hand_carries_the_pads_along() {
    let slopes = [DerivativeDirection::Position(0), DerivativeDirection::Position(1), DerivativeDirection::Rotation(0)]
        .map(|change| ball(change)[1].clone());
    for name in ["node", "node_load", "pad_load"] {
        let [closing, across, turned] = slopes.each_ref().map(|slopes| named(slopes, name));
        let whole = norm(across, 0.0, across);
        let left = norm(closing, 0.0, closing) / whole;
        assert!(left < 1e-2, "{name}: a move along the closing direction does {left} of one across");
        // A rotation about x moves the pads along -y.
        let off = norm(turned, REACH, across) / (REACH * whole);
        assert!(off < 2e-2, "{name}: {off} between a turn about a ball's distance and a move");
    }
}

#[test]
fn grasps_that_cannot_be_looked_at_say_why() {
    let inputs = SceneInputs::new(&from_ron(SCENE).unwrap(), DEFAULT_MODEL.as_ref(), false).unwrap();
    let (force, friction) = inputs.scene_forces_and_friction();
    let pose = Pose { position: DVec3::NEG_Z * REACH, rotation: DQuat::IDENTITY };
    let usual = GraspParameters { pose, force, friction };
    let far = Pose { position: DVec3::Z * 10.0, ..pose };
    let grips = [
        (GraspParameters { force: vec![-1.0], ..usual.clone() }, "a force of -1 N"),
        (GraspParameters { friction: f64::NAN, ..usual.clone() }, "a friction of NaN"),
        (GraspParameters { friction: 3.0, ..usual.clone() }, "friction is 3, the training range is"),
        (GraspParameters { pose: far, ..usual.clone() }, ""),
    ];
    let all: Vec<GraspParameters> = grips.iter().map(|(grip, _)| grip.clone()).collect();
    for (answer, (_, why)) in inputs.grasps(&all, &[]).unwrap().into_iter().zip(&grips) {
        let said = answer.unwrap_err().to_string();
        assert!(said.contains(why), "{said}");
    }
}
