//! Time of a prediction, compared with the rate of matrix products on the same core in the same run, and its growth.
//!
//! The network is that in the folder named by `TACTUS_MODEL`, otherwise one of the default size with initial weights,
//! on which times do not depend. `torch_inference.py` times the same in other systems.

mod clock;

use clock::{best, sgemm};
use std::hint::black_box;
use std::sync::Arc;
use tactus::base::error::{Error, Result};
use tactus::model::Model;
use tactus::model::grasp::grasp_poses;
use tactus::net::autodiff::tensor::NoneTape;
use tactus::net::features::loads::{LoadFeatures, NODE_LOAD, PAD_LOAD};
use tactus::net::features::normalise::Normaliser;
use tactus::net::features::{EDGE, GraspFeatures, NODE, PAD};
use tactus::net::infer::predict::Predictor;
use tactus::net::infer::response::RequiredFields;
use tactus::net::infer::{DecodeRequest, FaceEngine};
use tactus::net::linear_response::edges::Edges;
use tactus::net::linear_response::first_contact::GeometricContact;
use tactus::net::linear_response::pad_graph::{Layout, PadGraph};
use tactus::net::linear_response::{GraspLoad, frame_loads};
use tactus::net::network::parameters::Parameters;
use tactus::net::network::spec::{Face, NetworkSpec};
use tactus::net::network::{Forward, Inputs, Network, Normalisers, build};
use tactus::scene::from_ron;

/// Features and loads of a grasp, and the network.
struct Case {
    features: GraspFeatures,
    loads: LoadFeatures,
    /// Loads in the batches in which they are decoded.
    pieces: Vec<LoadFeatures>,
    norms: Normalisers,
    network: Box<dyn Network>,
    parameters: Parameters,
    engine: FaceEngine,
}

impl Case {
    fn new(spacing: f64, frames: usize) -> Result<Self> {
        let scene = from_ron(&format!(
            "(object: (shape: Ellipsoid(radii: (0.035, 0.025, 0.02))),
              gripper: (pads: GelSightMini(shape: Flat, spacing: {spacing}), opening: 0.08, stroke: 0.04),
              loading: Squeeze(force: 15.0, frames: {frames}))"
        ))?;
        let model = Model::build(&scene)?;
        let pose = *grasp_poses(&scene)?.first().ok_or_else(|| Error::Start("no grasp".into()))?;
        let sizes = Face::default();
        let graph = PadGraph::new(&model.fingers[0], Layout::Face { depths: sizes.depths.get() })?;
        let features = GraspFeatures::new(&model, &Arc::new(graph), &GeometricContact::find(&model, pose)?);
        Ok(Self::of(features, sizes, &frame_loads(&model)))
    }

    fn of(features: GraspFeatures, sizes: Face, forces: &[GraspLoad]) -> Self {
        let loads = features.loads(forces);
        let fit = |rows: &[f32], parity: &[_]| Normaliser::fit(std::iter::once(rows), parity);
        let norms = Normalisers {
            node: fit(&features.node, &NODE),
            edge: fit(&features.edge, &EDGE),
            pad: fit(&features.pad, &PAD),
            node_load: fit(&loads.node, &NODE_LOAD),
            pad_load: fit(&loads.pad, &PAD_LOAD),
            volume: None,
            displacement: 1.0,
            stress: 1.0,
            travel: [0.0, 1.0],
            motion: [1.0, 1.0],
        };
        let trained = std::env::var_os("TACTUS_MODEL").and_then(|dir| Predictor::open(dir.as_ref()).ok());
        let trained = trained.filter(|t| t.card.spec.network == NetworkSpec::Face(sizes));
        let (network, parameters, norms) = match trained {
            Some(trained) => (trained.network, trained.parameters, trained.card.normalisers),
            None => {
                let (network, parameters) = build(&NetworkSpec::Face(sizes), Some(1));
                (network, parameters, norms)
            }
        };
        let engine = FaceEngine::new(&sizes, &parameters, &norms);
        let pieces = forces.chunks(FaceEngine::LOADS_PER_BATCH).map(|some| features.loads(some)).collect();
        Self { features, loads, pieces, norms, network, parameters, engine }
    }

    fn inputs(&self) -> Inputs<'_> {
        Inputs { features: &self.features, normalisers: &self.norms, mirror: (false, false), tape: NoneTape }
    }

    /// Measures the times of message passing and of decoding all loads without a tape, s.
    fn times(&self) -> [f64; 2] {
        let code = self.engine.encode(&self.features);
        let encode = best(|| drop(black_box(self.engine.encode(&self.features))));
        let decode = |loads| {
            drop(black_box(
                self.engine
                    .decode(&[DecodeRequest { features: &self.features, code: &code, loads }], RequiredFields::ALL),
            ));
        };
        [encode, best(|| self.pieces.iter().for_each(decode))]
    }

    /// Measures the same times on a tape, s.
    fn on_tape(&self) -> [f64; 2] {
        let (network, inputs): (&dyn Forward, _) = (self.network.as_ref(), self.inputs());
        let code = network.encode(&self.parameters, &inputs);
        let encode = best(|| drop(black_box(network.encode(&self.parameters, &inputs))));
        let decode = |loads: &LoadFeatures| drop(black_box(network.decode(&self.parameters, &inputs, &code, loads)));
        [encode, best(|| decode(&self.loads))]
    }
}

/// Returns the exponent of a power law fitted to (size, time) by least squares.
fn exponent(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let (x, y) = (logs.iter().map(|p| p.0).sum::<f64>() / n, logs.iter().map(|p| p.1).sum::<f64>() / n);
    let up: f64 = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    up / logs.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>()
}

fn report() -> Result<()> {
    let case = Case::new(2.6e-3, 50)?;
    let threads = |n: usize| rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("threads");
    let (one, two) = (threads(1), threads(2));
    let f = &case.features;
    println!(
        "two pads of {} nodes, {} on the face, {} directed edges; {} loads",
        f.graph.node_count,
        f.graph.face.len(),
        f.graph.edges.list.len(),
        case.loads.load.len()
    );
    let (mut rate, mut time, mut tape) = (0.0_f64, [f64::INFINITY; 2], [f64::INFINITY; 2]);
    let mut both = [f64::INFINITY; 2];
    // Alternately, so that other load on the machine affects all equally.
    let least = |a: &mut [f64; 2], b: [f64; 2]| a.iter_mut().zip(b).for_each(|(a, b)| *a = a.min(b));
    for _ in 0..3 {
        rate = rate.max(one.install(sgemm));
        least(&mut time, one.install(|| case.times()));
        least(&mut both, two.install(|| case.times()));
        least(&mut tape, one.install(|| case.on_tape()));
    }
    let ms = |t: [f64; 2]| format!("pass {:.2} ms, {} loads {:.2} ms", t[0] * 1e3, case.loads.load.len(), t[1] * 1e3);
    println!("one thread: {}; two threads: {}; on a tape: {}", ms(time), ms(both), ms(tape));
    let reached = case.engine.operations(f) / time[0];
    println!(
        "sgemm {:.1} GFLOP/s, message passing {:.1} GFLOP/s: {:.0} %",
        rate * 1e-9,
        reached * 1e-9,
        100.0 * reached / rate
    );
    one.install(|| growth(&case))
}

fn growth(case: &Case) -> Result<()> {
    let sizes = [5e-3, 4e-3, 3.2e-3, 2.6e-3, 2.1e-3];
    let (mut nodes, mut loads) = (Vec::new(), Vec::new());
    for spacing in sizes {
        let case = Case::new(spacing, 16)?;
        let n = case.features.graph.face.len() as f64;
        let [pass, ramp] = case.times();
        println!("{n} face nodes: pass {:.3} ms, 16 loads {:.3} ms", pass * 1e3, ramp * 1e3);
        nodes.push((n, pass));
        loads.push((case.features.graph.compliance.response.len() as f64, ramp));
    }
    println!("pass ~ nodes^{:.2}; loads ~ entries of the linear response^{:.2}", exponent(&nodes), exponent(&loads));
    let mut edges = Vec::new();
    for rings in 1..=4 {
        let mut features = case.features.clone();
        let mut graph = (*features.graph).clone();
        widen(&mut graph, rings);
        let edge = graph.edges.list.iter().flat_map(|(s, r)| {
            let d = (graph.rest[*s as usize] - graph.rest[*r as usize]) / graph.thickness;
            [d.x, d.y, d.z, d.length()].map(|v| v as f32)
        });
        features.edge = edge.collect::<Vec<_>>().repeat(features.pads);
        features.graph = Arc::new(graph);
        let case = Case::of(features, Face::default(), &[GraspLoad::from(1.0)]);
        let pass = case.times()[0];
        println!("{} edges: pass {:.3} ms", case.features.graph.edges.list.len(), pass * 1e3);
        edges.push((case.features.graph.edges.list.len() as f64, pass));
    }
    // The time is affine in the number of edges: the intercept is the cost of nodes.
    let [first, last] = [edges[0], edges[edges.len() - 1]];
    let each = (last.1 - first.1) / (last.0 - first.0);
    println!("an edge costs {:.1} ns: time = {:.3} ms + edges", each * 1e9, (first.1 - each * first.0) * 1e3);
    let worst = edges.iter().map(|(n, t)| (t / (first.1 + each * (n - first.0)) - 1.0).abs()).fold(0.0, f64::max);
    println!("farthest from that line: {:.1} %", worst * 100.0);
    let mut batch = Vec::new();
    for levels in [16, 32, 64, 128, 256] {
        let forces: Vec<f64> = (1..=levels).map(|i| 7.5 * i as f64 / levels as f64).collect();
        let loads: Vec<GraspLoad> = forces.iter().map(|force| (*force).into()).collect();
        let case = Case::of(case.features.clone(), Face::default(), &loads);
        let ramp = case.times()[1];
        println!("{levels} loads: {:.2} ms", ramp * 1e3);
        batch.push((f64::from(levels), ramp));
    }
    println!("loads ~ number^{:.2}", exponent(&batch));
    Ok(())
}

/// Connects nodes that are up to `rings` edges apart.
fn widen(graph: &mut PadGraph, rings: usize) {
    let n = graph.face.len();
    let mut near: Vec<Vec<u32>> = vec![Vec::new(); n];
    graph.edges.list.iter().for_each(|(s, r)| near[*r as usize].push(*s));
    let mut pairs = Vec::new();
    for i in 0..n as u32 {
        let mut found = vec![i];
        for _ in 0..rings {
            let next: Vec<u32> = found.iter().flat_map(|j| near[*j as usize].clone()).collect();
            found.extend(next);
            found.sort_unstable();
            found.dedup();
        }
        pairs.extend(found.into_iter().filter(|j| *j != i).map(|j| (i, j)));
    }
    graph.edges = Edges::new(pairs, n, 6.0);
}

fn main() {
    if let Err(error) = report() {
        eprintln!("{error}");
    }
}
