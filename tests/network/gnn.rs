//! The network as a stepper: invariances and consistency of its predictions, on a tiny data set and network.

use crate::dataset_tiny::TINY;
use crate::gnn_made::{Made, ball, made, set};
use glam::{DQuat, DVec3};
use std::sync::Arc;
use tactus::backend::network::NetworkStepper;
use tactus::base::random::Random;
use tactus::geometry::Pose;
use tactus::geometry::Wrench;
use tactus::mech::body::{Body, Elements};
use tactus::model::Model;
use tactus::model::part::FingerModel;
use tactus::net::infer::force_interpolation::ForceInterpolation;
use tactus::net::infer::predict::Predictor;
use tactus::record::Frame;
use tactus::scene::from_ron;
use tactus::world::components::*;
use tactus::world::environment::Environment;
use tactus::world::schedule::Phase;

/// Returns all frames of a grasp; `spoil` changes the world before every step under load.
fn frames(made: &Made, model: &Arc<Model>, pose: Pose, spoil: impl Fn(&mut Environment)) -> Vec<Frame> {
    let gnn = NetworkStepper::open(&made.model).unwrap();
    let mut environment = Environment::new(model, &gnn, pose).unwrap();
    let mut frames = Vec::new();
    loop {
        let phase = environment.step();
        frames.extend(environment.frame().cloned());
        if matches!(phase, Phase::Ramp { .. }) {
            spoil(&mut environment);
        }
        if phase.is_final() {
            assert_eq!(phase, Phase::Done);
            return frames;
        }
    }
}

#[test]
fn what_only_fem_knows_changes_no_bit() {
    let made = made();
    let (model, pose) = ball(made);
    let clean = frames(made, &model, pose, |_| {});
    let spoilt = frames(made, &model, pose, |environment| {
        let world = environment.world_mut();
        let mut nodes = world.query::<(&mut Position, &mut NodalStress, &mut ContactForce)>();
        for (mut x, mut stress, mut force) in nodes.iter_mut(world) {
            (x.0, stress.0, force.0) = (DVec3::splat(7.0), 1e9, DVec3::splat(-3.0));
        }
        world.query::<&mut TetStress>().iter_mut(world).for_each(|mut s| s.0 = 1e9);
        for mut wrench in world.query::<&mut FingerWrench>().iter_mut(world) {
            wrench.0 = Wrench { force: DVec3::splat(99.0), torque: DVec3::splat(99.0) };
        }
    });
    assert_eq!(clean, spoilt);
}

#[test]
fn bonded_nodes_stay_and_stress_and_force_are_what_they_must_be() {
    let made = made();
    let (model, pose) = ball(made);
    for frame in frames(made, &model, pose, |_| {}) {
        for (pad, finger) in frame.pads.iter().zip(&model.fingers) {
            let bonded = pad.displacement.iter().zip(&finger.topology.bonded).filter(|(_, b)| **b);
            assert!(bonded.clone().count() > 0 && bonded.clone().all(|(u, _)| *u == DVec3::ZERO), "bonded nodes, m");
            assert!(pad.von_mises_node.iter().all(|s| *s >= 0.0 && s.is_finite()), "stress, Pa");
            let normal = -pad.wrench.force.dot(finger.placement.closing);
            let given = frame.applied_force / 2.0;
            assert!((normal - given).abs() < 1e-5 * given, "a finger closed by {given} N presses with {normal} N");
        }
        assert!(frame.force_balance.is_finite() && frame.min_det_f.is_finite() && frame.min_gap.is_finite());
    }
}

#[test]
fn turning_object_and_hand_together_changes_nothing_in_the_hand() {
    let made = made();
    let set = set(made);
    let text = &set.objects[1].scene;
    let model = Model::build(&from_ron(text).unwrap()).unwrap();
    // A small rotation only: the tiny network was not trained on boxes standing on an edge.
    let turn = DQuat::from_scaled_axis(DVec3::new(0.002, 0.003, 0.0));
    let pose = Pose { position: turn * DVec3::new(0.0, 0.001, -0.1), rotation: turn };
    // A rotation by 180 degrees about the approach axis exchanges the fingers.
    let half = DQuat::from_rotation_z(std::f64::consts::PI);
    let swapped = Pose { position: pose.position, rotation: pose.rotation * half };
    let (a, b) = (frames(made, &model, pose, |_| {}), frames(made, &model, swapped, |_| {}));
    let longest = a[1].pads[0].displacement.iter().map(|u| u.length()).fold(0.0, f64::max);
    for (left, right) in [(0, 1), (1, 0)] {
        for (u, v) in a[1].pads[left].displacement.iter().zip(&b[1].pads[right].displacement) {
            let off = (half.inverse() * *u).distance(*v);
            assert!(off < 1e-3 * longest, "a turned scene turns the answer: off by {off} m of {longest} m");
        }
    }
}

#[test]
fn numbering_the_nodes_otherwise_numbers_the_answer_otherwise() {
    let made = made();
    let predictor = Predictor::open(&made.model).unwrap();
    let (model, pose) = ball(made);
    let finger = &model.fingers[0];
    let pad = &finger.topology;
    let n = pad.rest.len();
    let mut random = Random::new(2);
    let mut to: Vec<usize> = (0..n).collect();
    random.shuffle(&mut to);
    let mut renumbered = (**pad).clone();
    let mut rest = finger.body.rest.clone();
    for i in 0..n {
        (renumbered.rest[to[i]], renumbered.bonded[to[i]]) = (pad.rest[i], pad.bonded[i]);
        rest[to[i]] = finger.body.rest[i];
    }
    for (new, old) in [(&mut renumbered.sensing, &pad.sensing), (&mut renumbered.surface, &pad.surface)] {
        *new = old.iter().map(|t| t.map(|i| to[i as usize] as u32)).collect();
    }
    let Elements::Quadratic(tets) = &finger.body.elements else { panic!("the pads are quadratic") };
    let tets: Vec<[u32; 10]> = tets.iter().map(|t| t.map(|i| to[i as usize] as u32)).collect();
    renumbered.elements = tactus::record::ElementNodes::Quadratic(tets.clone());
    let (fixed, law) = (renumbered.bonded.clone(), finger.body.material.clone());
    let body = Body::new(rest, Elements::Quadratic(tets), fixed, law, finger.body.mean_dilatation);
    let other = FingerModel {
        body: Arc::new(body),
        surface: finger.surface.clone(),
        topology: Arc::new(renumbered),
        ..finger.clone()
    };
    let answer = |finger: &FingerModel| {
        let fingers = model.fingers.iter().map(|own| finger.placed(own.placement)).collect();
        let pads = predictor.canonical_pads(&Arc::new(Model { fingers, ..(*model).clone() })).unwrap();
        predictor.at(&predictor.encode_first_contact(&pads, &pads.first_contact(pose).unwrap()), 0.5).unwrap()
    };
    let (a, b) = (answer(finger), answer(&other));
    let longest = a.pads[0].displacement.iter().map(|u| u.length()).fold(0.0, f64::max);
    for (p, q) in a.pads.iter().zip(&b.pads) {
        for i in 0..n {
            let off = p.displacement[i].distance(q.displacement[to[i]]);
            assert!(off < 1e-4 * longest, "node {i}: off by {off} m of {longest} m");
        }
    }
}

#[test]
fn outside_the_trained_range_it_refuses_and_says_why() {
    let made = made();
    let predictor = Predictor::open(&made.model).unwrap();
    let text = set(made).objects[0].scene.clone();
    let refusal = |from: &str, to: &str| {
        assert!(text.contains(from), "the scene has {from}");
        let model = Model::build(&from_ron(&text.replace(from, to)).unwrap()).unwrap();
        predictor.pads_if_in_range(&model, false).unwrap_err().to_string()
    };
    assert!(predictor.pads_if_in_range(&ball(made).0, false).is_ok());
    assert!(refusal("force: 2.0", "force: 9.0").contains("outside the training range"));
    assert!(refusal("\"gelsight_mini\"", "\"tacgrasp\"").contains("nu"));
    assert!(refusal("shape: Flat", "shape: Domed").contains("the height of the dome of its pads is 0.31"));
    let finer = Model::build(&from_ron(&text.replace("spacing: 0.008", "spacing: 0.005")).unwrap()).unwrap();
    assert!(predictor.pads_if_in_range(&finer, false).is_ok(), "the mesh is no part of the range");
}

/// The pads of the scene are coarser than those of the network's data.
#[test]
fn a_bench_compares_the_network_with_finite_elements_on_the_pads_of_the_scene() {
    let made = made();
    let coarser = made.tiny.out("coarser.ron");
    std::fs::write(&coarser, TINY.replace("ELEMENT", "Quadratic").replace("spacing: 8e-3", "spacing: 11.3e-3"))
        .unwrap();
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_tactus"));
    command.arg("bench").arg(&coarser).arg("--model").arg(&made.model);
    let output = command.args("--object ball --grasps 2 --repeat 1 --format json".split(' ')).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["grasps"], serde_json::json!([0, 1]), "evenly spread over three");
    let points = report["points"].as_array().unwrap();
    let nodes = |label: &str| {
        let found = points.iter().find(|p| p["label"].as_str().is_some_and(|l| l.contains(label)));
        found.unwrap_or_else(|| panic!("no {label}"))["nodes"].as_u64().unwrap()
    };
    assert_eq!(nodes("network model"), nodes("quadratic 11.30 mm"), "not on the pads of the scene");
    assert!(nodes("quadratic 11.30 mm") < nodes("quadratic 7.99 mm"));
    let network = points.iter().find(|p| p["backend"] == "gnn").unwrap();
    assert!(network["displacement_error"].as_f64().is_some_and(|e| e > 0.0), "{network}");
    assert!(network["unknowns"].is_null() && network["profile"]["decode"].is_f64(), "{network}");
    // After six epochs the network is inaccurate, so that some setting of the finite elements reaches its error.
    let whole = &network["speedup_at_equal_error"];
    let (ratio, label) = (whole["ratio"].as_f64(), whole["against"].as_str());
    assert!(ratio.is_some_and(|r| r > 0.0) && label.is_some_and(|l| l.contains("quadratic") || l.contains("linear")));
    let cheapest = network["speedup_over_cheapest"]["ratio"].as_f64();
    assert!(cheapest.is_some() && cheapest <= ratio, "whole pads are among all finite elements: {network}");
    // Condensed pads may have a speed-up as well.
    assert!(
        report["speedup_at_equal_error"].as_f64() >= ratio,
        "the headline is the best of those that claim a speed-up"
    );
}

#[test]
fn a_ladder_of_forces_answers_an_agent_as_the_network_does() {
    let made = made();
    let predictor = Predictor::open(&made.model).unwrap();
    let (model, pose) = ball(made);
    let pads = predictor.canonical_pads(&model).unwrap();
    let seen = predictor.encode_first_contact(&pads, &pads.first_contact(pose).unwrap());
    let high = predictor.card.range.force[1] * seen.unit_force();
    let low = high / 7.0;
    let ladder = ForceInterpolation::new(&predictor, &seen, low, high).unwrap();
    for part in [0.03, 0.21, 0.5, 0.77, 0.99] {
        let force = low + part * (high - low);
        let (own, known) = (predictor.at(&seen, force).unwrap(), ladder.at(force, DVec3::ZERO).unwrap());
        for ((a, b), finger) in own.pads.iter().zip(&known.pads).zip(&model.fingers) {
            let size = a.displacement.iter().map(|u| u.length_squared()).sum::<f64>().sqrt();
            let off =
                a.displacement.iter().zip(&b.displacement).map(|(a, b)| a.distance_squared(*b)).sum::<f64>().sqrt();
            assert!(off < 1e-2 * size, "at {force} N displacements differ by {off} of {size} m");
            let pressed =
                -b.contact.iter().sum::<DVec3>().dot(finger.placement.rotation.transpose() * finger.placement.closing);
            assert!((pressed - force).abs() < 1e-5 * force, "a finger closed by {force} N presses with {pressed} N");
        }
    }
    assert!(ladder.at(1.01 * high, DVec3::ZERO).is_none(), "a ladder ends where its forces do");
}
