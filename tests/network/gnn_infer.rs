//! Inference without a tape against the same network on the tape of automatic differentiation, the reference.

use crate::gnn_made::{ball, made};
use crate::keep::Keep;
use glam::DVec3;
use std::path::Path;
use std::sync::Arc;
use tactus::backend::choose;
use tactus::geometry::Pose;
use tactus::model::Model;
use tactus::net::infer::load_interpolation::LoadInterpolation;
use tactus::net::infer::predict::{EncodedGrasp, GraspState, PadState, Predictor};
use tactus::net::linear_response::{GraspLoad, frame_loads};
use tactus::record::Frame;
use tactus::scene::from_ron;
use tactus::world::run::run_grasps;

/// Returns the relative difference of two lists of numbers in the L2 norm.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|x| x * x).sum::<f64>().sqrt();
    norm(&mut a.iter().zip(b).map(|(a, b)| a - b)) / norm(&mut b.iter().copied()).max(1e-300)
}

/// Returns every predicted quantity as a flat list.
fn lists(pads: &[PadState]) -> [(&'static str, Vec<f64>); 5] {
    let vectors =
        |of: fn(&PadState) -> &Vec<glam::DVec3>| pads.iter().flat_map(of).flat_map(|v| v.to_array()).collect();
    [
        ("displacement", vectors(|p| &p.displacement)),
        ("contact force", vectors(|p| &p.contact)),
        ("stress", pads.iter().flat_map(|p| &p.stress).copied().collect()),
        ("travel", pads.iter().map(|p| p.travel).collect()),
        (
            "object motion",
            pads.iter().flat_map(|p| [p.translation.to_array(), p.rotation_vector.to_array()].concat()).collect(),
        ),
    ]
}

const FORCES: [f64; 7] = [0.5, 0.55, 0.6, 0.7, 0.8, 0.9, 1.0];

/// Encodes the grasp of the ball with `predictor`.
fn seen(predictor: &Predictor) -> EncodedGrasp {
    let (model, pose) = ball(made());
    let pads = predictor.pads_if_in_range(&model, false).unwrap();
    predictor.encode_first_contact(&pads, &pads.first_contact(pose).unwrap())
}

fn answer(predictor: &Predictor) -> Vec<GraspState> {
    predictor.states(&seen(predictor), &FORCES.map(GraspLoad::from)).unwrap()
}

#[test]
fn the_answers_are_those_of_the_tape() {
    let open = || Predictor::open(&made().model).unwrap();
    let (fast, tape) = (answer(&open()), answer(&open().on_tape()));
    for (level, (fast, tape)) in fast.iter().zip(&tape).enumerate() {
        for ((name, a), (_, b)) in lists(&fast.pads).iter().zip(&lists(&tape.pads)) {
            assert!(apart(a, b) < 1e-5, "{name} at {} N: {:e} relative", FORCES[level], apart(a, b));
        }
    }
}

#[test]
fn one_load_at_a_time_is_the_same_as_all_at_once() {
    let predictor = Predictor::open(&made().model).unwrap();
    let seen = seen(&predictor);
    for (force, together) in FORCES.iter().zip(predictor.states(&seen, &FORCES.map(GraspLoad::from)).unwrap()) {
        let alone = predictor.at(&seen, *force).unwrap();
        for ((name, a), (_, b)) in lists(&alone.pads).iter().zip(&lists(&together.pads)) {
            assert!(apart(a, b) < 1e-5, "{name} at {force} N: {:e} relative", apart(a, b));
        }
    }
}

#[test]
fn threads_change_no_bit() {
    let predictor = Predictor::open(&made().model).unwrap();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| answer(&predictor))
    };
    let one = on(1);
    for threads in [2, 3, 8] {
        assert_eq!(on(threads), one, "{threads} threads");
    }
}

/// As nodes come into contact with increasing force, predictions remain continuous: second differences are below 1e-3.
#[test]
fn the_answer_follows_the_force_without_jumps() {
    let predictor = Predictor::open(&made().model).unwrap();
    let seen = seen(&predictor);
    let forces: Vec<f64> = (0..=400).map(|k| 0.5 + 0.5 * f64::from(k) / 400.0).collect();
    let loads: Vec<GraspLoad> = forces.iter().copied().map(GraspLoad::from).collect();
    let states = predictor.states(&seen, &loads).unwrap();
    let all: Vec<_> = states.iter().map(|state| lists(&state.pads)).collect();
    for (k, three) in all.windows(3).enumerate() {
        for (kind, (name, now)) in three[1].iter().enumerate().take(4) {
            let mean: Vec<f64> = three[0][kind].1.iter().zip(&three[2][kind].1).map(|(a, b)| 0.5 * (a + b)).collect();
            let bend = apart(&mean, now);
            assert!(bend < 1e-3, "{name} bends by {bend:e} at {} N", forces[k + 1]);
        }
    }
}

/// All frames of an interpolated ramp agree with frames decoded one by one to a fifth of the network's predicted error
/// (for the object's motion: that of the displacement) and to 2 %.
#[test]
fn a_ramp_of_few_decoded_loads_has_all_others() {
    let predictor = Predictor::open(&made().sure).unwrap();
    let seen = seen(&predictor);
    let loads: Vec<GraspLoad> = (0..=100).map(|k| (0.5 + 0.005 * f64::from(k)).into()).collect();
    let ramp = LoadInterpolation::new(&predictor, &seen, &loads).unwrap();
    assert_eq!(ramp.len(), loads.len());
    assert!(ramp.decoded() < loads.len() / 4, "{} decoded loads", ramp.decoded());
    for (k, decoded) in predictor.states(&seen, &loads).unwrap().iter().enumerate() {
        let (own, error) = (ramp.at(k).unwrap(), decoded.error);
        for ((name, a), (_, b)) in
            lists(&own.pads).iter().zip(&lists(&decoded.pads)).filter(|((name, _), _)| *name != "contact force")
        {
            let stated = match *name {
                "stress" => error.stress,
                "travel" => error.travel,
                _ => error.displacement,
            };
            assert!(apart(a, b) < (stated / 5.0).min(0.02), "{name} at load {k}: {:e}, stated {stated:e}", apart(a, b));
        }
        // Interpolated contact forces still sum to the load.
        let pressed = |state: &GraspState| state.pads.iter().flat_map(|p| &p.contact).map(|f| f.z).sum::<f64>();
        assert!((pressed(&own) / pressed(decoded) - 1.0).abs() < 1e-5, "{} N at load {k}", pressed(&own));
    }
    assert!(ramp.at(loads.len()).is_none());
}

/// Interpolation does not change the error of the network against finite elements: the mean over fifty frames changes
/// by less than 0.0005.
#[test]
fn a_ramp_is_as_close_to_finite_elements_as_all_of_its_loads() {
    let text = "(object: (shape: Lemon(length: 0.06, diameter: 0.044)), gripper: (pads: GelSightMini(spacing: 2.6e-3)),
                 loading: Squeeze(force: 15.0, frames: 50), stepper: Fem(solver: Condensed()))";
    let scene = from_ron(text).unwrap();
    let (model, stepper) = (Model::build(&scene).unwrap(), choose(&scene).unwrap());
    let poses: Vec<_> = tactus::model::grasp::grasp_poses(&scene).unwrap().into_iter().enumerate().collect();
    let frames = Keep::default();
    run_grasps(&model, stepper.as_ref(), &poses, 2, &frames).unwrap();
    let truth = frames.0.into_inner().unwrap();

    let predictor = Predictor::open(Path::new("universe")).unwrap();
    let pads = predictor.pads_if_in_range(&model, false).unwrap();
    let seen = predictor.encode_first_contact(&pads, &pads.first_contact(poses[0].1).unwrap());
    let loads = frame_loads(&model);
    let ramp = LoadInterpolation::new(&predictor, &seen, &loads).unwrap();
    assert!(ramp.decoded() <= 20, "{} of {} loads are decoded", ramp.decoded(), loads.len());
    let mean_error = |state: &dyn Fn(usize) -> GraspState| {
        let of = |(k, frame): (usize, &Frame)| {
            let axes = model.fingers.iter().map(|finger| finger.placement.rotation.inverse());
            let exact =
                frame.pads.iter().zip(axes).flat_map(|(pad, axes)| pad.displacement.iter().map(move |u| axes * *u));
            apart(&lists(&state(k).pads)[0].1, &exact.flat_map(|u| u.to_array()).collect::<Vec<_>>())
        };
        truth.iter().enumerate().map(of).sum::<f64>() / truth.len() as f64
    };
    let decoded = predictor.states(&seen, &loads).unwrap();
    let (few, all) = (mean_error(&|k| ramp.at(k).unwrap()), mean_error(&|k| decoded[k].clone()));
    assert!(all < 0.15, "{all} off finite elements");
    assert!(few < all + 5e-4, "{few} off finite elements by a ramp, {all} by all loads");
}

/// A batch of grasps gives the same bits as single grasps, for any number of threads and composition of the batch.
#[test]
fn many_grasps_are_those_of_each_alone() {
    let predictor = Predictor::open(&made().model).unwrap();
    let (model, pose) = ball(made());
    let moved = |by: DVec3| Pose { position: pose.position + by, ..pose };
    // More grasps than are decoded together.
    let mut poses: Vec<Pose> = (0..19).map(|k| moved(DVec3::X * 1e-4 * f64::from(k))).collect();
    poses.splice(1..1, [moved(DVec3::Y), pose]);
    let states = |threads: usize, poses: &[Pose]| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let many = pool.install(|| predictor.predict_batch(&model, poses, false)).unwrap();
        many.into_iter()
            .map(|answer| answer.ok().and_then(|answer| answer.interpolation.at(answer.interpolation.len() - 1)))
            .collect::<Vec<_>>()
    };
    let all = states(1, &poses);
    assert!(all[0].is_some() && all[1].is_none(), "the second grasp meets nothing");
    assert_eq!(all[0], all[2]);
    assert!(all[0] != all[3]);
    assert_eq!(states(2, &poses), all);
    for k in [0, 7, 8, 20] {
        assert_eq!(states(1, &poses[k..=k])[0], all[k], "grasp {k}");
    }
}

/// An environment requires neither stress nor the interior of the pads: what it gets are the same bits.
#[test]
fn fields_that_a_scene_does_not_need_are_left_out_and_the_others_stay() {
    let predictor = Predictor::open(&made().model).unwrap();
    let (model, pose) = ball(made());
    let answer = |model: &Arc<Model>| {
        let pads = predictor.pads_if_in_range(model, false).unwrap();
        let seen = predictor.encode_first_contact(&pads, &pads.first_contact(pose).unwrap()).with_needed_fields();
        (pads.graph.clone(), predictor.states(&seen, &FORCES.map(GraspLoad::from)).unwrap())
    };
    let with = |needed: bool| {
        let mut model = (*model).clone();
        (model.needs.stress, model.needs.interior) = (needed, needed);
        // On the mesh of the canonical pads, so that nodes are comparable.
        let pads = predictor.pads_if_in_range(&Arc::new(model.clone()), false).unwrap();
        Arc::new(Model { fingers: pads.model.fingers.clone(), ..model })
    };
    let ((graph, whole), (_, needed)) = (answer(&with(true)), answer(&with(false)));
    for (a, b) in whole.iter().zip(&needed).flat_map(|(a, b)| a.pads.iter().zip(&b.pads)) {
        assert!(b.stress.is_empty() && !a.stress.is_empty());
        assert_eq!((a.travel, &a.contact, a.translation), (b.travel, &b.contact, b.translation));
        for node in 0..a.displacement.len() {
            let on_face = graph.face.contains(&(node as u32));
            let expected = if on_face { a.displacement[node] } else { DVec3::ZERO };
            assert_eq!(b.displacement[node], expected, "node {node}");
        }
    }
}
