//! Grasps: poses of the hand in the object frame, from scene files and from `*_grasps.h5`.

mod h5;
mod pose;
mod resolve;

pub use h5::{read_grasps_h5, write_grasps_h5};
pub use pose::GraspPose;
pub use resolve::poses_of;
