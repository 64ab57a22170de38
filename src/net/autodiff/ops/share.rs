//! Distribution of one force over the nodes of a pad.

use crate::autodiff::real::Real;
use crate::autodiff::tape::{Matrix, Tape};

/// Computes the fractions of the force in every group of `size` rows of x (n, 3): a softmax of column 0, times (1,
/// column 1, column 2).
///
/// The fractions of a group are positive and sum to one, so contact forces made of them sum exactly to the force of the
/// finger.
pub fn share<T: Real>(tape: &Tape<T>, x: &Matrix<T>, size: usize) -> Matrix<T> {
    assert!(x.cols == 3 && x.rows.is_multiple_of(size), "shares are made of whole groups of three columns");
    let mut y = Vec::with_capacity(x.value().len());
    for group in x.value().chunks_exact(3 * size) {
        let top = group.chunks_exact(3).map(|r| r[0]).fold(T::of(f32::NEG_INFINITY), |a, b| if b > a { b } else { a });
        let weight: Vec<T> = group.chunks_exact(3).map(|r| (r[0] - top).exp()).collect();
        let total: T = weight.iter().copied().sum();
        for (row, w) in group.chunks_exact(3).zip(&weight) {
            let s = *w / total;
            y.extend([s, s * row[1], s * row[2]]);
        }
    }
    let (x, kept) = (x.clone(), y.clone());
    let input = x.clone();
    tape.result(&[&input], (x.rows, 3), y, move |grads, out| {
        let Some(dx) = grads.of(&x) else { return };
        for start in (0..kept.len()).step_by(3 * size) {
            let own = start..start + 3 * size;
            let (x, y, out, dx) = (&x.value()[own.clone()], &kept[own.clone()], &out[own.clone()], &mut dx[own]);
            let to_share = |i: usize| out[i] + out[i + 1] * x[i + 1] + out[i + 2] * x[i + 2];
            let mean: T = (0..3 * size).step_by(3).map(|i| y[i] * to_share(i)).sum();
            for i in (0..3 * size).step_by(3) {
                dx[i] += y[i] * (to_share(i) - mean);
                dx[i + 1] += out[i + 1] * y[i];
                dx[i + 2] += out[i + 2] * y[i];
            }
        }
    })
}
