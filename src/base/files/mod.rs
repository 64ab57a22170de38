//! Files: checked reading, atomic writing, and locks on folders.

pub mod atomic;
pub mod include;
pub mod lock;
pub mod lock_file;
pub mod regular;
