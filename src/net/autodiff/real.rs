//! Number types of the network: f32 in use, f64 where gradients are checked.

use super::tape::Matrix;
use dfdx::prelude::Dtype;

/// Floating-point number.
pub trait Real: Dtype + From<f32> + std::ops::Neg<Output = Self> + std::iter::Sum {
    /// Converts `x` exactly.
    fn of(x: f32) -> Self;
    /// Returns the nearest f64.
    fn f64(self) -> f64;
    /// Returns the nearest number to `x`.
    fn nearest(x: f64) -> Self;
    /// Converts a matrix of f32.
    fn matrix(x: &Matrix) -> Matrix<Self>;
    /// Returns the square root.
    fn sqrt(self) -> Self;
    /// Returns the exponential.
    fn exp(self) -> Self;
}

macro_rules! real {
    ($float:ty, $matrix:expr) => {
        impl Real for $float {
            #[inline(always)]
            fn of(x: f32) -> Self {
                x.into()
            }
            #[inline(always)]
            fn f64(self) -> f64 {
                self.into()
            }
            #[inline(always)]
            fn nearest(x: f64) -> Self {
                x as $float
            }
            fn matrix(x: &Matrix) -> Matrix<Self> {
                $matrix(x)
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                <$float>::sqrt(self)
            }
            #[inline(always)]
            fn exp(self) -> Self {
                <$float>::exp(self)
            }
        }
    };
}

// For f32 the entries are shared, not copied.
real!(f32, Matrix::clone);
real!(f64, |x: &Matrix| Matrix::constant(x.rows, x.cols, x.value().iter().map(|v| f64::from(*v)).collect()));
