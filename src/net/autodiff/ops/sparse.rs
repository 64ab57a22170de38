//! Product of a constant sparse matrix and a dense one.

use crate::autodiff::tensor::{Matrix, Real, Tape, record, values};
use crate::matrix::Sparse;
use dfdx::prelude::{HasShape, SplitTape};
use std::sync::Arc;

/// Computes `map * x` for every block of `map.cols()` rows of x: (blocks * cols, m) -> (blocks * rows, m).
pub fn sparse_product<E: Real, T: Tape<E>>(map: &Arc<Sparse>, x: Matrix<E, T>) -> Matrix<E, T> {
    let (rows, m) = *x.shape();
    assert_eq!(rows % map.cols().max(1), 0, "the number of rows must be a multiple of the columns of the sparse map");
    let y = map.times(&values(&x), m);
    let ((x, tape), map) = (x.split_tape(), map.clone());
    record(tape, (y.len() / m.max(1), m), y, move |grads, dy| map.add_transposed(&dy, grads.of(&x), m))
}
