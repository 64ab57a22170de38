//! Reading speed of a data set of the size of that of `scenes/paper.ron`: complete grasps, and frames into training
//! batches. The frames are synthetic, which does not affect reading.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use std::path::Path;
use tactus::base::random::Random;
use tactus::dataset::ObjectFile;
use tactus::dataset::arrays::FileSizes;
use tactus::dataset::compatible::LoaderFrame;
use tactus::dataset::file::{Writer, create};
use tactus::dataset::rows::Encoder;
use tactus::geometry::Pose;
use tactus::model::Model;
use tactus::record::{Frame, PadFrame, Status};
use tactus::scene::load_set;

const GRASPS: usize = 16;

fn made_up(model: &Model, index: usize, random: &mut Random) -> Frame {
    let pad = |f: &tactus::model::part::FingerModel| {
        let (nodes, tets) = (f.body.rest.len(), f.body.element_count());
        let mut vectors = || (0..nodes).map(|_| glam::DVec3::splat(random.uniform())).collect::<Vec<_>>();
        let (position, displacement, contact_force) = (vectors(), vectors(), vectors());
        let numbers = |n| vec![1e5; n];
        PadFrame {
            position,
            displacement,
            contact_force,
            von_mises_node: numbers(nodes),
            von_mises_element: numbers(tets),
            ..PadFrame::default()
        }
    };
    let pads: Vec<_> = model.fingers.iter().map(pad).collect();
    Frame { index, travel: vec![1e-3; pads.len()], pads, ..Frame::default() }
}

/// Writes the file of one object below `dir` and opens it.
fn file(dir: &Path) -> tactus::base::error::Result<ObjectFile> {
    let set = load_set("scenes/paper.ron")?;
    let named = &set.scenes[0];
    let model = Model::build(&named.scene)?;
    let sizes = FileSizes::of(&model, GRASPS)?;
    let encoder = Encoder::new(&model, sizes.clone(), LoaderFrame::new(&named.scene.gripper.placement));
    let path = dir.join("sphere.h5");
    create(&path, named, &model, &sizes, encoder.mirrored)?;
    let writer = Writer::open(&path, &sizes)?;
    let mut random = Random::new(1);
    let pose = Pose { position: glam::DVec3::ZERO, rotation: glam::DQuat::IDENTITY };
    for grasp in 0..GRASPS {
        let mut rows = encoder.rows(&pose);
        (0..sizes.frames).for_each(|k| encoder.frame(&mut rows, &made_up(&model, k, &mut random)));
        encoder.finish(&mut rows, Status::Reached, "", sizes.frames);
        writer.write(grasp, &rows)?;
    }
    ObjectFile::open(&path)
}

fn reading(c: &mut Criterion) {
    let Ok(dir) = tempfile::tempdir() else { return };
    let object = match file(dir.path()) {
        Ok(object) => object,
        Err(error) => return eprintln!("skipped: {error}"),
    };
    let mut random = Random::new(2);
    let mut group = c.benchmark_group("data set");
    group.throughput(Throughput::Bytes(object.sizes.bytes() / GRASPS as u64));
    group.bench_function("a grasp at random, checksum included", |b| {
        b.iter(|| black_box(object.grasp(random.uniform_below(GRASPS)).map(|g| g.frames)))
    });
    let (frames, values) = (object.sizes.frames, object.sizes.pads * object.sizes.nodes);
    let mut batch = vec![0_f32; frames * values * 4];
    group.throughput(Throughput::Elements(frames as u64));
    group.bench_function("frames of displacement and stress into a training batch", |b| {
        b.iter(|| {
            let Ok(grasp) = object.grasp(random.uniform_below(GRASPS)) else { return };
            let (displacement, stress) = batch.split_at_mut(3 * frames * values);
            displacement.copy_from_slice(&grasp.displacement);
            stress.copy_from_slice(&grasp.von_mises);
            black_box(&mut batch);
        })
    });
    group.finish();
}

criterion_group! { name = benches; config = Criterion::default().sample_size(20); targets = reading }
criterion_main!(benches);
