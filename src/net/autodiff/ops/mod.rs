//! Operations of the network, one per file, each with its forward and its backward kernel.

mod balance;
mod linear;
mod norm;
mod pointwise;
mod response;
mod share;
mod sparse;
mod von_mises;

pub use balance::balanced;
pub use linear::linear;
pub use norm::layer_norm;
pub use pointwise::{Activation, product, reshape, root_error, sum};
pub use response::{deviatoric_stress, displaced, respond};
pub use share::share;
pub use sparse::apply;
pub use von_mises::{LITTLE, von_mises};
