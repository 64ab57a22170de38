//! Reverse-mode differentiation of the network by dfdx, and the operations that dfdx lacks.

pub mod ops;
pub mod tensor;
