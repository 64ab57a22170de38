//! Grasps: poses of the hand in the object frame, from scene files, from `*_grasps.h5`, or sampled.

mod aim;
pub mod antipodal;
mod h5;
mod resolve;

pub use aim::aim_notice;
pub use h5::{object_scale, read_grasp_file, read_grasps_h5, write_grasps_h5};
pub use resolve::{ResolvedGrasps, grasp_poses, keep_first, resolve_grasps, resolve_object, sample_grasps};
