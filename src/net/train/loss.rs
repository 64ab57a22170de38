//! Loss of a field, from dfdx operations.

use crate::autodiff::tensor::{Matrix, Rank0, Real, Tape, Tensor, matrix, row};
use dfdx::prelude::{Axis, HasShape, MeanTo, ReshapeTo, SumTo};

/// Single number, with the tape of its pass.
pub type LossValue<E, T> = Tensor<Rank0, E, <E as Real>::Device, T>;

/// Error below which the root is smoothed to a quadratic.
const SMOOTH: f32 = 1e-3;

/// Computes the loss of `x` (n, m) against `target` (n, m). For each of `groups` equal groups of rows, r is the root of
/// sum(weight * squared difference), with a `weight` (n) per row; the result is the mean of r / (1 + r). This bounded
/// function limits the influence of a few hard groups: the gradient almost vanishes where the error is several times
/// the size of the target.
pub fn bounded_relative_error<E: Real, T: Tape<E>>(
    x: Matrix<E, T>,
    target: Vec<f32>,
    weight: Vec<f32>,
    groups: usize,
) -> LossValue<E, T> {
    let (rows, cols) = *x.shape();
    assert!(rows.is_multiple_of(groups), "groups have equal size");
    let target = matrix(rows, cols, target.into_iter().map(E::of).collect());
    let square = (x - target).square().sum::<(usize,), Axis<1>>() * row(weight);
    let square = square.reshape_like(&(groups, rows / groups)).sum::<(usize,), Axis<1>>();
    let root = (square + E::of(SMOOTH * SMOOTH)).sqrt();
    // r / (1 + r) = 1 - 1 / (1 + r)
    ((root + E::of(1.0)).recip().negate() + E::of(1.0)).mean()
}
