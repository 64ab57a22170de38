//! The parallel gripper: where its pads are, and how far its fingers travel before anything touches.

pub mod approach;
pub mod placement;

pub use approach::{Approach, approach};
pub use placement::{Placement, SIDES};
