//! Linear response of a pad: displacement of its nodes under forces on its face, and the stress of this displacement.

use super::sparse_product;
use crate::autodiff::tensor::{Matrix, Real, Tape, record, values};
use crate::linear_response::compliance::Compliance;
use dfdx::prelude::{HasShape, ReshapeTo, SplitTape};
use std::sync::Arc;

/// Linear map of rows: (rows, columns of the input) to (rows, columns of the result).
type LinearMap<E> = fn(&Compliance, &[E]) -> Vec<E>;

/// Applies `map` to the rows of x; `transpose` is its transpose. The result has `rows` rows.
fn mapped<E: Real, T: Tape<E>>(
    pad: &Arc<Compliance>,
    x: Matrix<E, T>,
    rows: usize,
    [map, transpose]: [LinearMap<E>; 2],
) -> Matrix<E, T> {
    let y = map(pad, &values(&x));
    let ((x, tape), pad) = (x.split_tape(), pad.clone());
    let cols = y.len() / rows.max(1);
    record(tape, (rows, cols), y, move |grads, dy| {
        let back = transpose(&pad, &dy);
        grads.of(&x).iter_mut().zip(back).for_each(|(d, g)| *d += g);
    })
}

/// Computes the displacement of the free (not bonded) nodes (n, moving nodes * 3), in the order of their slots, from
/// forces (n, forces).
pub fn free_displacement<E: Real, T: Tape<E>>(pad: &Arc<Compliance>, force: Matrix<E, T>) -> Matrix<E, T> {
    let rows = force.shape().0;
    mapped(pad, force, rows, [Compliance::displacements, Compliance::displacements_transposed])
}

/// Computes the deviatoric stress of all nodes (n * nodes, 5), xx, yy, xy, yz, zx, from the displacement of the free
/// nodes.
pub fn deviatoric_stress<E: Real, T: Tape<E>>(pad: &Arc<Compliance>, moved: Matrix<E, T>) -> Matrix<E, T> {
    let rows = moved.shape().0 * pad.nodes;
    mapped(pad, moved, rows, [Compliance::stresses, Compliance::stresses_transposed])
}

/// Scatters the displacement of the free nodes to all nodes (n * nodes, 3); zero where bonded.
pub fn scatter_to_nodes<E: Real, T: Tape<E>>(pad: &Compliance, moved: Matrix<E, T>) -> Matrix<E, T> {
    let (rows, cols) = *moved.shape();
    sparse_product(&pad.scatter, moved.reshape_like(&(rows * cols / 3, 3)))
}
