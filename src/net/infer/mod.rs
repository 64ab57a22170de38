//! Inference of the face network: the same result as [`super::network::face`], without a tape.
//!
//! ```text
//! weights, packed once -> product.rs, activation.rs            registers
//! encode  features     -> message.rs (face.rs)                 once per grasp
//! decode  loads        -> heads.rs -> response.rs -> face.rs   all loads of a grasp at once, grasps together
//! ```
//! The tape is the reference, and a test compares both. Results are bitwise independent of threads.

pub mod arrays;
pub mod batch;
pub mod contact_correction;
pub mod face;
pub mod force_interpolation;
pub mod frame;
pub mod friction_margin;
pub mod grasp_output;
pub mod heads;
pub mod input_derivatives;
pub mod inputs;
mod latent_code;
pub mod load_interpolation;
pub mod message;
mod output_arrays;
mod padded_rows;
pub mod predict;
pub mod predicted_errors;
mod predicted_state;
pub mod response;

pub use face::{DecodeRequest, FaceEngine};
pub use latent_code::LatentCode;
