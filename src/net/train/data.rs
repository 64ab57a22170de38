//! Training data: grasps of a data set, their statistics and range, and the held-out validation grasps.

use crate::features::loads::{LoadFeatures, NODE_LOAD, PAD_LOAD};
use crate::features::normalise::Normaliser;
use crate::features::range::TrainedRange;
use crate::features::volume::{CONTACT_EDGE, MESH_EDGE, VOLUME_NODE, VolumeGraph};
use crate::features::{EDGE, NODE, PAD, Parity};
use crate::linear_response::canonical_pads::{CanonicalPadList, CanonicalPads};
use crate::linear_response::pad_graph::Layout;
use crate::network::{Normalisers, VolumeNormalisers};
use crate::train::sample::{LabelNodes, Sample, model_of};
use base::error::{Error, Result};
use base::interrupt;
use base::random::Random;
use dataset::split::{GraspNumbers, TrainTestSplit};
use dataset::{DataSet, Splits};
use model::Model;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::sync::Arc;

/// Returns training and test poses of each of `sets` by the name of a split: `poses`, `all`, `single:OBJECT`,
/// `without:OBJECT,OBJECT`. The last excludes objects of these names and all whose names begin with one and a `-`:
/// families of shapes of a universe.
///
/// # Errors
/// Fails if the split has no test poses in any data set; the message lists the available splits and objects.
pub fn split(sets: &[&Splits], name: &str) -> Result<Vec<TrainTestSplit>> {
    let of = |splits: &Splits| match name.split_once(':') {
        None if name == "poses" => Some(splits.poses.clone()),
        None if name == "all" => Some(splits.all()),
        Some(("single", object)) => splits.single(object),
        Some(("without", family)) => Some(splits.without(family)),
        _ => None,
    };
    let found: Vec<TrainTestSplit> = sets.iter().map(|splits| of(splits).unwrap_or_default()).collect();
    // Some data sets may lack the object, but not all.
    if found.iter().any(|split| !split.test.is_empty()) {
        return Ok(found);
    }
    let objects: Vec<&str> = sets.iter().flat_map(|s| s.poses.train.keys()).map(String::as_str).collect();
    let objects = objects.join(", ");
    Err(Error::Argument(format!(
        "--split {name}; allowed: poses, all, single:OBJECT and without:OBJECT; objects: {objects}"
    )))
}

/// Returns the identifier of the data sets' plans in a card: the plan of one, or a hash of several.
pub fn plan(sets: &[DataSet]) -> String {
    match sets {
        [set] => set.manifest.plan.clone(),
        several => {
            let mut hash = blake3::Hasher::new();
            several.iter().for_each(|set| {
                hash.update(set.manifest.plan.as_bytes());
            });
            hash.finalize().to_hex().to_string()
        }
    }
}

/// Builds the models of those objects of `set` that have a grasp in `grasps` (object, number), and takes their canonical
/// pads from `known` or adds them to it. Not within a parallel iteration: it holds the lock of `known` while it computes
/// in parallel.
///
/// # Errors
/// Fails if a scene cannot be built, or has pads without canonical ones.
pub(super) fn models_of(
    set: &DataSet,
    grasps: &[(usize, usize)],
    known: &CanonicalPadList,
) -> Result<BTreeMap<usize, (Arc<Model>, CanonicalPads)>> {
    let objects: BTreeSet<usize> = grasps.iter().map(|(object, _)| *object).collect();
    let objects: Vec<usize> = objects.into_iter().collect();
    let models = objects.par_iter().map(|o| model_of(&set.objects[*o])).collect::<Result<Vec<Arc<Model>>>>()?;
    let pads = known.of_models(&models)?;
    Ok(objects.into_iter().zip(models.into_iter().zip(pads)).collect())
}

/// Reads the grasps of each set's poses, at most `frames` frames of each with these `labels`, and their range. Their
/// canonical pads are taken from `known` or added to it.
///
/// # Errors
/// Fails for damaged files or grasps, for a mixture that one model cannot represent, and if there is no grasp.
pub fn read(
    sets: &[(&DataSet, &GraspNumbers)],
    known: &CanonicalPadList,
    labels: LabelNodes,
    frames: usize,
) -> Result<(Vec<Sample>, TrainedRange)> {
    let mut chosen = Vec::new();
    for (set, poses) in sets {
        if let Some(damaged) = set.damaged.first() {
            return Err(Error::Start(format!("the data set is damaged: {damaged}")));
        }
        set.objects.iter().try_for_each(|object| object.require_equal_pads("a network"))?;
        let grasps = set.select(poses);
        let models = models_of(set, &grasps, known)?;
        chosen.extend(grasps.into_iter().map(|(o, grasp)| (&set.objects[o], models[&o].1.clone(), grasp)));
    }
    let samples = chosen.par_iter().map(|(file, pads, grasp)| {
        interrupt::check()?;
        Sample::read(file, pads, *grasp, labels, frames)
    });
    let samples = samples.collect::<Result<Vec<_>>>()?;
    let mut range: Option<TrainedRange> = None;
    for (sample, (_, pads, _)) in samples.iter().zip(&chosen) {
        let own = TrainedRange::of(&pads.model, &sample.features, &sample.forces);
        match &mut range {
            Some(range) => range.extend(&own)?,
            None => range = Some(own),
        }
    }
    let empty = || Error::Start("the split has no grasp that reached its load".into());
    range.map(|range| (samples, range)).ok_or_else(empty)
}

/// Splits the fraction `part` of `samples` off, by a permutation of `seed`: (remaining, held out). With thirty objects
/// or more, they are held out object by object, since grasps of the same object are correlated. At least one sample
/// remains and, of two or more, at least one is held out.
pub fn split_validation(samples: Vec<Sample>, part: f64, seed: u64) -> (Vec<Sample>, Vec<Sample>) {
    let mut random = Random::new(seed);
    let mut objects: Vec<String> = samples.iter().map(|s| s.object.clone()).collect();
    objects.dedup();
    let mut order: Vec<usize> = (0..samples.len()).collect();
    random.shuffle(&mut order);
    if objects.len() >= MANY {
        random.shuffle(&mut objects);
        let place: HashMap<&str, usize> = objects.iter().enumerate().map(|(i, o)| (o.as_str(), i)).collect();
        order.sort_by_key(|i| place[samples[*i].object.as_str()]);
    }
    let count = ((samples.len() as f64 * part).round() as usize).clamp(1, samples.len().max(2) - 1);
    let held_out: HashSet<usize> = order.into_iter().take(count).collect();
    let (mut kept, mut out) = (Vec::new(), Vec::new());
    for (i, sample) in samples.into_iter().enumerate() {
        if held_out.contains(&i) { out.push(sample) } else { kept.push(sample) }
    }
    (kept, out)
}

/// Number of objects from which on samples are held out object by object.
const MANY: usize = 30;

/// Computes the statistics of a training set. The bounds of the features include those of the validation samples.
pub fn normalisers(samples: &[Sample], validation: &[Sample]) -> Normalisers {
    let loads: Vec<&LoadFeatures> = samples.iter().map(|s| &s.loads).collect();
    let rms = |values: &mut dyn Iterator<Item = f64>| {
        let (n, square) = values.fold((0.0, 0.0), |(n, s), v| (n + 1.0, s + v * v));
        (square / f64::max(n, 1.0)).sqrt().max(1e-12) as f32
    };
    let fit = |pick: fn(&Sample) -> &[f32], parity: &[Parity]| {
        Normaliser::fit(samples.iter().map(pick), parity).with_bounds_of(validation.iter().map(pick), parity)
    };
    // Stress over its unit: E times depth over thickness, for the depth of its level and pad.
    let stress = {
        let of = |(s, l): (&Sample, &&LoadFeatures)| {
            let width = s.stress.len() / l.depth.len();
            let unit = s.features.young / s.features.graph.thickness;
            let levels = s.stress.chunks_exact(width).zip(&l.depth);
            levels
                .flat_map(|(own, d)| own.iter().map(|v| f64::from(*v) / (d * unit)).collect::<Vec<_>>())
                .collect::<Vec<_>>()
        };
        rms(&mut samples.iter().zip(&loads).flat_map(of))
    };
    let travel: Vec<f64> = samples
        .iter()
        .zip(&loads)
        .flat_map(|(s, l)| s.travel.iter().zip(&l.travel).zip(&l.depth).map(|((x, prior), d)| (x - prior) / d))
        .collect();
    let mean = travel.iter().sum::<f64>() / travel.len() as f64;
    let motion = |turn: bool| {
        let of = |(s, l): (&Sample, &&LoadFeatures)| {
            let value = |(i, v): (usize, &f64)| {
                let d = l.depth[i / 6] / if turn { s.features.graph.thickness } else { 1.0 };
                ((i % 6 >= 3) == turn).then_some((v - l.motion[i]) / d)
            };
            s.motion.iter().enumerate().filter_map(value).collect::<Vec<_>>()
        };
        let mut values = samples.iter().zip(&loads).flat_map(of);
        rms(&mut values)
    };
    Normalisers {
        node: fit(|s| &s.features.node, &NODE),
        edge: fit(|s| &s.features.edge, &EDGE),
        pad: fit(|s| &s.features.pad, &PAD),
        node_load: fit(|s| &s.loads.node, &NODE_LOAD),
        pad_load: fit(|s| &s.loads.pad, &PAD_LOAD),
        volume: volume(samples, validation),
        displacement: beyond_response(samples, &loads),
        stress,
        travel: [mean as f32, rms(&mut travel.iter().map(|v| v - mean))],
        motion: [motion(false), motion(true)],
    }
}

/// Graph of the full pads, and the features of their contact edges at all forces.
type VolumeFeatures = (Arc<VolumeGraph>, Vec<f32>);

/// Computes the statistics of the full pads, if the samples have them.
fn volume(samples: &[Sample], validation: &[Sample]) -> Option<VolumeNormalisers> {
    let of = |s: &Sample| {
        let volume = s.features.volume.clone()?;
        let contact = s.loads.load.iter().flat_map(|load| volume.contact_edge(load.force)).collect();
        Some((volume, contact))
    };
    let all = |set: &[Sample]| set.iter().map(of).collect::<Option<Vec<VolumeFeatures>>>();
    let (own, beside) = (all(samples)?, all(validation)?);
    let fit = |pick: fn(&VolumeFeatures) -> &[f32], parity: &[Parity]| {
        Normaliser::fit(own.iter().map(pick), parity).with_bounds_of(beside.iter().map(pick), parity)
    };
    Some(VolumeNormalisers {
        node: fit(|(volume, _)| &volume.node, &VOLUME_NODE),
        mesh: fit(|(volume, _)| &volume.mesh_edge, &MESH_EDGE),
        contact: fit(|(_, contact)| contact, &CONTACT_EDGE),
    })
}

/// Returns the root mean square of the displacement beyond the linear response to the true contact forces, over the
/// depth.
fn beyond_response(samples: &[Sample], loads: &[&LoadFeatures]) -> f32 {
    let (mut count, mut square) = (0.0, 0.0);
    for (s, l) in samples.iter().zip(loads) {
        let (graph, width) = (&s.features.graph, s.displacement.len() / l.depth.len());
        let force: Vec<f32> = s.contact.iter().map(|f| f / s.features.unit_force() as f32).collect();
        // A network of the full pads predicts the total displacement.
        let pad = &graph.compliance;
        let given =
            matches!(graph.layout, Layout::Face { .. }).then(|| pad.scatter.times(&pad.displacements(&force), 3));
        for (i, u) in s.displacement.iter().enumerate() {
            let given = given.as_ref().map_or(0.0, |g| f64::from(g[i]) * graph.thickness);
            square += ((f64::from(*u) - given) / l.depth[i / width]).powi(2);
            count += 1.0;
        }
    }
    f64::sqrt(square / f64::max(count, 1.0)).max(1e-12) as f32
}
