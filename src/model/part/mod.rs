//! Geometry and bodies of a scene: the object, and the pads on their fingers.

pub mod object;
pub mod pad;

pub use pad::FingerModel;
