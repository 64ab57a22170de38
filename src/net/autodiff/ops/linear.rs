//! Linear layer with activation, `act(x W + b)`, in one operation.

use super::Activation;
use crate::autodiff::gemm::product;
use crate::autodiff::real::Real;
use crate::autodiff::tape::{Matrix, Tape};

/// Computes `act(x W + b)`: x (n, k), W (k, m), b (1, m) or None -> (n, m).
pub fn linear<T: Real>(
    tape: &Tape<T>,
    x: &Matrix<T>,
    w: &Matrix<T>,
    b: Option<&Matrix<T>>,
    act: Activation,
) -> Matrix<T> {
    let (n, k, m) = (x.rows, x.cols, w.cols);
    let mut z = match b {
        Some(b) => b.value().repeat(n),
        None => vec![T::of(0.0); n * m],
    };
    product((n, k, m), b.is_some(), &mut z, x.value(), w.value(), (false, false));
    let inputs: Vec<&Matrix<T>> = [x, w].into_iter().chain(b).collect();
    let (y, z) = act.applied(z);
    let (x, w, b) = (x.clone(), w.clone(), b.cloned());
    tape.result(&inputs, (n, m), y, move |grads, out| {
        let dz = act.sloped(out, &z);
        if let Some(dw) = grads.of(&w) {
            product((k, n, m), true, dw, x.value(), &dz, (true, false));
        }
        if let Some(db) = b.as_ref().and_then(|b| grads.of(b)) {
            dz.chunks_exact(m).for_each(|row| db.iter_mut().zip(row).for_each(|(d, g)| *d += *g));
        }
        if let Some(dx) = grads.of(&x) {
            product((n, m, k), true, dx, &dz, w.value(), (false, true));
        }
    })
}
