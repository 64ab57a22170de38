//! Pads statically condensed onto their contact patches, against the full solver, equilibrium and reproducibility.

use crate::common::Random;
use crate::keep::Keep;
use glam::DVec3;
use tactus::backend::choose;
use tactus::mech::body::Body;
use tactus::mech::body::cholesky::Factor;
use tactus::mech::body::pattern::FIXED;
use tactus::model::Model;
use tactus::model::grasp::grasp_poses;
use tactus::record::{Frame, Status};
use tactus::scene::{Scene, load};
use tactus::world::components::Position;
use tactus::world::environment::Environment;
use tactus::world::run::{Outcome, run_grasps};
use tactus::world::schedule::Phase;

const FULL: &str = "stepper: Fem()";
const FAST: &str = "stepper: Fem(solver: Condensed())";

fn read(text: &str) -> Result<Scene, String> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("scene.ron");
    std::fs::write(&path, text).unwrap();
    load(&path).map(|loaded| loaded.scene).map_err(|e| e.to_string())
}

/// Returns a scene that squeezes an ellipsoid with `force` (N, sum of both fingers).
fn squeeze(force: f64, frames: usize, more: &str) -> Scene {
    let text = format!(
        "(object: (shape: Ellipsoid(radii: (0.014, 0.02, 0.017)), density: 900.0),
          gripper: (pads: GelSightMini(spacing: 3e-3), friction: 0.8),
          loading: Squeeze(force: {force:?}, frames: {frames}), {more})"
    );
    read(&text).unwrap_or_else(|e| panic!("{e}"))
}

fn run(scene: &Scene, threads: usize) -> (Outcome, Vec<Frame>) {
    let (model, stepper) = (Model::build(scene).unwrap(), choose(scene).unwrap());
    let poses: Vec<_> = grasp_poses(scene).unwrap().into_iter().enumerate().collect();
    let keep = Keep::default();
    let outcome = run_grasps(&model, stepper.as_ref(), &poses, threads, &keep).unwrap().remove(0);
    (outcome, keep.0.into_inner().unwrap())
}

/// Returns the norm of the difference of a nodal quantity relative to its norm in `full`.
fn error<T: Copy + Into<DVec3>>(full: &Frame, fast: &Frame, pick: impl Fn(&Frame) -> Vec<T>) -> f64 {
    let (a, b) = (pick(full), pick(fast));
    let difference: f64 = a.iter().zip(&b).map(|(a, b)| (*a).into().distance_squared((*b).into())).sum();
    (difference / a.iter().map(|a| (*a).into().length_squared()).sum::<f64>()).sqrt()
}

/// Returns the relative errors of displacement, von Mises stress, contact force and travel.
fn errors(full: &Frame, fast: &Frame) -> [f64; 4] {
    let nodal = |frame: &Frame| frame.pads.iter().flat_map(|p| p.displacement.clone()).collect::<Vec<_>>();
    let force = |frame: &Frame| frame.pads.iter().flat_map(|p| p.contact_force.clone()).collect::<Vec<_>>();
    let stress = |frame: &Frame| -> Vec<DVec3> {
        frame.pads.iter().flat_map(|p| p.von_mises_node.iter().map(|s| DVec3::new(*s, 0.0, 0.0))).collect()
    };
    let travel = (fast.travel[0] - full.travel[0]).abs() / full.travel[0];
    [error(full, fast, nodal), error(full, fast, stress), error(full, fast, force), travel]
}

#[test]
fn the_condensed_stiffness_answers_forces_on_the_patch_like_the_whole_pad() {
    let model = Model::build(&squeeze(6.0, 1, FULL)).unwrap();
    let body = &model.fingers[0].body;
    let nodes = body.rest.len();
    let patch: Vec<u32> = (0..nodes as u32).filter(|&n| !body.fixed[n as usize] && n % 7 == 0).collect();
    let factor = |body: &Body| {
        let (mut gradient, mut values) = (vec![DVec3::ZERO; nodes], vec![0.0; body.pattern().row_idx.len()]);
        body.add_stiffness(&body.rest, false, &mut gradient, &mut values);
        let mut factor = Factor::new(body.symbolic().unwrap(), 1);
        assert!(factor.factorize(body.pattern(), &values));
        factor
    };
    let mut random = Random(1);
    let force: Vec<f64> = patch.iter().flat_map(|_| random.vector().to_array()).collect();
    // The full pad in its own elimination order.
    let mut rhs = vec![0.0; body.unknowns()];
    let row = |k: usize| {
        let position = body.pattern().position[patch[k / 3] as usize];
        assert_ne!(position, FIXED);
        3 * position as usize + k % 3
    };
    force.iter().enumerate().for_each(|(k, f)| rhs[row(k)] = *f);
    factor(body).solve(&mut rhs, 1);
    let ordered = body.eliminating_last(&patch);
    let stiffness = factor(&ordered).condensed(force.len());
    for (i, f) in force.iter().enumerate() {
        let answer: f64 = (0..force.len()).map(|j| stiffness[(i, j)] * rhs[row(j)]).sum();
        assert!((answer - f).abs() < 1e-9, "row {i}: {answer} N for {f} N");
    }
}

#[test]
fn errors_stay_small_from_a_tenth_of_a_newton_to_fifteen() {
    // Friction depends on the history of contact, an effect that decays as the contact grows: the first of ten frames
    // has the largest error. A contact 80 instead of 50 times stiffer than a layer of the pad increases the error of
    // nodal forces from 4.4 % to 6.8 %.
    for (force, frames, first, last) in [(0.2, 4, 0.01, 0.005), (15.0, 10, 0.08, 0.02)] {
        let (full, fast) = (run(&squeeze(force, frames, FULL), 2), run(&squeeze(force, frames, FAST), 2));
        assert_eq!(fast.0.summary.status, Status::Reached, "{:?}", fast.0.summary);
        for (full, fast) in full.1.iter().zip(&fast.1) {
            let found = errors(full, fast);
            println!("{:5.2} N: {found:.4?}", full.applied_force);
            let most = if fast.index + 1 < frames { first } else { last };
            assert!(found.iter().all(|e| *e < most), "{} N: {found:?}", full.applied_force);
        }
    }
}

#[test]
fn every_frame_is_balanced_and_neither_inverted_nor_penetrating() {
    for more in ["", "gravity: (0, 0, 2.0)"] {
        let (outcome, frames) = run(&squeeze(15.0, 5, &format!("{FAST}, {more}")), 2);
        assert_eq!(outcome.summary.status, Status::Reached, "{:?}", outcome.summary);
        for frame in frames {
            assert!(frame.force_balance <= 1e-3 && frame.torque_balance <= 1e-3, "{more}: {:e}", frame.force_balance);
            assert!(frame.min_gap > 0.0 && frame.min_det_f > 0.0, "{more}: {:e} m", frame.min_gap);
        }
    }
}

/// A heavy ball whose release needs proximal springs and halved increments still has its weight of 1.62 N carried by
/// the pads, to 0.01 N.
#[test]
fn an_object_let_go_keeps_its_weight_whatever_it_takes() {
    let text = "(object: (shape: Sphere(radius: 0.004), density: 615995.0),
          gripper: (pads: GelSightMini(spacing: 0.0026), material: NeoHookean(young: 20000.0, poisson: 0.45),
            opening: 0.1, stroke: 0.05, friction: 1.2),
          loading: Squeeze(force: 6.0, frames: 4, release: 4.44), gravity: (0, 0, -9.81),
          stepper: Fem(element: Linear, solver: Condensed()))";
    let (outcome, frames) = run(&read(text).unwrap_or_else(|e| panic!("{e}")), 2);
    let methods = outcome.summary.methods;
    assert!(methods.halved > 0 && methods.pseudo_transient > 0, "the case that is meant: {:?}", outcome.summary);
    let let_go: Vec<_> = frames.iter().filter(|frame| !frame.object_fixed).collect();
    assert_eq!(let_go.len(), 2, "{:?}", outcome.summary);
    for frame in let_go {
        let carried: f64 = frame.pads.iter().map(|pad| pad.wrench.force.z).sum();
        assert!((carried.abs() - 1.62).abs() < 0.01, "the pads carry {carried:.3} of 1.62 N");
    }
}

#[test]
fn a_press_feels_the_same_force_at_the_same_depth() {
    let press = |stepper: &str| {
        let text = format!(
            "(object: (shape: Sphere(radius: 7.5e-3), motion: Fixed),
              gripper: (pads: GelSightMini(spacing: 3e-3), fingers: One), loading: Press(depth: 1e-3, frames: 4), {stepper})"
        );
        run(&read(&text).unwrap(), 1).1
    };
    for (full, fast) in press(FULL).iter().zip(press(FAST)) {
        assert_eq!(full.travel, fast.travel, "the depth is prescribed");
        let off = (fast.applied_force / full.applied_force - 1.0).abs();
        assert!(off < 0.01, "{:.3} mm: force off by {off:.4}", 1e3 * full.travel[0]);
        let error = errors(full, &fast)[0];
        assert!(error < 0.03, "{:.3} mm: displacement off by {error:.4}", 1e3 * full.travel[0]);
    }
}

#[test]
fn an_object_that_is_squeezed_out_is_dropped_and_positions_stay_finite() {
    // A frictionless ellipsoid held at its end by the edges of the pads.
    let text = format!(
        "(object: (shape: Ellipsoid(radii: (0.014, 0.02, 0.017))), gripper: (pads: GelSightMini(spacing: 3e-3), friction: 0.0),
          grasps: List([(position: (0, 0, -0.123))]), loading: Squeeze(force: 6.0, frames: 3), {FAST})"
    );
    let scene = read(&text).unwrap_or_else(|e| panic!("{e}"));
    let (model, stepper) = (Model::build(&scene).unwrap(), choose(&scene).unwrap());
    let mut environment = Environment::new(&model, stepper.as_ref(), grasp_poses(&scene).unwrap()[0]).unwrap();
    while !environment.phase().is_final() {
        environment.step();
    }
    let Phase::Dropped { reason } = environment.phase() else { panic!("{:?}", environment.phase()) };
    assert!(reason.contains("squeezed out"), "{reason}");
    let world = environment.world_mut();
    assert!(world.query::<&Position>().iter(world).all(|p| p.0.is_finite()));
}

#[test]
fn motion_in_time_is_refused() {
    let text =
        format!("(object: (shape: Sphere(radius: 0.02)), loading: Dynamic(motions: [Hold(duration: 0.1)]), {FAST})");
    let refused = read(&text).unwrap_err();
    assert!(refused.contains("condensed pads have no inertia") && refused.contains("solver: Full"), "{refused}");
}
