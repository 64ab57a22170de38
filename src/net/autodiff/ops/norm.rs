//! Layer normalisation (Ba, Kiros and Hinton 2016).

use crate::autodiff::real::Real;
use crate::autodiff::tape::{Matrix, Tape};

/// Regularisation added to the variance.
const EPSILON: f32 = 1e-5;

/// Normalises every row of x (n, m) to mean 0 and variance 1, then multiplies it by `gain` (1, m) and adds `shift` (1,
/// m).
pub fn layer_norm<T: Real>(tape: &Tape<T>, x: &Matrix<T>, gain: &Matrix<T>, shift: &Matrix<T>) -> Matrix<T> {
    let m = x.cols;
    let (one, count) = (T::of(1.0), T::of(m as f32));
    let mut unit = Vec::with_capacity(x.value().len());
    let mut inverse = Vec::with_capacity(x.rows);
    for row in x.value().chunks_exact(m) {
        let mean = row.iter().copied().sum::<T>() / count;
        let variance = row.iter().map(|v| (*v - mean) * (*v - mean)).sum::<T>() / count;
        let scale = one / (variance + T::of(EPSILON)).sqrt();
        inverse.push(scale);
        unit.extend(row.iter().map(|v| (*v - mean) * scale));
    }
    let mut y = Vec::with_capacity(unit.len());
    for row in unit.chunks_exact(m) {
        y.extend(row.iter().zip(gain.value()).zip(shift.value()).map(|((u, g), s)| *u * *g + *s));
    }
    let (x, gain, shift) = (x.clone(), gain.clone(), shift.clone());
    let inputs = [x.clone(), gain.clone(), shift.clone()];
    tape.result(&inputs.each_ref(), (x.rows, m), y, move |grads, out| {
        if let Some(d) = grads.of(&gain) {
            for (g, u) in out.chunks_exact(m).zip(unit.chunks_exact(m)) {
                d.iter_mut().zip(g.iter().zip(u)).for_each(|(d, (g, u))| *d += *g * *u);
            }
        }
        if let Some(d) = grads.of(&shift) {
            out.chunks_exact(m).for_each(|g| d.iter_mut().zip(g).for_each(|(d, g)| *d += *g));
        }
        let Some(dx) = grads.of(&x) else { return };
        for (r, (g, u)) in out.chunks_exact(m).zip(unit.chunks_exact(m)).enumerate() {
            let du: Vec<T> = g.iter().zip(gain.value()).map(|(g, w)| *g * *w).collect();
            let mean = du.iter().copied().sum::<T>() / count;
            let along = du.iter().zip(u).map(|(d, u)| *d * *u).sum::<T>() / count;
            let own = dx[r * m..(r + 1) * m].iter_mut().zip(du.iter().zip(u));
            own.for_each(|(dx, (d, u))| *dx += inverse[r] * (*d - mean - *u * along));
        }
    })
}
