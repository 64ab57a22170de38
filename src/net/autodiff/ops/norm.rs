//! Layer normalisation (Ba, Kiros and Hinton 2016).

use crate::autodiff::tensor::{Matrix, Real, Tape, record, values};
use dfdx::prelude::{HasShape, SplitTape};

/// Regularisation added to the variance.
const EPSILON: f32 = 1e-5;

/// Normalises every row of x (n, m) to mean 0 and variance 1, then multiplies it by `gain` (1, m) and adds `shift` (1,
/// m).
pub fn layer_norm<E: Real, T: Tape<E>>(x: Matrix<E, T>, gain: &Matrix<E>, shift: &Matrix<E>) -> Matrix<E, T> {
    let (rows, m) = *x.shape();
    let count = E::of(m as f32);
    let mut unit = values(&x);
    let mut inverse = Vec::with_capacity(rows);
    for row in unit.chunks_exact_mut(m) {
        let mean = row.iter().copied().sum::<E>() / count;
        let variance = row.iter().map(|v| (*v - mean) * (*v - mean)).sum::<E>() / count;
        let scale = (variance + E::of(EPSILON)).sqrt().recip();
        inverse.push(scale);
        row.iter_mut().for_each(|v| *v = (*v - mean) * scale);
    }
    let (factor, offset) = (values(gain), values(shift));
    let mut y = Vec::with_capacity(unit.len());
    for row in unit.chunks_exact(m) {
        y.extend(row.iter().zip(&factor).zip(&offset).map(|((u, g), s)| *u * *g + *s));
    }
    let ((x, tape), gain, shift) = (x.split_tape(), gain.clone(), shift.clone());
    record(tape, (rows, m), y, move |grads, dy| {
        let d = grads.of(&gain);
        for (g, u) in dy.chunks_exact(m).zip(unit.chunks_exact(m)) {
            d.iter_mut().zip(g.iter().zip(u)).for_each(|(d, (g, u))| *d += *g * *u);
        }
        let d = grads.of(&shift);
        dy.chunks_exact(m).for_each(|g| d.iter_mut().zip(g).for_each(|(d, g)| *d += *g));
        let dx = grads.of(&x);
        for (r, (g, u)) in dy.chunks_exact(m).zip(unit.chunks_exact(m)).enumerate() {
            let du: Vec<E> = g.iter().zip(&factor).map(|(g, w)| *g * *w).collect();
            let mean = du.iter().copied().sum::<E>() / count;
            let along = du.iter().zip(u).map(|(d, u)| *d * *u).sum::<E>() / count;
            let own = dx[r * m..(r + 1) * m].iter_mut().zip(du.iter().zip(u));
            own.for_each(|(dx, (d, u))| *dx += inverse[r] * (*d - mean - *u * along));
        }
    })
}
