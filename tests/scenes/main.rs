//! Scenes: reading of scene files, and the expectations of every shipped scene.

#[path = "../fixtures/common.rs"]
mod common;
#[path = "../fixtures/keep.rs"]
mod keep;
#[path = "../fixtures/promises.rs"]
mod promises;
#[path = "../fixtures/skipped.rs"]
mod skipped;

mod audit;
mod campaign;
mod certified;
mod expected_effort;
mod files_from_the_wild;
mod finer_pads;
mod links;
#[cfg(unix)]
mod mutations;
mod object_surface;
mod outcomes;
mod real_grasps;
mod reference;
mod robots;
mod scene_cli;
mod scene_errors;
mod scene_expect;
mod scene_include;
mod scene_load;
mod scenes_checked;
mod shipped;
mod snapshots;
mod summary;
mod torture;
mod torture_meshes;
mod uneven_pads;
