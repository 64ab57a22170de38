//! Distribution of one force over the nodes of a pad.

use crate::autodiff::tensor::{Matrix, Real, Tape, record, values};
use dfdx::prelude::{HasShape, SplitTape};

/// Computes the fractions of the force in every group of `size` rows of x (n, 3): a softmax of column 0, times (1,
/// column 1, column 2).
///
/// The fractions of a group are positive and sum to one, so contact forces made of them sum exactly to the force of the
/// finger.
pub fn share<E: Real, T: Tape<E>>(x: Matrix<E, T>, size: usize) -> Matrix<E, T> {
    let (rows, cols) = *x.shape();
    assert!(cols == 3 && rows.is_multiple_of(size), "shares are made of whole groups of three columns");
    let given = values(&x);
    let mut y = Vec::with_capacity(given.len());
    for group in given.chunks_exact(3 * size) {
        let top = group.chunks_exact(3).map(|r| r[0]).fold(E::neg_infinity(), E::max);
        let weight: Vec<E> = group.chunks_exact(3).map(|r| (r[0] - top).exp()).collect();
        let total: E = weight.iter().copied().sum();
        for (row, w) in group.chunks_exact(3).zip(&weight) {
            let s = *w / total;
            y.extend([s, s * row[1], s * row[2]]);
        }
    }
    let ((x, tape), kept) = (x.split_tape(), y.clone());
    record(tape, (rows, 3), y, move |grads, dy| {
        let dx = grads.of(&x);
        for start in (0..kept.len()).step_by(3 * size) {
            let own = start..start + 3 * size;
            let (x, y, dy, dx) = (&given[own.clone()], &kept[own.clone()], &dy[own.clone()], &mut dx[own]);
            let to_share = |i: usize| dy[i] + dy[i + 1] * x[i + 1] + dy[i + 2] * x[i + 2];
            let mean: E = (0..3 * size).step_by(3).map(|i| y[i] * to_share(i)).sum();
            for i in (0..3 * size).step_by(3) {
                dx[i] += y[i] * (to_share(i) - mean);
                dx[i + 1] += dy[i + 1] * y[i];
                dx[i + 2] += dy[i + 2] * y[i];
            }
        }
    })
}
