//! Timings of signed distances and of complete presses.

use criterion::{Criterion, criterion_group, criterion_main};
use glam::DVec3;
use std::hint::black_box;
use std::path::Path;
use tactus::backend::choose;
use tactus::geometry::mesh::TriMesh;
use tactus::geometry::shape::{Shape, generate};
use tactus::model::Model;
use tactus::model::grasp::grasp_poses;
use tactus::scene::load;
use tactus::world::environment::Environment;

/// Times signed distances in closed form and to surface meshes, near the surface and far from it.
fn signed_distance(c: &mut Criterion) {
    let shapes = [generate::sphere(0.03, 64), generate::lemon(0.06, 0.044, 64)];
    for shape in shapes.into_iter().flatten() {
        let meshed = Shape::from_mesh(TriMesh::clone(&shape.surface)).map(|m| m.with_name(&shape.name));
        for (form, shape) in [("in closed form", Ok(shape)), ("as a mesh", meshed)] {
            let Ok(shape) = shape else { continue };
            let vertices = &shape.surface.vertices;
            let near: Vec<DVec3> =
                (0..1000).map(|i| vertices[7 * i % vertices.len()] * (1.0 + 2e-6 * i as f64)).collect();
            let far: Vec<DVec3> = near.iter().map(|q| *q + 3.0 * shape.bounding_radius).collect();
            for (place, points) in [("near", near), ("far", far)] {
                c.bench_function(&format!("signed distance of a {} {form}, 1000 points {place}", shape.name), |b| {
                    b.iter(|| points.iter().filter(|q| shape.distance.closest(**q, 1e-3).is_some()).count())
                });
            }
        }
    }
}

fn press(c: &mut Criterion) {
    for name in ["linear", "quadratic_coarse"] {
        let Ok(loaded) = load(Path::new(&format!("scenes/press/{name}.ron"))) else { continue };
        let (Ok(model), Ok(stepper), Ok(poses)) =
            (Model::build(&loaded.scene), choose(&loaded.scene), grasp_poses(&loaded.scene))
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
