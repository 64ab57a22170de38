//! Contact of a soft pad with the rigid object.
//!
//! A *contact edge* joins a point of one body to the surface of the other: points of the pad's surface to the object
//! ([`surface`]), and points of the object's features to the pad ([`feature`]), so that neither a smooth face nor a needle
//! slips between samples. All edges carry the same [`law`]: a stiff penalty on the gap, and Coulomb friction.

mod candidate_list;
mod cells;
mod closest_point;
pub mod coulomb;
mod distance_sign;
pub mod edge;
mod edge_edge;
pub mod feature;
mod folds;
mod gap_hessian;
pub mod ground;
mod incident_faces;
pub mod law;
mod nearby;
pub(crate) mod pair;
mod point_list;
mod pool;
pub mod project;
mod site;
pub mod surface;
pub mod term;

pub use edge::EdgeState;
pub use feature::{Feature, FeatureContact};
pub use ground::GroundContact;
pub use surface::{ContactSurface, SurfaceFace};
pub use term::PointContact;
