//! Times of the stages of a prediction of all frames of a grasp, with lower bounds from arithmetic and memory traffic.
//! The rates for these bounds are measured on the same thread in the same run: products of large matrices, and sums
//! over an array larger than the caches.

mod clock;

use clock::{best, sgemm};
use mimalloc::MiMalloc;
use std::hint::black_box;
use std::path::Path;
use tactus::base::error::{Error, Result};
use tactus::model::Model;
use tactus::model::grasp::grasp_poses;
use tactus::net::features::GraspFeatures;
use tactus::net::infer::load_interpolation::LoadInterpolation;
use tactus::net::infer::predict::Predictor;
use tactus::net::infer::response::RequiredFields;
use tactus::net::infer::{DecodeRequest, FaceEngine};
use tactus::net::linear_response::{GraspLoad, frame_loads};
use tactus::net::network::spec::NetworkSpec;
use tactus::scene::load;

/// Allocator of the program and the Python package.
#[global_allocator]
static ALLOCATOR: MiMalloc = MiMalloc;

const SCENE: &str = "scenes/lemon.ron";
const FRAMES: u64 = 50;

/// Measures the memory bandwidth for reading on one thread, bytes/s.
fn reading() -> f64 {
    let numbers = vec![1.0_f32; 1 << 26];
    let add = |sum: [f32; 32], v: &[f32; 32]| std::array::from_fn(|k| sum[k] + v[k]);
    let sum = |some: &[f32]| some.as_chunks::<32>().0.iter().fold([0.0; 32], add);
    let time = best(|| {
        black_box(sum(black_box(&numbers)));
    });
    size_of_val(numbers.as_slice()) as f64 / time
}

/// Stage of a prediction.
struct Stage {
    name: String,
    /// Wall time, s.
    time: f64,
    /// Lower bounds of the time, s: of its arithmetic, and of its memory traffic.
    least: Option<[f64; 2]>,
}

fn stages() -> Result<Vec<Stage>> {
    let mut scene = load(Path::new(SCENE))?.scene;
    scene.loading.set_frames(FRAMES).map_err(Error::Start)?;
    let model = Model::build(&scene)?;
    let pose = *grasp_poses(&scene)?.first().ok_or_else(|| Error::Start("the scene has no grasp".into()))?;
    let predictor = Predictor::open(Path::new("models/universe"))?;
    let NetworkSpec::Face(sizes) = &predictor.card.spec.network else {
        return Err(Error::Start("the model is no face network".into()));
    };
    let engine = FaceEngine::new(sizes, &predictor.parameters, &predictor.card.normalisers);
    let pads = predictor.pads_if_in_range(&model, true)?;
    let touch = pads.first_contact(pose)?;
    let features = GraspFeatures::new(&pads.model, &pads.graph, &touch);
    let seen = predictor.encode_first_contact(&pads, &touch);
    let all = frame_loads(&model);
    let ramp = LoadInterpolation::new(&predictor, &seen, &all)?;
    // The choice of loads does not affect times.
    let few: Vec<GraspLoad> = (0..ramp.decoded()).map(|k| all[k * all.len() / ramp.decoded()]).collect();
    let loads = features.loads(&few);
    let code = engine.encode(&features);
    let decoding = DecodeRequest { features: &features, code: &code, loads: &loads };

    let find = best(|| drop(black_box(pads.first_contact(pose))));
    let describe = best(|| drop(black_box(GraspFeatures::new(&pads.model, &pads.graph, &touch))));
    let encode = best(|| drop(black_box(engine.encode(&features))));
    // Alternately, because a stage is computed from their differences.
    let [mut balance, mut decode, mut answer] = [f64::INFINITY; 3];
    for _ in 0..4 {
        balance = balance.min(best(|| drop(black_box(features.loads(&few)))));
        decode = decode.min(best(|| drop(black_box(engine.decode(&[decoding], RequiredFields::ALL)))));
        answer = answer.min(best(|| drop(black_box(predictor.decode(&seen, &few)))));
    }
    let states = best(|| (0..all.len()).for_each(|load| drop(black_box(ramp.at(load)))));

    let (arithmetic, memory) = (sgemm(), reading());
    let (of_load, bytes) = engine.cost_of_load(&features, true);
    let stage = |name: &str, time| Stage { name: name.into(), time, least: None };
    let (frames, decoded) = (all.len(), few.len());
    Ok(vec![
        stage("first contact", find),
        stage("features of the grasp", describe),
        Stage { least: Some([engine.operations(&features) / arithmetic, 0.0]), ..stage("message passing", encode) },
        stage(&format!("equilibrium of the object under {decoded} loads"), balance),
        Stage {
            least: Some([decoded as f64 * of_load / arithmetic, bytes / memory]),
            ..stage(&format!("decoding of {decoded} loads"), decode)
        },
        stage("travel and interval of the error", answer - balance - decode),
        stage(&format!("{frames} frames from {decoded} loads"), states),
    ])
}

fn report() -> Result<()> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().map_err(|e| Error::Start(e.to_string()))?;
    let stages = pool.install(stages)?;
    println!("| stage | ms | least ms, arithmetic | least ms, memory |");
    println!("|---|---|---|---|");
    let ms = |s: f64| format!("{:.2}", 1e3 * s);
    for Stage { name, time, least } in &stages {
        let [arithmetic, memory] = least.map_or(["-".into(), "-".into()], |least| least.map(ms));
        println!("| {name} | {} | {arithmetic} | {memory} |", ms(*time));
    }
    let time = stages.iter().map(|stage| stage.time).sum();
    let products: f64 = stages.iter().filter(|stage| stage.least.is_some()).map(|stage| stage.time).sum();
    let least: f64 = stages.iter().filter_map(|stage| stage.least).map(|[a, m]| a.max(m)).sum();
    let [time, products, least, rest] = [time, products, least, time - products].map(ms);
    println!("\n{time} ms in all; products of matrices {products}, at least {least}; the rest {rest}.");
    Ok(())
}

fn main() {
    if let Err(error) = report() {
        eprintln!("{error}");
    }
}
