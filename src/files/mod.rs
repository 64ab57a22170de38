//! Files: read with checks, written whole or not at all, in folders that one process writes at a time.

pub mod atomic;
pub mod include;
pub mod lock;
pub mod lock_file;
pub mod regular;
