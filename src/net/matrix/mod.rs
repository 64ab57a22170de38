//! Numeric kernels on plain arrays: packed matrix products, activations on registers, sparse matrices, memory-mapped
//! arrays.

pub mod activation;
pub mod numbers;
pub mod product;
pub mod sparse;

pub use sparse::Sparse;

use std::iter::Sum;
use std::ops::{AddAssign, Mul, Neg};

/// Number type of the computation: f32, or f64 where gradients are checked.
pub trait Number: Copy + From<f32> + AddAssign + Mul<Output = Self> + Neg<Output = Self> + Sum {}

impl<T: Copy + From<f32> + AddAssign + Mul<Output = T> + Neg<Output = T> + Sum> Number for T {}
