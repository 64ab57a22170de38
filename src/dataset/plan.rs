//! Properties of a data set that are fixed before anything runs: names and sizes of its files, and a hash of all that decides their
//! content.

use super::arrays::{FileSizes, REASON};
use super::split::Splits;
use crate::error::{Error, Result};
use crate::geometry::mesh::TriMesh;
use crate::gripper::GraspPose;
use crate::scene::{Loading, NamedScene, to_ron};

/// Returns the file name `<object>_<density>_tactus_<E>_<nu>_<load>.h5`, which the loader splits at `_`.
pub(super) fn file_name(named: &NamedScene) -> String {
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

/// Returns the largest size of the content that does not grow with frames, bytes: headers and scene, pad, object (HDF5
/// and STL), poses and records.
pub(super) fn fixed_bytes(sizes: &FileSizes, surface: &TriMesh) -> u64 {
    let pad = 25 * sizes.nodes + 2 * 120 * sizes.tets;
    let object = 24 * surface.vertices.len() + (12 + 50) * surface.triangles.len();
    (pad + object + (56 + REASON + 512) * sizes.grasps + 65_536) as u64
}

/// Hashes everything that decides the content.
pub(super) fn plan_hash<'a>(
    objects: impl Iterator<Item = (&'a NamedScene, &'a [GraspPose])>,
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
