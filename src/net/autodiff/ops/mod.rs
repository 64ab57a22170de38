//! Operations that dfdx lacks or runs several times slower, one per file, each with its forward and its backward
//! kernel.

mod activation;
mod balance;
mod linear;
mod norm;
mod response;
mod sparse;
mod von_mises;

pub use activation::Activation;
pub use balance::balance_contact_forces;
pub use linear::linear;
pub use norm::layer_norm;
pub use response::{deviatoric_stress, free_displacement, scatter_to_nodes};
pub use sparse::sparse_product;
pub use von_mises::{STRESS_REGULARISATION, von_mises};
