//! Linear layer with other terms and an activation in one operation: dfdx takes a pass over memory, with computed
//! indices, for each of product, bias, sum and activation, and as many backward.

use super::Activation;
use crate::autodiff::tensor::{Matrix, Real, Tape, record, values};
use dfdx::prelude::{HasShape, Merge, SplitTape};
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};

/// View of a row-major matrix.
fn view<E>(values: &[E], (rows, cols): (usize, usize)) -> MatRef<'_, E> {
    MatRef::from_row_major_slice(values, rows, cols)
}

/// Adds the product of `a` and `b` to `out`, row-major.
fn add_product<E: Real>(out: &mut [E], a: MatRef<E>, b: MatRef<E>) {
    let out = MatMut::from_row_major_slice_mut(out, a.nrows(), b.ncols());
    matmul(out, Accum::Add, a, b, E::of(1.0), Par::Seq);
}

/// Computes `act(x W + bias + other terms)`: x (n, k), W (k, m), a row (1, m), terms (n, m) -> (n, m).
pub fn linear<E: Real, T: Tape<E>>(
    x: Matrix<E, T>,
    w: &Matrix<E>,
    bias: Option<&Matrix<E>>,
    terms: Vec<Matrix<E, T>>,
    act: Activation,
) -> Matrix<E, T> {
    let (x, tape) = x.split_tape();
    let (terms, tapes): (Vec<_>, Vec<T>) = terms.into_iter().map(SplitTape::split_tape).unzip();
    let tape = tapes.into_iter().fold(tape, Merge::merge);
    let ((n, k), m) = (*x.shape(), w.shape().1);
    assert!(
        w.shape().0 == k && terms.iter().all(|term| *term.shape() == (n, m)),
        "the shapes of a linear layer must match"
    );
    let mut z = match bias {
        Some(bias) => values(bias).repeat(n),
        None => vec![E::of(0.0); n * m],
    };
    for term in &terms {
        z.iter_mut().zip(values(term)).for_each(|(z, t)| *z += t);
    }
    add_product(&mut z, view(&values(&x), (n, k)), view(&values(w), (k, m)));
    let given = act.apply(&mut z);
    let (w, bias) = (w.clone(), bias.cloned());
    record(tape, (n, m), z, move |grads, mut dz| {
        act.differentiate(&given, &mut dz);
        let out = view(&dz, (n, m));
        add_product(grads.of(&w), view(&values(&x), (n, k)).transpose(), out);
        add_product(grads.of(&x), out, view(&values(&w), (k, m)).transpose());
        if let Some(bias) = &bias {
            let db = grads.of(bias);
            dz.chunks_exact(m).for_each(|row| db.iter_mut().zip(row).for_each(|(d, g)| *d += *g));
        }
        for term in &terms {
            grads.of(term).iter_mut().zip(&dz).for_each(|(d, g)| *d += *g);
        }
    })
}
