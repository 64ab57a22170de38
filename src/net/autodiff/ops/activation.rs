//! Activation functions and their derivatives.

use crate::autodiff::tensor::Real;
use pulp::{Arch, Simd, WithSimd};
use serde::{Deserialize, Serialize};

/// Scalar activation function and its derivative. None needs exp, which does not vectorise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Activation {
    /// Identity.
    None,
    /// Gated linear unit with an algebraic sigmoid: `z (1 + z / sqrt(1 + z2)) / 2`.
    Gated,
    /// Positive function (squareplus, Barron 2021): `(z + sqrt(z2 + 1)) / 2`.
    Positive,
    /// Rectifier `max(z, 0)`.
    Relu,
}

impl Activation {
    /// Returns the value at `z`.
    #[inline(always)]
    fn value<E: Real>(self, z: E) -> E {
        let (zero, half, one) = (E::of(0.0), E::of(0.5), E::of(1.0));
        match self {
            Activation::None => z,
            Activation::Gated => half * z * (one + z / (one + z * z).sqrt()),
            // The other form avoids cancellation for z << 0.
            Activation::Positive => {
                let root = (z * z + one).sqrt();
                if z < zero { half / (root - z) } else { half * (z + root) }
            }
            Activation::Relu => {
                if z > zero {
                    z
                } else {
                    zero
                }
            }
        }
    }

    /// Returns the derivative at `z`.
    #[inline(always)]
    fn derivative<E: Real>(self, z: E) -> E {
        let (half, one) = (E::of(0.5), E::of(1.0));
        let root = (z * z + one).sqrt();
        match self {
            Activation::None => one,
            Activation::Gated => half * (one + z / root) + half * z / (root * root * root),
            Activation::Positive => half * (one + z / root),
            Activation::Relu => E::of(if z > E::of(0.0) { 1.0 } else { 0.0 }),
        }
    }

    /// Replaces `z` by the values, and returns what [`Self::differentiate`] needs of `z`.
    pub fn apply<E: Real>(self, z: &mut [E]) -> Vec<E> {
        if self == Activation::None {
            return Vec::new();
        }
        let given = z.to_vec();
        Arch::new().dispatch(Values(self, z));
        given
    }

    /// Replaces the gradient `dz` with respect to the values by that with respect to `z`.
    pub fn differentiate<E: Real>(self, z: &[E], dz: &mut [E]) {
        if self != Activation::None {
            Arch::new().dispatch(Slopes(self, z, dz));
        }
    }
}

/// Kernel of `y = act(z)`, in place.
struct Values<'a, E>(Activation, &'a mut [E]);

impl<E: Real> WithSimd for Values<'_, E> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.1.iter_mut().for_each(|z| *z = self.0.value(*z));
    }
}

/// Kernel of `dz = act'(z) dy`, in place.
struct Slopes<'a, E>(Activation, &'a [E], &'a mut [E]);

impl<E: Real> WithSimd for Slopes<'_, E> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        self.2.iter_mut().zip(self.1).for_each(|(dy, z)| *dy *= self.0.derivative(*z));
    }
}
