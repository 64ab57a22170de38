//! Cost of the features of a scene: the same squeeze with all of them, and with each removed.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use tactus::backend::choose;
use tactus::base::error::Result;
use tactus::model::Model;
use tactus::model::grasp::grasp_poses;
use tactus::scene::{ObjectMotion, Scene, from_ron};
use tactus::world::environment::Environment;

/// Returns a squeeze in twenty frames between condensed pads, of whose time recording is a measurable part.
fn scene(friction: f64, more: &str, motion: ObjectMotion) -> Result<Scene> {
    solved("Condensed()", friction, more, motion)
}

/// Returns the same squeeze with `solver`.
fn solved(solver: &str, friction: f64, more: &str, motion: ObjectMotion) -> Result<Scene> {
    let mut scene = from_ron(&format!(
        "(object: (shape: Ellipsoid(radii: (0.014, 0.02, 0.017)), density: 900.0),
          gripper: (pads: GelSightMini(spacing: 4e-3), friction: {friction}),
          loading: Squeeze(force: 6.0, frames: 20), stepper: Fem(solver: {solver}), {more})"
    ))?;
    scene.object.motion = motion;
    Ok(scene)
}

fn squeeze(c: &mut Criterion) {
    let (weight, nothing) = ("gravity: (0, 0, 9.81),", "record: (fields: []),");
    let scenes = [
        ("everything", scene(0.8, weight, ObjectMotion::Free)),
        ("without gravity", scene(0.8, "", ObjectMotion::Free)),
        // Without friction no weight can be held.
        ("without gravity and friction", scene(0.0, "", ObjectMotion::Free)),
        ("without a free object", scene(0.8, weight, ObjectMotion::Fixed)),
        ("without recording", scene(0.8, &format!("{weight} {nothing}"), ObjectMotion::Free)),
        ("without any of them", scene(0.0, nothing, ObjectMotion::Fixed)),
        // A free object without friction rotates farther until equilibrium, and condensed pads cost too little: the
        // cost of friction is measured with full pads and a fixed object.
        ("whole pads, fixed object", solved("Full", 0.8, "", ObjectMotion::Fixed)),
        ("whole pads, fixed object, without friction", solved("Full", 0.0, "", ObjectMotion::Fixed)),
    ];
    let mut group = c.benchmark_group("squeeze in 20 frames");
    for (name, scene) in scenes {
        let prepared = scene.and_then(|s| Ok((Model::build(&s)?, choose(&s)?, grasp_poses(&s)?)));
        let (model, stepper, poses) = prepared.unwrap_or_else(|e| panic!("{name}: {e}"));
        group.bench_function(name, |b| {
            b.iter(|| {
                let mut environment = Environment::new(&model, stepper.as_ref(), poses[0]);
                if let Ok(environment) = &mut environment {
                    while !environment.step().is_final() {}
                }
                black_box(environment.is_ok())
            })
        });
    }
    group.finish();
}

criterion_group! { name = benches; config = Criterion::default().sample_size(10); targets = squeeze }
criterion_main!(benches);
