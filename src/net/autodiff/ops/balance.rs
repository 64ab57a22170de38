//! Equilibrium of a free object under contact forces.

use crate::autodiff::tensor::{Matrix, Real, Tape, record, values};
use crate::linear_response::balance::ObjectBalance;
use dfdx::prelude::{HasShape, SplitTape};
use std::sync::Arc;

/// Corrects the contact forces x (levels * pads * nodes, 3) of each load level so that the object is in equilibrium at
/// that level. Returns x itself if `balances` is empty. `mirror` holds the signs of the x and y components relative to
/// those of the pads.
pub fn balance_contact_forces<E: Real, T: Tape<E>>(
    x: Matrix<E, T>,
    balances: &[Arc<ObjectBalance>],
    mirror: [f32; 2],
) -> Matrix<E, T> {
    if balances.is_empty() {
        return x;
    }
    let ((rows, cols), size) = (*x.shape(), 3 * balances[0].nodes());
    assert!(cols == 3 && rows * 3 == size * balances.len(), "a balance must have all contact forces of a level");
    let mut y = values(&x);
    y.chunks_exact_mut(size).zip(balances).for_each(|(y, own)| own.balance(y, mirror));
    let ((x, tape), balances) = (x.split_tape(), balances.to_vec());
    record(tape, (rows, 3), y, move |grads, mut back| {
        back.chunks_exact_mut(size).zip(&balances).for_each(|(back, own)| own.gradient(back, mirror));
        grads.of(&x).iter_mut().zip(back).for_each(|(d, g)| *d += g);
    })
}
