//! Inference of the face network: the same result as [`super::network::face`], without a tape.
//!
//! ```text
//! weights, packed once -> product.rs, activation.rs            registers
//! encode  features     -> message.rs (face.rs)                 once per grasp
//! decode  loads        -> heads.rs -> response.rs -> face.rs   all loads of a grasp at once, grasps together
//! ```
//! The tape is the reference, and a test compares both. Results are bitwise independent of threads.

pub mod answer;
pub mod arrays;
mod code;
pub mod doubt;
pub mod face;
pub mod force_ladder;
pub mod frame;
pub mod heads;
pub mod hold;
pub mod inputs;
pub mod many;
pub mod message;
mod output_arrays;
mod padded_rows;
pub mod predict;
mod predicted_state;
pub mod ramp;
pub mod response;
pub mod slopes;
pub mod touch;

pub use code::Code;
pub use face::{Decoding, FaceEngine};
