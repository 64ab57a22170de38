//! Geometry: meshes and mesh files, shapes, pads, grasps.

#[path = "../fixtures/shape_common.rs"]
mod shape_common;
#[path = "../fixtures/skipped.rs"]
mod skipped;

mod antipodal;
mod grasp_files;
mod mesh_bad_input;
mod mesh_files;
mod mesh_geometry;
mod objects_from_the_wild;
mod pad_generate;
mod pad_place;
mod shape_closed_form;
mod shape_families;
mod shape_features;
mod shape_mesh_distance;
mod shape_ray;
mod shape_touch;
mod smooth_surface;
