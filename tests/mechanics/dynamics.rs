//! Dynamics: accuracy of the time integrator with and without contact, and no cost of dynamics in quasi-static scenes.

use crate::keep::Keep;
use glam::{DQuat, DVec3};
use tactus::backend::choose;
use tactus::model::Model;
use tactus::model::grasp::grasp_poses;
use tactus::record::{DynamicState, Frame, Status};
use tactus::scene::{Scene, load};
use tactus::world::environment::Environment;
use tactus::world::run::{Outcome, run_grasps};

fn scene(text: &str) -> Scene {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scene.ron");
    std::fs::write(&path, text).unwrap();
    load(&path).unwrap_or_else(|e| panic!("{e}")).scene
}

/// Runs a scene and asserts that it reaches its end.
fn run(text: &str) -> (Outcome, Vec<Frame>) {
    let scene = scene(text);
    let model = Model::build(&scene).unwrap();
    let poses: Vec<_> = grasp_poses(&scene).unwrap().into_iter().enumerate().collect();
    let keep = Keep::default();
    let outcome = run_grasps(&model, choose(&scene).unwrap().as_ref(), &poses, 1, &keep).unwrap().remove(0);
    assert_eq!(outcome.summary.status, Status::Reached, "{:?}\n{text}", outcome.summary.reason);
    (outcome, keep.0.into_inner().unwrap())
}

fn moving(frame: &Frame) -> DynamicState {
    frame.moving.expect("a dynamic scene")
}

/// Returns a scene of a block of 24 g without fingers; `object` and `more` add fields to the object and the scene.
fn alone(object: &str, more: &str) -> String {
    format!("(object: (shape: Cuboid(size: (0.02, 0.03, 0.04)), {object}), gripper: (fingers: None), {more})")
}

const GRAVITY: f64 = 9.81;
/// Mass of the block of [`alone`], kg.
const MASS: f64 = 0.024;

#[test]
fn a_free_fall_is_that_of_backward_euler_and_of_first_order() {
    for (h, t) in [(1e-3, 0.2), (1e-2, 0.2), (1e-1, 0.4)] {
        let text = alone(
            "",
            &format!(
                "gravity: (0, 0, -9.81), loading: Dynamic(motions: [Hold(duration: {t})], time_step: {h}, frames: 1)"
            ),
        );
        let (outcome, frames) = run(&text);
        // Backward Euler falls by g h2 n (n + 1) / 2 in n steps of size h.
        let expected = -0.5 * GRAVITY * t * (t + h);
        let fallen = outcome.measured.position_m[2];
        assert!((fallen - expected).abs() < 1e-10, "h = {h} s: {fallen} against {expected} m");
        assert!((moving(&frames[0]).velocity.z + GRAVITY * t).abs() < 1e-9, "the speed is exact");
    }
}

#[test]
fn a_free_body_keeps_its_momenta_and_its_energy_within_second_order() {
    let spread = |h: f64| {
        let text = alone(
            "velocity: (0.1, -0.2, 0.3), spin: (1, 20, 0.5)",
            &format!("loading: Dynamic(motions: [Hold(duration: 1.0)], time_step: {h}, frames: 50)"),
        );
        let (outcome, frames) = run(&text);
        assert!(outcome.measured.momentum_drift < 1e-7, "momenta drift by {:e}", outcome.measured.momentum_drift);
        let energy = |f: &Frame| 0.5 * moving(f).angular_momentum.dot(moving(f).spin);
        let (low, high) = frames.iter().map(energy).fold((f64::INFINITY, 0.0_f64), |(l, h), e| (l.min(e), h.max(e)));
        (high - low) / high
    };
    let (coarse, fine) = (spread(2e-3), spread(1e-3));
    println!("energy of a tumbling body varies by {coarse:.2e} at 2 ms, {fine:.2e} at 1 ms");
    assert!(fine < 1e-3, "energy varies by {fine:.2e}");
    assert!(coarse / fine > 3.5, "{coarse:.2e} against {fine:.2e}: not of second order");
}

#[test]
fn the_ground_carries_the_weight() {
    // Level, and tilted by 20 degrees, where friction carries the tangential part.
    for gravity in ["(0, 0, -9.81)", "(3.3552177, 0, -9.2183849)"] {
        let text = alone(
            "",
            &format!(
                "gravity: {gravity}, ground: Plane(), loading: Dynamic(motions: [Hold(duration: 0.1)], frames: 1)"
            ),
        );
        let (_, frames) = run(&text);
        let force = moving(&frames[0]).ground_force.length();
        assert!((force / (MASS * GRAVITY) - 1.0).abs() < 1e-5, "{force} N carry {} N", MASS * GRAVITY);
    }
}

#[test]
fn a_block_on_a_slope_holds_or_slides_as_coulomb_says() {
    let slope = |friction: f64, h: f64| {
        let text = alone(
            "",
            &format!(
                "gravity: (0, 4.387166, -8.774373), ground: Plane(friction: {friction}),
                 loading: Dynamic(motions: [Hold(duration: 0.2)], time_step: {h}, frames: 1)"
            ),
        );
        let (outcome, frames) = run(&text);
        (outcome.measured.slip_m, moving(&frames[0]).velocity.y)
    };
    for h in [1e-3, 1e-2] {
        let (slip, _) = slope(0.5, h);
        assert!(slip < 5e-6, "friction 0.50, h = {h} s: slips by {slip:.2e} m");
        let (_, speed) = slope(0.49, h);
        let expected = (4.387166 - 0.49 * 8.774373) * 0.2;
        assert!((speed / expected - 1.0).abs() < 1e-4, "friction 0.49, h = {h} s: {speed} against {expected} m/s");
    }
}

#[test]
fn an_impact_at_one_metre_per_second_neither_penetrates_nor_bounces_off_the_ground() {
    for (h, tilt) in [1e-4, 1e-3, 1e-2, 1e-1].into_iter().flat_map(|h| [(h, "0"), (h, "7")]) {
        let text = alone(
            "velocity: (0.3, 0, -1)",
            &format!(
                "grasps: List([(position: (0, 0, 0.1), rotation: RpyDeg(({tilt}, 0, 0)))]), gravity: (0, 0, -9.81),
                 ground: Plane(height: -0.03), loading: Dynamic(motions: [Hold(duration: 0.4)], time_step: {h}, frames: 4)"
            ),
        );
        let (outcome, frames) = run(&text);
        let m = &outcome.measured;
        let gap = outcome.summary.min_gap_m.unwrap();
        assert!(gap > 0.0, "h = {h} s: a gap of {gap} m");
        assert!(m.speed_m_s < 1e-6, "h = {h} s: still moves at {} m/s", m.speed_m_s);
        assert!((m.ground_force_n / (MASS * GRAVITY) - 1.0).abs() < 1e-5, "h = {h} s: {} N", m.ground_force_n);
        let at = frames.last().map(moving).unwrap();
        assert!(at.velocity.is_finite() && at.spin.is_finite());
    }
}

/// Runs the impact of a ball at 1 m/s on a coarse pad.
fn ball_against_pad(h: f64, damping: f64) -> Outcome {
    run(&format!(
        "(object: (shape: Sphere(radius: 0.015), velocity: (-1, 0, 0)),
          gripper: (pads: GelSightMini(spacing: 6e-3), fingers: One, opening: 0.04), stepper: Fem(element: Linear),
          record: (fields: []),
          loading: Dynamic(motions: [Hold(duration: 0.03)], time_step: {h}, damping: {damping}, frames: 3))"
    ))
    .0
}

#[test]
fn an_impact_on_a_pad_gives_back_at_most_what_it_got() {
    for h in [1e-4, 1e-3, 1e-2, 1e-1] {
        let Outcome { summary, measured, .. } = ball_against_pad(h, 0.0);
        let (gap, det) = (summary.min_gap_m.unwrap_or(f64::INFINITY), summary.min_det_f.unwrap());
        assert!(gap > 0.0 && det > 0.0, "h = {h} s: gap {gap} m, det F {det}");
        assert!(measured.speed_m_s < 1.0, "h = {h} s: comes back at {} m/s", measured.speed_m_s);
    }
}

#[test]
fn viscosity_takes_energy_out_of_an_impact() {
    let speeds = [0.0, 1e-3, 1e-2].map(|damping| ball_against_pad(5e-4, damping).measured.speed_m_s);
    println!("speed after the impact: {speeds:?} m/s");
    assert!(speeds[0] > 1.2 * speeds[1] && speeds[1] > 1.2 * speeds[2], "{speeds:?}");
}

/// Returns a scene of a block between coarse pads with the hand pointing down.
fn held(loading: &str, more: &str) -> String {
    format!(
        "(object: (shape: Cuboid(size: (0.03, 0.03, 0.04)), density: 2000.0),
          grasps: List([(position: (0, 0, 0.1), rotation: RpyDeg((180, 0, 0)))]),
          gripper: (pads: GelSightMini(spacing: 8e-3), friction: 0.8), stepper: Fem(element: Linear),
          gravity: (0, 0, -9.81), {more} loading: {loading})"
    )
}

/// Returns the displacement of the object along the hand's approach axis in the last frame, m.
fn sag(frames: &[Frame]) -> f64 {
    frames.last().unwrap().object_position.z - 0.1
}

#[test]
fn what_has_come_to_rest_is_the_quasi_static_state() {
    let (_, still) = run(&held("Squeeze(force: 6.0, frames: 1)", ""));
    let motions = "[Close(force: 6.0, duration: 0.05), Lift(height: 0.01, duration: 0.1), Hold(duration: 0.1)]";
    let dynamic = held(&format!("Dynamic(motions: {motions}, time_step: 2e-3, frames: 1)"), "ground: Plane(),");
    let (outcome, moved) = run(&dynamic);
    let (still, moved) = (sag(&still), sag(&moved));
    println!("the gel sags by {:.3} um at rest, by {:.3} um after a lift", still * 1e6, moved * 1e6);
    // The lift loads the contact with up to 1.6 times the weight, so that its rim slips.
    assert!((moved / still - 1.0).abs() < 0.05, "{moved} m against {still} m");
    assert!(outcome.measured.force_balance < 1e-5, "{}", outcome.measured.force_balance);
}

#[test]
fn a_turned_hand_turns_gravity() {
    // With the hand turned upside down, the object sags in the opposite direction of the hand frame, to 5 %.
    let motions = "[Close(force: 6.0, duration: 0.05), Lift(height: 0.05, duration: 0.1), Hold(duration: 0.1),
                    Rotate(angle_deg: 180, axis: (1, 0, 0), duration: 0.3), Hold(duration: 0.1)]";
    let text = held(&format!("Dynamic(motions: {motions}, time_step: 2e-3, frames: 13)"), "ground: Plane(),");
    let (_, frames) = run(&text);
    let (before, after) = (frames[4].object_position.z - 0.1, sag(&frames));
    assert!((after + before).abs() < 0.05 * before, "{before} m before, {after} m after");
    let hand = moving(frames.last().unwrap());
    let turned = hand.hand_rotation.angle_between(DQuat::from_rotation_x(0.0)).to_degrees();
    assert!(turned < 1e-6 && hand.hand_position.distance(DVec3::new(0.0, 0.0, -0.05)) < 1e-9, "the middle stays");
}

#[test]
fn a_scene_without_motion_in_time_pays_nothing_for_it() {
    let parts = |text: &str| {
        let scene = scene(text);
        let model = Model::build(&scene).unwrap();
        let pose = grasp_poses(&scene).unwrap()[0];
        let environment = Environment::new(&model, choose(&scene).unwrap().as_ref(), pose).unwrap();
        let systems: Vec<String> = environment.systems().into_iter().flat_map(|(_, names)| names).collect();
        (environment.components(), systems, model.unknowns())
    };
    let (still, still_systems, unknowns) = parts(&held("Squeeze(force: 6.0)", ""));
    let loading = "Dynamic(motions: [Close(force: 6.0, duration: 0.1)])";
    let (moved, moved_systems, geared) = parts(&held(loading, "ground: Plane(),"));
    for name in ["HandPose", "ObjectVelocity", "ObjectMomentum", "InertialWrench", "GroundWrench"] {
        assert!(moved.contains_key(name) && !still.contains_key(name), "{name}");
    }
    assert!(
        moved_systems.iter().any(|s| s.contains("dynamics")) && !still_systems.iter().any(|s| s.contains("dynamics"))
    );
    assert_eq!((unknowns.travels, geared.travels), (1, 1), "fingers around a free object are geared: one travel");
    let (airborne, systems, _) = parts(&held(loading, ""));
    assert!(!airborne.contains_key("GroundWrench") && !systems.iter().any(|s| s.contains("ground")), "no ground");
    let (_, _, open) = parts(&held("Dynamic(motions: [Hold(duration: 0.1)])", ""));
    assert_eq!(open.travels, 0, "a hand that never squeezes has no travel");
}
