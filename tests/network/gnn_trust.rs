//! What a network says of its own error, and what becomes of grasps that it is not sure of.

use crate::gnn_made::{ball, made};
use tactus::backend::choose;
use tactus::linear::first_contact::GeometricContact;
use tactus::model::Model;
use tactus::net::infer::predict::Predictor;
use tactus::record::Status;
use tactus::run::run_grasps;
use tactus::scene::leaf::Positive;
use tactus::scene::{Gnn, Scene, StepperChoice, from_ron};

/// The scene of the data set's ball, whose grasps the network computes if it may be off by `at_most`.
fn scene(at_most: Option<f64>, change: (&str, &str)) -> Scene {
    let text = crate::gnn_made::set(made()).objects[0].scene.clone();
    assert!(text.contains(change.0), "the scene has {}", change.0);
    let mut scene = from_ron(&text.replace(change.0, change.1)).unwrap();
    let error_at_most = at_most.map(|most| Positive::new(most).unwrap());
    scene.stepper = StepperChoice::Gnn(Gnn { error_at_most, ..Gnn::new(&made().model) });
    scene
}

#[test]
fn the_interval_widens_outside_the_range_of_the_training() {
    let predictor = Predictor::open(&made().model).unwrap();
    let error = |friction: &str| {
        let scene = scene(None, ("friction: 0.8", friction));
        let model = Model::build(&scene).unwrap();
        assert_eq!(predictor.admit(&model, false).is_ok(), friction == "friction: 0.8");
        let graph = predictor.admit(&model, true).unwrap();
        let touch = GeometricContact::find(&model, ball(made()).1).unwrap();
        predictor.at(&predictor.look(&model, &graph, &touch), 0.5).unwrap().error.unwrap().displacement
    };
    let (inside, outside) = (error("friction: 0.8"), error("friction: 1.6"));
    assert!(inside.is_finite() && inside > 0.0);
    assert!(outside > 1.2 * inside, "{outside} outside, {inside} inside");
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
}

/// A push past what friction holds ends the grasp where finite elements end it, to a tenth of the load that friction holds.
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
        let poses: Vec<_> = tactus::grasp::poses_of(&scene).unwrap().into_iter().enumerate().collect();
        let end = run_grasps(&model, stepper.as_ref(), &poses, 1, &()).unwrap().remove(0).summary;
        assert_eq!(end.status, Status::Dropped, "{:?}", end.reason);
        // Over 0.5 x 10 N.
        1.5 * (end.frames - 2) as f64 / f64::from(frames)
    };
    let (truth, predicted) = (held("Fem(solver: Condensed())"), held("Gnn(model: \"universe\")"));
    assert!(
        (truth - predicted).abs() <= 0.1 + 1e-9,
        "finite elements hold {truth}, the network {predicted} of Coulomb's limit"
    );
}
