//! Contact of a soft pad with the rigid object.
//!
//! A *contact edge* joins a point of one body to its closest point on the other: sample points of the pad to the object
//! ([`surface`]), and *contact vertices* of the object (vertices and points of sharp edges) to the pad
//! ([`contact_vertex`]), so that neither a smooth face nor a needle passes between samples. All edges have the same
//! [`law`]: a stiff penalty on the gap, and Coulomb friction.

mod candidate_list;
mod cells;
mod closest_point;
pub mod contact_vertex;
pub mod coulomb;
mod distance_sign;
pub mod edge;
mod edge_edge;
pub mod face_bounds;
mod folds;
mod gap_hessian;
pub mod ground;
mod incident_faces;
pub mod law;
mod nearby;
pub(crate) mod pair;
pub mod point_contact;
mod point_list;
mod pool;
pub mod surface;
mod vertex_state;

pub use contact_vertex::{ContactVertex, VertexContact};
pub use edge::EdgeState;
pub use ground::GroundContact;
pub use point_contact::PointContact;
pub use surface::{ContactSurface, SurfaceFace};
