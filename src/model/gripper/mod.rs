//! Parallel gripper: placement of its pads, finger travel to first contact, and collision checks.

pub mod approach;
pub mod hand;
pub mod placement;

pub use approach::{Approach, approach};
pub use hand::Hand;
pub use placement::{FingerPlacement, SIDES};
