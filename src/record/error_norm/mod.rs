//! Distance between two frames of a grasp, also on different meshes: fields at common points (`fields.rs`), norms of
//! differences (`distance.rs`). Benches use it for errors, sensitivities for the effect of changes.

pub mod distance;
pub mod fields;

pub use distance::FrameDistance;
pub use fields::{FieldInterpolation, Fields, Points};
