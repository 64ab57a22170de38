//! Distance between two frames of a grasp, also on different meshes: fields at common points (`fields.rs`), norms of
//! differences (`apart.rs`). Benches use it for errors, sensitivities for the effect of changes.

pub mod apart;
pub mod fields;

pub use apart::Distance;
pub use fields::{FieldInterpolation, Fields, Points};
