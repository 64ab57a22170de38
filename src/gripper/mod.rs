//! The parallel gripper: where its pads are, how far its fingers travel before anything touches, what of it is in the way.

pub mod approach;
pub mod hand;
pub mod placement;
pub mod pose;

pub use approach::{Approach, approach};
pub use hand::Hand;
pub use placement::{FingerPlacement, SIDES};
pub use pose::GraspPose;
