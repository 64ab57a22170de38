//! Parts of a scene as geometry and bodies: the object, the pads on their fingers.

pub mod object;
pub mod pad;

pub use pad::FingerModel;
