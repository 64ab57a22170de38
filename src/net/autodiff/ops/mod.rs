//! Operations that dfdx lacks or runs several times slower, one per file, each with its forward and its backward kernel.

mod activation;
mod balance;
mod linear;
mod norm;
mod response;
mod sparse;
mod von_mises;

pub use activation::Activation;
pub use balance::balanced;
pub use linear::linear;
pub use norm::layer_norm;
pub use response::{deviatoric_stress, displaced, respond};
pub use sparse::apply;
pub use von_mises::{LITTLE, von_mises};
