//! Foundation of all crates of tactus: the error type, atomic files, locks, the stop flag, state as bytes, number
//! formatting, and the scales of numerical methods.

pub mod error;
pub mod files;
pub mod interrupt;
pub mod machine;
pub mod number;
pub mod random;
pub mod saved_state;
pub mod scales;
pub mod stats;
pub mod table;
