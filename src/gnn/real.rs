//! The numbers that a network computes with: f32 in use, f64 where gradients are checked.

use dfdx::prelude::Dtype;

/// A floating-point number.
pub trait Real: Dtype + std::ops::Neg<Output = Self> + std::iter::Sum {
    /// `x` itself.
    fn of(x: f32) -> Self;
    /// The nearest f64.
    fn f64(self) -> f64;
    /// The nearest number to `x`.
    fn nearest(x: f64) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Exponential.
    fn exp(self) -> Self;
}

macro_rules! real {
    ($float:ty) => {
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

real!(f32);
real!(f64);
