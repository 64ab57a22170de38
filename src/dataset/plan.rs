//! Properties of a data set that are fixed before any simulation: names and sizes of its files, and a hash of
//! everything that determines their content.

use super::arrays::{FileSizes, MAX_REASON_BYTES};
use super::manifest::ObjectEntry;
use super::split::Splits;
use base::error::{Error, Result};
use base::interrupt;
use geometry::Aabb;
use geometry::Pose;
use geometry::mesh::TriMesh;
use model::Model;
use model::grasp::{aim_notice, resolve_grasps, resolve_object};
use model::part::object;
use rayon::prelude::*;
use scene::{Field, Loading, NamedScene, Scene, to_ron};
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// Object of a campaign.
#[derive(Debug)]
pub(super) struct PlannedObject {
    pub named: NamedScene,
    pub poses: Vec<Pose>,
    pub sizes: FileSizes,
    pub file: PathBuf,
    /// Upper bound of the total size of the object's files, bytes.
    pub limit: u64,
    /// Flag: the pads differ from those of the first object.
    pub own_pads: bool,
}

/// Pads of an object in a data set: the sizes of its file, and the bounds of a pad, m.
#[derive(Debug, Clone)]
pub(super) struct PlannedPads {
    pub sizes: FileSizes,
    bounds: Aabb,
}

impl PlannedPads {
    /// Returns the pads of `scene`.
    pub fn of(scene: &Scene) -> Result<Self> {
        let model = Model::build(&scene.without_finer_mesh())?;
        let sizes = FileSizes::of(&model, 0)?;
        Ok(Self { sizes, bounds: model.pad_bounds().unwrap_or(Aabb::EMPTY) })
    }
}

impl PlannedObject {
    /// Plans an object. `first` and `pads` are scene and pads of the first object; the pads are reused if pads and
    /// loading are equal.
    pub fn new(listed: &NamedScene, (first, pads): (&Scene, &PlannedPads)) -> Result<(Self, ObjectEntry)> {
        let mut named = listed.clone();
        // A data set holds all of these fields, regardless of what the scene records in a run.
        named.scene.record.fields = Field::DEFAULT.to_vec();
        let scene = &named.scene;
        let pad_of = |scene: &Scene| (scene.gripper.pads.clone(), scene.gripper.right.clone(), scene.gripper.fingers);
        let own_pads = pad_of(scene) != pad_of(first);
        let pads = if own_pads || scene.loading != first.loading { PlannedPads::of(scene)? } else { pads.clone() };
        let mut grasps = resolve_grasps(scene)?;
        let object = resolve_object(scene, &mut grasps.notices)?;
        let shape = object::build(&object, &mut Vec::new()).map_err(|e| e.with_field("object.shape"))?;
        grasps.notices.extend(aim_notice(scene, &shape, pads.bounds, &grasps.poses));
        let sizes = FileSizes { grasps: grasps.poses.len(), ..pads.sizes };
        let file = Path::new("dgs_output").join(file_name(&named));
        let entry = ObjectEntry {
            name: named.name.as_str().into(),
            file: file.clone(),
            grasps: sizes.grasps,
            bytes: 0,
            blake3: String::new(),
            seal: None,
            reached: 0,
            fault: 0,
            dropped: 0,
            infeasible: 0,
            notices: grasps.notices,
            failures: Vec::new(),
            expectations: Vec::new(),
        };
        let limit = sizes.bytes() + fixed_bytes(&sizes, &shape.surface);
        Ok((Self { named, poses: grasps.poses, sizes, file, limit, own_pads }, entry))
    }
}

/// Function that returns a score for each grasp of a scene.
pub type Score<'a> = dyn Fn(&Scene, &[Pose]) -> Result<Vec<f64>> + Sync + 'a;

/// Selection of the grasps of a data set with the largest scores.
pub struct Selection<'a> {
    /// Number of grasps that are kept; None keeps a quarter of them.
    pub keep: Option<usize>,
    /// Function that computes the scores of the grasps of a scene.
    pub score: &'a Score<'a>,
}

impl Selection<'_> {
    /// Removes all other grasps, and objects without a remaining grasp.
    ///
    /// # Errors
    /// Fails if a score cannot be computed.
    pub(super) fn apply(&self, objects: &mut Vec<PlannedObject>, entries: &mut Vec<ObjectEntry>) -> Result<()> {
        let of = |object: &PlannedObject| {
            interrupt::check()?;
            (self.score)(&object.named.scene, &object.poses)
        };
        let scores: Vec<Vec<f64>> = objects.par_iter().map(of).collect::<Result<_>>()?;
        let grasps =
            scores.iter().enumerate().flat_map(|(o, own)| own.iter().enumerate().map(move |(g, s)| (*s, o, g)));
        let mut order: Vec<(f64, usize, usize)> = grasps.collect();
        let keep = self.keep.unwrap_or_else(|| order.len().div_ceil(4));
        // The sort is stable: grasps with equal scores keep the order of the scene.
        order.sort_by(|a, b| b.0.total_cmp(&a.0));
        let kept: HashSet<(usize, usize)> = order.into_iter().take(keep).map(|(_, o, g)| (o, g)).collect();
        for (o, (object, entry)) in objects.iter_mut().zip(entries.iter_mut()).enumerate() {
            let before = object.sizes.bytes();
            let poses = object.poses.iter().enumerate().filter(|(g, _)| kept.contains(&(o, *g)));
            object.poses = poses.map(|(_, pose)| *pose).collect();
            (object.sizes.grasps, entry.grasps) = (object.poses.len(), object.poses.len());
            object.limit -= before - object.sizes.bytes();
        }
        objects.retain(|object| !object.poses.is_empty());
        entries.retain(|entry| entry.grasps > 0);
        Ok(())
    }
}

/// Returns the file name `<object>_<density>_tactus_<E>_<nu>_<load>.h5`, which the loader splits at `_`.
fn file_name(named: &NamedScene) -> String {
    let scene = &named.scene;
    let spec = scene.gripper.material.spec();
    let load = match &scene.loading {
        Loading::Squeeze(s) => format!("squeeze{}N", s.force.get()),
        Loading::Press(_) => "press".into(),
        Loading::Dynamic(_) => "dynamic".into(),
    };
    let (name, density) = (named.name.as_str(), scene.object.density.get());
    format!("{name}_{density}_tactus_{}_{}_{load}.h5", spec.young, spec.poisson)
}

/// Returns an upper bound of the size of the content that does not grow with the frames, bytes: headers and scene, pad,
/// object (HDF5 and STL), poses and records.
fn fixed_bytes(sizes: &FileSizes, surface: &TriMesh) -> u64 {
    let pad = sizes.pads * 25 * sizes.nodes + 2 * 120 * sizes.tets;
    let object = 24 * surface.vertices.len() + (12 + 50) * surface.triangles.len();
    (pad + object + (56 + MAX_REASON_BYTES + 512) * sizes.grasps + 65_536) as u64
}

/// Hashes everything that determines the content.
pub(super) fn plan_hash<'a>(
    objects: impl Iterator<Item = (&'a NamedScene, &'a [Pose])>,
    splits: &Splits,
) -> Result<String> {
    let mut hasher = blake3::Hasher::new();
    hasher.update(env!("CARGO_PKG_VERSION").as_bytes());
    for (named, poses) in objects {
        hasher.update(named.name.as_str().as_bytes());
        hasher.update(to_ron(&named.scene)?.as_bytes());
        for pose in poses {
            let (p, q) = (pose.position, pose.rotation);
            let numbers = p.to_array().into_iter().chain(q.to_array());
            numbers.for_each(|x| {
                hasher.update(&x.to_le_bytes());
            });
        }
    }
    let splits =
        serde_json::to_string(splits).map_err(|e| Error::Start(format!("the splits cannot be written: {e}")))?;
    hasher.update(splits.as_bytes());
    Ok(hasher.finalize().to_hex().to_string())
}
