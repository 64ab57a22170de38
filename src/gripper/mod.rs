//! Parallel gripper: the places of its pads, the travel of its fingers to first contact, and its obstacles.

pub mod approach;
pub mod hand;
pub mod placement;
pub mod pose;

pub use approach::{Approach, approach};
pub use hand::Hand;
pub use placement::{FingerPlacement, SIDES};
pub use pose::GraspPose;
