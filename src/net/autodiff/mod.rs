//! Reverse-mode differentiation of the network: a tape, and operations with one forward and one backward kernel each.

mod gemm;
pub mod ops;
pub mod real;
pub mod tape;
