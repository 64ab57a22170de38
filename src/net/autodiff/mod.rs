//! Differentiation of the network: a tape, and operations with a forward and a backward kernel each.

mod gemm;
pub mod ops;
pub mod real;
pub mod tape;
