//! Operations entry by entry: sums with an activation, reshaping, the squared error.

use crate::gnn::tape::{Matrix, Tape};
use serde::{Deserialize, Serialize};

/// A function of one number, with its slope. All are smooth and made of a square root, which vectorises; exp does not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Activation {
    /// The number itself.
    None,
    /// `z (1 + z / sqrt(1 + z2)) / 2`: a gated linear unit with an algebraic gate.
    Gated,
    /// `(z + sqrt(z2 + 1)) / 2`, above zero everywhere (squareplus, Barron 2021).
    Positive,
}

impl Activation {
    /// Its value at `z`.
    #[inline(always)]
    pub fn value(self, z: f32) -> f32 {
        match self {
            Activation::None => z,
            Activation::Gated => 0.5 * z * (1.0 + z / (1.0 + z * z).sqrt()),
            // For z << 0 the sum would cancel.
            Activation::Positive => {
                let root = (z * z + 1.0).sqrt();
                if z < 0.0 { 0.5 / (root - z) } else { 0.5 * (z + root) }
            }
        }
    }

    /// Its derivative at `z`.
    #[inline(always)]
    pub fn slope(self, z: f32) -> f32 {
        let root = (z * z + 1.0).sqrt();
        match self {
            Activation::None => 1.0,
            Activation::Gated => 0.5 * (1.0 + z / root) + 0.5 * z / (root * root * root),
            Activation::Positive => 0.5 * (1.0 + z / root),
        }
    }
}

/// `act(a + b + ...)` of matrices of one shape.
pub fn sum(tape: &Tape, terms: &[&Matrix], act: Activation) -> Matrix {
    let (rows, cols) = (terms[0].rows, terms[0].cols);
    assert!(terms.iter().all(|t| (t.rows, t.cols) == (rows, cols)), "terms of a sum have one shape");
    let mut z = terms[0].value().to_vec();
    for term in &terms[1..] {
        z.iter_mut().zip(term.value()).for_each(|(z, t)| *z += t);
    }
    let y = if act == Activation::None { z.clone() } else { z.iter().map(|z| act.value(*z)).collect() };
    let kept: Vec<Matrix> = terms.iter().map(|t| (*t).clone()).collect();
    tape.result(terms, (rows, cols), y, move |grads, out| {
        let dz: Vec<f32> = out.iter().zip(&z).map(|(g, z)| g * act.slope(*z)).collect();
        for term in &kept {
            if let Some(d) = grads.of(term) {
                d.iter_mut().zip(&dz).for_each(|(d, g)| *d += g);
            }
        }
    })
}

/// The same numbers as `rows` rows.
pub fn reshape(tape: &Tape, x: &Matrix, rows: usize) -> Matrix {
    let out = x.shaped(rows, x.rows * x.cols / rows, tape.tracks(&[x]));
    let x = x.clone();
    tape.record(&out, move |grads, out| {
        if let Some(d) = grads.of(&x) {
            d.iter_mut().zip(out).for_each(|(d, g)| *d += g);
        }
    });
    out
}

/// `sum_r w_r |x_r - t_r|2` over the rows, 1 x 1; `target` like x, one weight per row.
pub fn squared_error(tape: &Tape, x: &Matrix, target: &[f32], weight: &[f32]) -> Matrix {
    assert!(target.len() == x.value().len() && weight.len() == x.rows, "a target has the shape of what it judges");
    let difference: Vec<f32> = x.value().iter().zip(target).map(|(x, t)| x - t).collect();
    let rows = difference.chunks_exact(x.cols).zip(weight);
    // In f64: a sum of many squares of f32 would lose digits.
    let error: f64 = rows.map(|(d, w)| f64::from(*w) * d.iter().map(|d| f64::from(*d).powi(2)).sum::<f64>()).sum();
    let (x, weight) = (x.clone(), weight.to_vec());
    let input = x.clone();
    tape.result(&[&input], (1, 1), vec![error as f32], move |grads, out| {
        let cols = x.cols;
        if let Some(dx) = grads.of(&x) {
            for (r, w) in weight.iter().enumerate() {
                let scale = 2.0 * out[0] * w;
                let own = r * cols..(r + 1) * cols;
                dx[own.clone()].iter_mut().zip(&difference[own]).for_each(|(g, d)| *g += scale * d);
            }
        }
    })
}
