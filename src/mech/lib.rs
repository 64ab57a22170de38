//! Mechanics of soft pads and a rigid object, as the minimisation of an incremental potential.
//!
//! ```text
//! material -> element -> body (mesh, law, sparsity) -> potential (terms: elastic, inertia, ...) -> contact (terms, too)
//!          -> newton (one equilibrium) -> path (a load in increments)
//! ```

pub mod body;
pub mod contact;
pub mod element;
pub mod material;
pub mod newton;
pub mod path;
pub mod potential;
