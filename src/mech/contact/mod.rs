//! Contact of a soft pad with the rigid object.
//!
//! A *contact edge* joins a point of one body to the surface of the other: points of the pad's surface to the object
//! ([`surface`]), and points of the object's features to the pad ([`feature`]), so that neither a smooth face nor a needle
//! slips between samples. All edges carry the same [`law`]: a stiff penalty on the gap, and Coulomb friction.

mod bend;
mod cells;
mod crossing;
pub mod edge;
mod far;
pub mod feature;
mod flanks;
mod folds;
mod foot;
pub mod ground;
pub mod law;
pub(crate) mod pair;
mod pool;
pub mod project;
mod side;
mod site;
pub mod surface;
pub mod term;

pub use edge::ContactEdge;
pub use feature::{Feature, FeatureContact};
pub use ground::GroundContact;
pub use surface::{ContactSurface, Face};
pub use term::Contact;
