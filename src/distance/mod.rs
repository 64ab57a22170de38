//! Distance between two frames of a grasp, whatever their meshes: fields at common points (`fields.rs`), norms of differences
//! (`apart.rs`). A bench judges settings by it, a sensitivity how well posed a grasp is.

pub mod apart;
pub mod fields;

pub use apart::Distance;
pub use fields::{Fields, Points, Probe};
