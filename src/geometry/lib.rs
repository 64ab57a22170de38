//! Geometry: meshes and their files, shapes with their signed distance, meshes of pads.

pub mod aabb;
pub mod barycentric;
pub mod face_lookup;
pub mod height_field;
pub mod mesh;
pub mod pad;
pub mod pose;
pub mod shape;
pub mod triangle6;
pub mod wrench;

pub use aabb::Aabb;
pub use pose::Pose;
pub use wrench::Wrench;
