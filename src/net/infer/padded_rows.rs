//! Matrices with padded rows: padding, concatenation and products.

use crate::matrix::activation::Act;
use crate::matrix::product::{PackedMatrix, Product, RowsView, padded};
use pulp::Arch;

/// Returns a row padded with zeros.
pub(crate) fn padded_row(mut row: Vec<f32>) -> Vec<f32> {
    row.resize(padded(row.len()), 0.0);
    row
}

/// Concatenates matrices (rows, cols) horizontally, each padded.
pub(crate) fn concatenate_columns(parts: &[(Vec<f32>, usize)]) -> (Vec<f32>, usize) {
    let rows = parts[0].0.len() / parts[0].1;
    let all = (0..rows)
        .flat_map(|r| parts.iter().flat_map(move |(w, cols)| padded_row(w[r * cols..(r + 1) * cols].to_vec())));
    let all: Vec<f32> = all.collect();
    let cols = all.len() / rows;
    (all, cols)
}

/// Computes a product into `out`, whose rows have the padded length of those of the weights.
pub(crate) fn multiply(a: RowsView, w: &PackedMatrix, keep: bool, bias: Option<&[f32]>, act: Act, out: &mut [f32]) {
    let stride = w.cols;
    Arch::new().dispatch(Product { a, w, keep, bias, act, out, stride });
}
