//! Sum of terms and a bias with an activation, in one operation: every pointwise operation of dfdx costs a pass over
//! memory with computed indices, forward and backward.

use crate::autodiff::tensor::{Matrix, Real, Tape, record, split, values};
use dfdx::prelude::HasShape;
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
    fn slope<E: Real>(self, z: E) -> E {
        let (half, one) = (E::of(0.5), E::of(1.0));
        let root = (z * z + one).sqrt();
        match self {
            Activation::None => one,
            Activation::Gated => half * (one + z / root) + half * z / (root * root * root),
            Activation::Positive => half * (one + z / root),
            Activation::Relu => E::of(if z > E::of(0.0) { 1.0 } else { 0.0 }),
        }
    }
}

/// Kernel of `y = act(z)`.
struct Values<'a, E>(Activation, &'a [E]);

impl<E: Real> WithSimd for Values<'_, E> {
    type Output = Vec<E>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Vec<E> {
        self.1.iter().map(|z| self.0.value(*z)).collect()
    }
}

/// Kernel of `dz = act'(z) dy`.
struct Slopes<'a, E>(Activation, &'a [E], &'a [E]);

impl<E: Real> WithSimd for Slopes<'_, E> {
    type Output = Vec<E>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Vec<E> {
        self.1.iter().zip(self.2).map(|(z, dy)| self.0.slope(*z) * *dy).collect()
    }
}

/// Computes `act(a + b + ... + bias)` of matrices (n, m) and a row (1, m).
pub fn activate<E: Real, T: Tape<E>, const N: usize>(
    terms: [Matrix<E, T>; N],
    bias: Option<&Matrix<E>>,
    act: Activation,
) -> Matrix<E, T> {
    let (terms, tape) = split(terms);
    let shape = *terms[0].shape();
    assert!(terms.iter().all(|term| *term.shape() == shape), "terms of a sum have one shape");
    let mut z = values(&terms[0]);
    for term in &terms[1..] {
        z.iter_mut().zip(values(term)).for_each(|(z, t)| *z += t);
    }
    if let Some(bias) = bias.map(values) {
        z.chunks_exact_mut(shape.1).for_each(|row| row.iter_mut().zip(&bias).for_each(|(z, b)| *z += *b));
    }
    let linear = act == Activation::None;
    let (y, z) =
        if linear { (z, Vec::new()) } else { (Arch::new().dispatch(Values(act, &z)), z) };
    let bias = bias.cloned();
    record(tape, shape, y, move |grads, dy| {
        let product;
        let dz = if linear {
            dy
        } else {
            product = Arch::new().dispatch(Slopes(act, &z, dy));
            &product
        };
        if let Some(bias) = &bias {
            let db = grads.of(bias);
            dz.chunks_exact(shape.1).for_each(|row| db.iter_mut().zip(row).for_each(|(d, g)| *d += *g));
        }
        for term in &terms {
            grads.of(term).iter_mut().zip(dz).for_each(|(d, g)| *d += *g);
        }
    })
}
