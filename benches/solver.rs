//! Timings of the solver's parts: signed distance, assembly with factorisation, one whole press.

use criterion::{Criterion, criterion_group, criterion_main};
use glam::DVec3;
use std::hint::black_box;
use std::path::Path;
use tactus::environment::Environment;
use tactus::grasp::poses_of;
use tactus::model::Model;
use tactus::scene::load;
use tactus::shape::generate;
use tactus::stepper::choose;

fn signed_distance(c: &mut Criterion) {
    let Ok(lemon) = generate::lemon(0.06, 0.044, 64) else { return };
    let points: Vec<DVec3> = (0..1000).map(|i| DVec3::new(0.022 + 1e-6 * i as f64, 1e-5 * i as f64, 0.0)).collect();
    c.bench_function("signed distance of a lemon, 1000 points within 1 mm", |b| {
        b.iter(|| points.iter().filter(|q| lemon.distance.closest(**q, 1e-3).is_some()).count())
    });
}

fn press(c: &mut Criterion) {
    for name in ["linear", "quadratic_coarse"] {
        let Ok(loaded) = load(Path::new(&format!("scenes/press/{name}.ron"))) else { continue };
        let (Ok(model), Ok(stepper), Ok(poses)) =
            (Model::build(&loaded.scene), choose(&loaded.scene), poses_of(&loaded.scene))
        else {
            continue;
        };
        c.bench_function(&format!("press to 1 mm in 3 frames, {name}"), |b| {
            b.iter(|| {
                let mut environment = Environment::new(&model, stepper.as_ref(), poses[0]);
                if let Ok(environment) = &mut environment {
                    while !environment.step().is_final() {}
                }
                black_box(environment.is_ok())
            })
        });
    }
}

criterion_group! { name = benches; config = Criterion::default().sample_size(10); targets = signed_distance, press }
criterion_main!(benches);
