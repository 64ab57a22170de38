//! tactus: a parallel gripper with two soft visual-tactile pads squeezes a rigid object.
#![warn(missing_docs)]

pub mod cli;
pub mod contact;
pub mod element;
pub mod error;
pub mod fem;
pub mod grasp;
pub mod gripper;
pub mod material;
pub mod mesh;
pub mod pad;
pub mod record;
pub mod render;
pub mod scene;
pub mod shape;
