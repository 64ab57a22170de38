//! Product of a constant sparse matrix and a dense one, on a tape.

use crate::autodiff::real::Real;
use crate::autodiff::tape::{Matrix, Tape};
use crate::matrix::Sparse;
use std::sync::Arc;

/// Computes `map * x` for every block of `map.cols()` rows of x: (blocks * cols, m) -> (blocks * rows, m).
pub fn apply<T: Real>(tape: &Tape<T>, map: &Arc<Sparse>, x: &Matrix<T>) -> Matrix<T> {
    assert_eq!(x.rows % map.cols().max(1), 0, "a sparse map applies to whole blocks of rows");
    let y = map.times(x.value(), x.cols);
    let (rows, m) = (y.len() / x.cols.max(1), x.cols);
    let (map, x) = (map.clone(), x.clone());
    let input = x.clone();
    tape.result(&[&input], (rows, m), y, move |grads, out| {
        if let Some(dx) = grads.of(&x) {
            map.add_transposed(&out, dx, m);
        }
    })
}
