//! Equilibrium of a free object under contact forces.

use crate::autodiff::real::Real;
use crate::autodiff::tape::{Matrix, Tape};
use crate::linear_response::balance::ObjectBalance;
use std::sync::Arc;

/// Corrects the contact forces x (levels * pads * nodes, 3) of each load level so that the object is in equilibrium at
/// that level. Returns x itself if `balances` is empty. `mirror` holds the signs of the x and y components relative to
/// those of the pads.
pub fn balanced<T: Real>(
    tape: &Tape<T>,
    x: &Matrix<T>,
    balances: &[Arc<ObjectBalance>],
    mirror: [f32; 2],
) -> Matrix<T> {
    if balances.is_empty() {
        return x.clone();
    }
    let size = 3 * balances[0].nodes();
    assert!(x.cols == 3 && x.rows * 3 == size * balances.len(), "a balance is of all contact forces of a level");
    let mut y = x.value().to_vec();
    y.chunks_exact_mut(size).zip(balances).for_each(|(y, own)| own.balance(y, mirror));
    let (x, balances) = (x.clone(), balances.to_vec());
    let input = x.clone();
    tape.result(&[&input], (x.rows, 3), y, move |grads, mut back| {
        back.chunks_exact_mut(size).zip(&balances).for_each(|(back, own)| own.gradient(back, mirror));
        grads.add(&x, back);
    })
}
