//! Training and evaluation on a tiny data set and network.

use crate::gnn_made::{PAPER, SPEC, command, made, ron, samples, set, train};
use dfdx::prelude::AsArray;
use std::process::Command;
use tactus::base::random::Random;
use tactus::geometry::Pose;
use tactus::model::Model;
use tactus::net::autodiff::tensor::{NoneTape, Real, SharedTape, Tape, gradients, values};
use tactus::net::features::normalise::Normaliser;
use tactus::net::features::{GraspFeatures, Parity};
use tactus::net::linear_response::GraspLoad;
use tactus::net::linear_response::canonical_pads::CanonicalPadList;
use tactus::net::linear_response::pad_graph::Layout;
use tactus::net::network::parameters::Parameters;
use tactus::net::network::spec::Spec;
use tactus::net::network::{Forward, Inputs, Network, Normalisers, build};
use tactus::net::train::loss::LossValue;
use tactus::net::train::sample::{LabelNodes, Sample, model_of};
use tactus::net::train::{data, sample_loss};
use tactus::scene::from_ron;

/// A network with its loss on one grasp.
struct Case {
    spec: Spec,
    sample: Sample,
    norms: Normalisers,
}

impl Case {
    fn new(spec: &str) -> Self {
        let spec: Spec = ron(spec);
        let layout = build::<f32>(&spec.network, Some(5)).0.layout();
        let samples = samples(made(), layout);
        Self { spec, norms: data::normalisers(&samples, &[]), sample: samples[0].clone() }
    }

    fn loss<E: Real, T: Tape<E>>(
        &self,
        tape: T,
        network: &(impl Forward<E, T> + ?Sized),
        parameters: &Parameters<E>,
    ) -> LossValue<E, T> {
        let (features, normalisers) = (&self.sample.features, &self.norms);
        let inputs = Inputs { features, normalisers, mirror: (true, false), tape };
        sample_loss(network, parameters, &inputs, &self.spec.training, &self.sample)
    }

    /// Returns the network with perturbed initial parameters; zero biases would put some ReLUs exactly at their kink.
    fn network<E: Real>(&self) -> (Box<dyn Network<E>>, Parameters<E>) {
        let (network, mut parameters) = build::<E>(&self.spec.network, Some(5));
        let mut random = Random::new(12);
        for m in &mut parameters.matrices {
            let moved = values(m).into_iter().map(|x| x + E::of((0.1 * (random.uniform() - 0.5)) as f32));
            m.copy_from(&moved.collect::<Vec<E>>());
        }
        (network, parameters)
    }

    /// Returns the gradient with respect to all parameters, concatenated.
    fn gradient<E: Real>(&self) -> Vec<f64> {
        let (network, parameters) = self.network::<E>();
        let loss = self.loss(SharedTape::default(), network.as_ref(), &parameters);
        let gradient = gradients(loss, &parameters.matrices);
        for (name, g) in parameters.names().iter().zip(&gradient) {
            assert!(g.iter().all(|v| v.is_finite()), "{name}: the gradient is not finite");
            // `start.pad` depends only on features that are constant in this data set (one material, no gravity).
            assert!(g.iter().any(|v| *v != E::of(0.0)) || name == "start.pad", "{name}: the gradient is all zero");
        }
        gradient.iter().flat_map(|g| g.iter()).map(|v| (*v).into()).collect()
    }

    /// Returns the loss with the parameters moved by `step` along `direction`.
    fn along(&self, direction: &[f64], step: f64) -> f64 {
        let (network, mut parameters) = self.network::<f64>();
        let mut direction = direction.iter();
        for m in &mut parameters.matrices {
            let moved: Vec<f64> = values(m).iter().zip(&mut direction).map(|(x, d)| x + step * d).collect();
            m.copy_from(&moved);
        }
        self.loss(NoneTape, network.as_ref(), &parameters).array()
    }
}

#[test]
fn the_gradient_of_a_whole_network_is_that_of_its_loss() {
    for spec in [SPEC, PAPER] {
        let case = Case::new(spec);
        let gradient = case.gradient::<f64>();
        let mut random = Random::new(11);
        let direction: Vec<f64> = gradient.iter().map(|_| 2.0 * random.uniform() - 1.0).collect();
        let along: f64 = gradient.iter().zip(&direction).map(|(g, d)| g * d).sum();
        // A small step to avoid the kinks of ReLU.
        let h = 1e-8;
        let difference = (case.along(&direction, h) - case.along(&direction, -h)) / (2.0 * h);
        let error = (difference - along).abs() / along.abs();
        assert!(error < 1e-6, "f64: difference {difference}, gradient {along}, relative {error:.1e}");
        let distance = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        let zero = vec![0.0; gradient.len()];
        let error = distance(&case.gradient::<f32>(), &gradient) / distance(&zero, &gradient);
        assert!(error < 1e-3, "f32: relative {error:.1e} from the gradient in f64");
    }
}

#[test]
fn training_and_inference_see_the_same_bits() {
    let made = made();
    let set = set(made);
    let (file, layout) = (&set.objects[0], Layout::Face { depths: 3 });
    let number = file.reached().next().unwrap();
    let stored = model_of(file).unwrap();
    let canonical = |model| CanonicalPadList::new(layout).of(model).unwrap();
    let trained = Sample::read(file, &canonical(&stored), number, LabelNodes::Canonical, 10).unwrap().features;
    // Inputs as in a run: the scene from text, the pose from the file, first contact computed again.
    let model = Model::build(&from_ron(&file.scene).unwrap()).unwrap();
    let pose = Pose::from_row(&file.grasp(number).unwrap().grasp_pose);
    let pads = canonical(&model);
    let run = GraspFeatures::new(&pads.model, &pads.graph, &pads.first_contact(pose).unwrap());
    let bits = |v: &[f32]| v.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&trained.node), bits(&run.node));
    assert_eq!(bits(&trained.edge), bits(&run.edge));
    assert_eq!(bits(&trained.pad), bits(&run.pad));
    let levels = [0.5, 1.0].map(GraspLoad::from);
    let (a, b) = (trained.loads(&levels), run.loads(&levels));
    assert_eq!((bits(&a.node), bits(&a.pad), a.depth), (bits(&b.node), bits(&b.pad), b.depth));
}

#[test]
fn garbage_in_what_fem_found_changes_no_bit_of_what_a_network_sees_or_says() {
    let made = made();
    let set = set(made);
    let file = &set.objects[0];
    let model = model_of(file).unwrap();
    let number = file.reached().next().unwrap();
    let clean = file.grasp(number).unwrap();
    let mut spoilt = clean.clone();
    for field in [&mut spoilt.displacement, &mut spoilt.contact_force, &mut spoilt.von_mises] {
        field.fill(f32::NAN);
    }
    for field in [&mut spoilt.travel, &mut spoilt.finger_position, &mut spoilt.object_pose, &mut spoilt.wrench] {
        field.fill(7.0e9);
    }
    for spec in [SPEC, PAPER] {
        let (network, parameters) = build::<f32>(&ron(spec).network, Some(5));
        let norms = data::normalisers(&samples(made, network.layout()), &[]);
        let pads = CanonicalPadList::new(network.layout()).of(&model).unwrap();
        let answer = |data| {
            let sample = Sample::of(file, &pads, (number, data), LabelNodes::Canonical, 10).unwrap();
            let inputs =
                Inputs { features: &sample.features, normalisers: &norms, mirror: (false, false), tape: NoneTape };
            let network: &dyn Forward = network.as_ref();
            let code = network.encode(&parameters, &inputs);
            let out = network.decode(&parameters, &inputs, &code, &sample.loads);
            let all = [out.displacement, out.stress, out.contact, out.travel, out.motion];
            all.iter().flat_map(values).map(|v| v.to_bits()).collect::<Vec<_>>()
        };
        assert!(answer(&clean) == answer(&spoilt), "the answer depends on what FEM found");
    }
}

#[test]
fn killed_and_resumed_training_ends_with_the_same_bits_on_any_number_of_threads() {
    let made = made();
    let out = made.tiny.out("again");
    let mut child = command(made, &out, &["--threads", "2"]).stdout(std::process::Stdio::null()).spawn().unwrap();
    // Killed as soon as there is a checkpoint; if training ends first, the test still compares numbers of threads.
    while child.try_wait().unwrap().is_none() && !out.join("checkpoint.bin").exists() {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    let _ = child.kill();
    child.wait().unwrap();
    if !out.join("card.ron").exists() {
        train(made, &out, &["--threads", "1"]);
    }
    for name in ["weights.safetensors", "curves.csv", "card.ron"] {
        let (a, b) = (std::fs::read(made.model.join(name)).unwrap(), std::fs::read(out.join(name)).unwrap());
        assert!(a == b, "{name} differs after a kill");
    }
}

#[test]
fn a_mirrored_grasp_costs_the_same_to_a_network_that_sees_it_mirrored() {
    let spec: Spec = ron(SPEC);
    let (network, _) = build::<f32>(&spec.network, Some(5));
    let samples = samples(made(), network.layout());
    let norms = data::normalisers(&samples, &[]);
    let features = &samples[0].features;
    let parity = tactus::net::features::NODE;
    let twice = norms.node.apply(&features.node, &parity, (true, false));
    let plain = norms.node.apply(&features.node, &parity, (false, false));
    for (a, b) in twice.chunks_exact(parity.len()).zip(plain.chunks_exact(parity.len())) {
        for (c, p) in parity.iter().enumerate() {
            assert_eq!(a[c], b[c] * p.sign((true, false)), "column {c}: normalising and mirroring commute");
        }
    }
}

#[test]
fn eval_judges_the_test_grasps() {
    let made = made();
    let mut command = Command::new(env!("CARGO_BIN_EXE_tactus"));
    command.arg("eval").arg(made.tiny.out("data")).arg("--model").arg(&made.model);
    let pictures = made.tiny.out("pictures");
    let done = command.args(["--format", "json", "-p"]).arg(&pictures).output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let report: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
    let grasps = report["grasps"].as_u64().unwrap();
    assert!(grasps > 0);
    let rows = report["tables"].as_array().unwrap();
    let all = rows.iter().find(|r| r["group"] == "all" && r["quantity"] == "displacement").unwrap();
    let number = |key: &str| all[key].as_f64().unwrap();
    assert!(number("median") > 0.0 && number("median") <= number("p90") && number("p90") <= number("worst"));
    assert_eq!(std::fs::read_dir(pictures).unwrap().count() as u64, grasps.min(5));
}

#[test]
fn what_training_never_showed_is_held_at_the_edge_of_what_it_did() {
    let parity = [Parity::Even, Parity::X];
    let rows = [1.0, 2.0, 3.0, -4.0];
    let norm = Normaliser::fit(std::iter::once(rows.as_slice()), &parity);
    let apply = |norm: &Normaliser, row: [f32; 2], x: bool| norm.apply(&row, &parity, (x, false));
    assert_eq!(apply(&norm, [3.5, 9.0], false), apply(&norm, [3.0, 4.0], false), "a mirror shows the other sign, too");
    assert_eq!(apply(&norm, [-1e6, -1e6], false), apply(&norm, [1.0, -4.0], false));
    let mirrored = |row: [f32; 2]| apply(&norm, [row[0], -row[1]], true);
    for row in [[2.0, 3.0], [0.0, 7.0], [2.0, -7.0]] {
        assert_eq!(apply(&norm, row, false), mirrored(row), "in a mirror as without");
    }
    let beside = [5.0, 0.0];
    let wider = norm.clone().with_bounds_of(std::iter::once(beside.as_slice()), &parity);
    assert_eq!(apply(&wider, [1.0, 4.0], false), apply(&norm, [1.0, 4.0], false), "only the bounds differ");
    assert!(apply(&wider, [5.0, 0.0], false)[0] > apply(&norm, [5.0, 0.0], false)[0]);
    let mut engine = [0.0; 3];
    norm.apply_to(&[3.5, 9.0], &mut engine, 3);
    assert_eq!(engine[..2], apply(&norm, [3.5, 9.0], false), "inference and training see the same");
    let earlier: Normaliser = ron::from_str("(mean: [1.0, 0.0], scale: [2.0, 1.0])").unwrap();
    assert_eq!(apply(&earlier, [1e6, -1e6], false), [(1e6 - 1.0) * 2.0, -1e6], "cards of earlier times have no bounds");
    let kept: Normaliser = ron::from_str(&ron::to_string(&norm).unwrap()).unwrap();
    assert_eq!(kept, norm);
}
