//! Predicted error of the network, and fallback to finite elements for grasps with too large an error.

use crate::gnn_made::{ball, made};
use crate::keep::Keep;
use tactus::backend::choose;
use tactus::model::Model;
use tactus::net::infer::predict::Predictor;
use tactus::record::{ErrorBound, Status};
use tactus::scene::leaf::{Count, Positive};
use tactus::scene::{Gnn, Loading, Scene, StepperChoice, from_ron};
use tactus::world::run::run_grasps;

/// Returns the scene of the data set's ball with the network as stepper, accepted up to an error of `at_most`.
fn scene(at_most: Option<f64>, change: (&str, &str)) -> Scene {
    let text = crate::gnn_made::set(made()).objects[0].scene.clone();
    assert!(text.contains(change.0), "the scene has {}", change.0);
    let mut scene = from_ron(&text.replace(change.0, change.1)).unwrap();
    let error_at_most = at_most.map(|most| Positive::new(most).unwrap());
    scene.stepper = StepperChoice::Gnn(Gnn { error_at_most, ..Gnn::new(&made().sure) });
    scene
}

/// Outside the range of the training data the error is unknown, at any distance from it and also at zero friction.
#[test]
fn outside_the_range_of_the_training_the_error_is_unknown() {
    let predictor = Predictor::open(&made().sure).unwrap();
    for (friction, within) in [("friction: 0.8", true), ("friction: 0.9", false), ("friction: 0.0", false)] {
        let model = Model::build(&scene(None, ("friction: 0.8", friction))).unwrap();
        assert_eq!(predictor.pads_if_in_range(&model, false).is_ok(), within);
        let pads = predictor.pads_if_in_range(&model, true).unwrap();
        let seen = predictor.encode_first_contact(&pads, &pads.first_contact(ball(made()).1).unwrap());
        let known = |force: f64| predictor.at(&seen, force).unwrap().error.is_known();
        assert_eq!(known(0.7), within, "{friction}");
        assert!(!known(0.1) && !known(3.0), "forces that it was not trained for");
        let noted = predictor.notices(&model, true).iter().any(|notice| notice.contains("unknown"));
        assert_eq!(noted, !within, "{friction}");
    }
}

/// After training on 0.5 and 1 N per finger, of frames at 0.3, 0.6, 0.9 and 1.2 N only the second and third are
/// answered.
#[test]
fn only_the_frames_outside_the_range_are_refused() {
    let four = ("force: 2.0", "force: 2.4");
    let mut wider = scene(None, four);
    let Loading::Squeeze(squeeze) = &mut wider.loading else { panic!("a squeeze") };
    squeeze.frames = Count::new(4).unwrap();
    let model = Model::build(&wider).unwrap();
    let stepper = choose(&wider).unwrap();
    let frames = Keep::default();
    let end = run_grasps(&model, stepper.as_ref(), &[(0, ball(made()).1)], 1, &frames).unwrap().remove(0).summary;
    let indices: Vec<usize> = frames.0.into_inner().unwrap().iter().map(|frame| frame.index).collect();
    assert_eq!(indices, [1, 2]);
    let reason = end.reason.unwrap();
    assert!(
        end.status == Status::Fault && reason.contains("frame 0 (0.3000 N per finger) and frame 3 (1.2000 N"),
        "{reason}"
    );
    let note = stepper.notices(&model).join("; ");
    assert!(note.contains("frame 0 (0.3000 N per finger) and frame 3 (1.2000 N per finger) lie outside"), "{note}");

    let predictor = Predictor::open(&made().sure).unwrap();
    let many = predictor.predict_batch(&model, &[ball(made()).1], false).unwrap().remove(0).unwrap();
    assert_eq!(many.interpolation.len(), 2);
    let forces: Vec<f64> = predictor.answerable_loads(&model, false).iter().map(|(_, load)| load.force).collect();
    assert!(forces.iter().zip([0.6, 0.9]).all(|(a, b)| (a - b).abs() < 1e-12), "{forces:?} N");
    // With all frames outside the range the scene is refused.
    let beyond = Model::build(&scene(None, ("force: 2.0", "force: 9.0"))).unwrap();
    let refused = predictor.predict_batch(&beyond, &[ball(made()).1], false).unwrap_err().to_string();
    assert!(refused.contains("outside the training range"), "{refused}");
}

#[test]
fn a_network_trained_on_a_few_grasps_states_no_error() {
    let predictor = Predictor::open(&made().model).unwrap();
    assert!(predictor.card.interval.is_none() && predictor.card.kept > 0);
    let note = "needs at least 20 grasps";
    assert!(made().notes.contains(note), "{}", made().notes);
    let (model, pose) = ball(made());
    assert!(predictor.notices(&model, false).iter().any(|notice| notice.contains(note)));
    let pads = predictor.canonical_pads(&model).unwrap();
    let seen = predictor.encode_first_contact(&pads, &pads.first_contact(pose).unwrap());
    assert_eq!(predictor.at(&seen, 0.7).unwrap().error, ErrorBound::UNKNOWN);
}

#[test]
fn grasps_that_the_network_is_not_sure_of_go_to_finite_elements() {
    let ends = |at_most: f64, change: (&str, &str)| {
        let scene = scene(Some(at_most), change);
        let model = Model::build(&scene).unwrap();
        let stepper = choose(&scene).unwrap();
        run_grasps(&model, stepper.as_ref(), &[(0, ball(made()).1)], 1, &()).unwrap().remove(0).summary
    };
    let same = ("friction: 0.8", "friction: 0.8");
    let own = ends(1e6, same);
    assert_eq!((own.status, own.handed_over), (Status::Reached, None));
    assert!(own.error.is_some(), "a prediction comes with its error");
    let handed = ends(1e-9, same);
    assert_eq!(handed.status, Status::Reached);
    assert!(handed.handed_over.unwrap().contains("accepted are 0.0 %"));
    assert!(handed.error.is_none() && handed.newton_iterations > 10, "finite elements have computed it");
    let unknown = ends(1e6, ("friction: 0.8", "friction: 1.6")).handed_over.unwrap();
    assert!(unknown.contains("friction is 1.6"), "{unknown}");
    let forces = ends(1e6, ("force: 2.0", "force: 2.4"));
    assert_eq!((forces.status, forces.frames), (Status::Reached, 2), "finite elements have all of its frames");
    assert!(forces.handed_over.unwrap().contains("frame 1 (1.2000 N per finger) lies outside"));
}

/// A push beyond the friction limit drops the object at the load of finite elements, to a tenth of Coulomb's limit.
#[test]
fn a_push_past_friction_drops_the_object_where_finite_elements_do() {
    let frames = 15;
    let held = |stepper: &str| {
        let text = format!(
            "(object: (shape: Sphere(radius: 0.02)), gripper: (pads: GelSightMini(spacing: 2.6e-3), friction: 0.5),
              loading: Squeeze(force: 10.0, frames: 2, push: (force: (0.0, 7.5, 0.0), frames: {frames})), stepper: {stepper})"
        );
        let scene = from_ron(&text).unwrap();
        let (model, stepper) = (Model::build(&scene).unwrap(), choose(&scene).unwrap());
        let poses: Vec<_> = tactus::model::grasp::grasp_poses(&scene).unwrap().into_iter().enumerate().collect();
        let end = run_grasps(&model, stepper.as_ref(), &poses, 1, &()).unwrap().remove(0).summary;
        assert_eq!(end.status, Status::Dropped, "{:?}", end.reason);
        // The push relative to Coulomb's limit, 0.5 x 10 N.
        1.5 * (end.frames - 2) as f64 / f64::from(frames)
    };
    let (truth, predicted) = (held("Fem(solver: Condensed())"), held("Gnn(model: \"universe\")"));
    assert!(
        (truth - predicted).abs() <= 0.1 + 1e-9,
        "finite elements hold {truth}, the network {predicted} of Coulomb's limit"
    );
}

/// Where finite elements drop every grasp, `eval` compares the loads at which the objects slip: those of a ball that is
/// pushed agree within a tenth.
#[test]
fn loads_at_which_objects_slip_are_compared() {
    let dir = tempfile::tempdir().unwrap();
    let text = "(object: (shape: Sphere(radius: 0.02)), gripper: (pads: GelSightMini(spacing: 2.6e-3), friction: 0.5),
        loading: Squeeze(force: 10.0, frames: 2, push: (force: (0.0, 7.5, 0.0), frames: 30)), stepper: Fem(solver: Condensed()))";
    std::fs::write(dir.path().join("push.ron"), text).unwrap();
    let tactus = |arguments: &[&str]| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_tactus"));
        String::from_utf8(command.args(arguments).current_dir(dir.path()).output().unwrap().stdout).unwrap()
    };
    tactus(&["dataset", "push.ron", "-o", "data"]);
    let said = tactus(&["eval", "data", "--split", "all", "--extrapolate", "--model", "universe"]);
    assert!(said.contains("slip: 1 grasp dropped under a push"), "{said}");
    assert!(said.contains("within a tenth for 100 % of them"), "{said}");
}
