//! Von Mises norm of the deviatoric stress.

use crate::autodiff::tensor::{Matrix, Real, Tape, record, values};
use dfdx::prelude::{HasShape, SplitTape};

/// Regularisation that keeps the norm smooth at zero stress.
pub const STRESS_REGULARISATION: f32 = 1e-6;

/// Computes `sqrt(3 (a2 + b2 + a b + c2 + d2 + e2))` of every row (xx, yy, xy, yz, zx) of x (n, 5): (n, 1).
pub fn von_mises<E: Real, T: Tape<E>>(x: Matrix<E, T>) -> Matrix<E, T> {
    let (rows, cols) = *x.shape();
    assert_eq!(cols, 5, "a deviator has five components");
    let (two, three) = (E::of(2.0), E::of(3.0));
    let norm = |[a, b, c, d, e]: [E; 5]| {
        (three * (a * a + b * b + a * b + c * c + d * d + e * e) + E::of(STRESS_REGULARISATION * STRESS_REGULARISATION))
            .sqrt()
    };
    let given = values(&x);
    let y: Vec<E> = given.as_chunks::<5>().0.iter().map(|s| norm(*s)).collect();
    let ((x, tape), kept) = (x.split_tape(), y.clone());
    record(tape, (rows, 1), y, move |grads, dy| {
        let rows = grads.of(&x).as_chunks_mut::<5>().0.iter_mut().zip(given.as_chunks::<5>().0);
        for ((dx, [a, b, c, d, e]), (y, g)) in rows.zip(kept.iter().zip(dy)) {
            let scale = three * g / *y;
            dx[0] += scale * (*a + *b / two);
            dx[1] += scale * (*b + *a / two);
            dx[2] += scale * *c;
            dx[3] += scale * *d;
            dx[4] += scale * *e;
        }
    })
}
