//! Von Mises norm of the deviatoric stress.

use crate::autodiff::real::Real;
use crate::autodiff::tape::{Matrix, Tape};

/// Regularisation that keeps the norm smooth at zero stress.
pub const LITTLE: f32 = 1e-6;

/// Computes `sqrt(3 (a2 + b2 + a b + c2 + d2 + e2))` of every row (xx, yy, xy, yz, zx) of x (n, 5): (n, 1).
pub fn von_mises<T: Real>(tape: &Tape<T>, x: &Matrix<T>) -> Matrix<T> {
    assert_eq!(x.cols, 5, "a deviator has five components");
    let (two, three) = (T::of(2.0), T::of(3.0));
    let norm = |[a, b, c, d, e]: [T; 5]| {
        (three * (a * a + b * b + a * b + c * c + d * d + e * e) + T::of(LITTLE * LITTLE)).sqrt()
    };
    let y: Vec<T> = x.value().as_chunks::<5>().0.iter().map(|s| norm(*s)).collect();
    let (x, kept) = (x.clone(), y.clone());
    let input = x.clone();
    tape.result(&[&input], (x.rows, 1), y, move |grads, out| {
        let Some(dx) = grads.of(&x) else { return };
        let rows = dx.as_chunks_mut::<5>().0.iter_mut().zip(x.value().as_chunks::<5>().0);
        for ((dx, [a, b, c, d, e]), (y, g)) in rows.zip(kept.iter().zip(out)) {
            let scale = three * g / *y;
            dx[0] += scale * (*a + *b / two);
            dx[1] += scale * (*b + *a / two);
            dx[2] += scale * *c;
            dx[3] += scale * *d;
            dx[4] += scale * *e;
        }
    })
}
