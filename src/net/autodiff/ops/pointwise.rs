//! Elementwise operations: sums with an activation, products, reshaping, the training loss.

use crate::autodiff::real::Real;
use crate::autodiff::tape::{Matrix, Tape};
use pulp::{Arch, Simd, WithSimd};
use serde::{Deserialize, Serialize};

/// Scalar activation function and its derivative. None needs exp, which does not vectorise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Activation {
    /// Identity.
    None,
    /// Gated linear unit with an algebraic sigmoid: `z (1 + z / sqrt(1 + z2)) / 2`.
    Gated,
    /// Positive function (squareplus, Barron 2021): `(z + sqrt(z2 + 1)) / 2`.
    Positive,
    /// Rectifier `max(z, 0)`.
    Relu,
}

impl Activation {
    /// Returns the value at `z`.
    #[inline(always)]
    pub fn value<T: Real>(self, z: T) -> T {
        let (zero, half, one) = (T::of(0.0), T::of(0.5), T::of(1.0));
        match self {
            Activation::None => z,
            Activation::Gated => half * z * (one + z / (one + z * z).sqrt()),
            // The other form avoids cancellation for z << 0.
            Activation::Positive => {
                let root = (z * z + one).sqrt();
                if z < zero { half / (root - z) } else { half * (z + root) }
            }
            Activation::Relu => {
                if z > zero {
                    z
                } else {
                    zero
                }
            }
        }
    }

    /// Returns the derivative at `z`.
    #[inline(always)]
    pub fn slope<T: Real>(self, z: T) -> T {
        let (half, one) = (T::of(0.5), T::of(1.0));
        let root = (z * z + one).sqrt();
        match self {
            Activation::None => one,
            Activation::Gated => half * (one + z / root) + half * z / (root * root * root),
            Activation::Positive => half * (one + z / root),
            Activation::Relu => T::of(if z > T::of(0.0) { 1.0 } else { 0.0 }),
        }
    }

    /// Returns the values at `z`, and what [`Self::sloped`] needs of `z`.
    pub fn applied<T: Real>(self, z: Vec<T>) -> (Vec<T>, Vec<T>) {
        match self {
            Activation::None => (z, Vec::new()),
            _ => (Arch::new().dispatch(Values { act: self, z: &z }), z),
        }
    }

    /// Converts the gradient with respect to the values into that with respect to `z`.
    pub fn sloped<T: Real>(self, mut out: Vec<T>, z: &[T]) -> Vec<T> {
        if self != Activation::None {
            Arch::new().dispatch(Slopes { act: self, z, dz: &mut out });
        }
        out
    }
}

/// Kernel of `act(z)`.
struct Values<'a, T> {
    act: Activation,
    z: &'a [T],
}

impl<T: Real> WithSimd for Values<'_, T> {
    type Output = Vec<T>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Vec<T> {
        self.z.iter().map(|z| self.act.value(*z)).collect()
    }
}

/// Kernel of `dz *= act'(z)`.
struct Slopes<'a, T> {
    act: Activation,
    z: &'a [T],
    dz: &'a mut [T],
}

impl<T: Real> WithSimd for Slopes<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { act, z, dz } = self;
        dz.iter_mut().zip(z).for_each(|(dz, z)| *dz *= act.slope(*z));
    }
}

/// Computes `act(a + b + ...)` of matrices of the same shape.
pub fn sum<T: Real>(tape: &Tape<T>, terms: &[&Matrix<T>], act: Activation) -> Matrix<T> {
    let (rows, cols) = (terms[0].rows, terms[0].cols);
    assert!(terms.iter().all(|t| (t.rows, t.cols) == (rows, cols)), "terms of a sum have one shape");
    let mut z = terms[0].value().to_vec();
    for term in &terms[1..] {
        z.iter_mut().zip(term.value()).for_each(|(z, t)| *z += *t);
    }
    let (y, z) = act.applied(z);
    let kept: Vec<Matrix<T>> = terms.iter().map(|t| (*t).clone()).collect();
    tape.result(terms, (rows, cols), y, move |grads, out| {
        let dz = act.sloped(out, &z);
        let Some((last, others)) = kept.split_last() else { return };
        others.iter().filter(|term| term.tracked()).for_each(|term| grads.add(term, dz.clone()));
        grads.add(last, dz);
    })
}

/// Computes the elementwise product of `a` and `b`.
pub fn product<T: Real>(tape: &Tape<T>, a: &Matrix<T>, b: &Matrix<T>) -> Matrix<T> {
    assert_eq!((a.rows, a.cols), (b.rows, b.cols), "factors have one shape");
    let y = a.value().iter().zip(b.value()).map(|(a, b)| *a * *b).collect();
    let (a, b) = (a.clone(), b.clone());
    let inputs = [a.clone(), b.clone()];
    tape.result(&inputs.each_ref(), (a.rows, a.cols), y, move |grads, out| {
        for (own, other) in [(&a, &b), (&b, &a)] {
            if let Some(d) = grads.of(own) {
                d.iter_mut().zip(out.iter().zip(other.value())).for_each(|(d, (g, v))| *d += *g * *v);
            }
        }
    })
}

/// Returns the entries of `x`, in row-major order, in `rows` rows.
pub fn reshape<T: Real>(tape: &Tape<T>, x: &Matrix<T>, rows: usize) -> Matrix<T> {
    let out = x.shaped(rows, x.rows * x.cols / rows, tape.tracks(&[x]));
    let x = x.clone();
    tape.record(&out, move |grads, out| grads.add(&x, out));
    out
}

/// Computes the loss of `x` against `target`, 1 x 1. For each of `groups` equal groups of rows, r is the root of
/// sum(weight * squared difference); the result is the mean of r / (1 + r). This bounded function limits the influence
/// of a few hard groups: the gradient almost vanishes where the error is several times the size of the target.
pub fn root_error<T: Real>(tape: &Tape<T>, x: &Matrix<T>, target: &[f32], weight: &[f32], groups: usize) -> Matrix<T> {
    assert!(target.len() == x.value().len() && weight.len() == x.rows, "a target has the shape of what it judges");
    assert!(x.rows.is_multiple_of(groups), "groups are alike");
    let (cols, each) = (x.cols, x.rows / groups);
    let difference: Vec<T> = x.value().iter().zip(target).map(|(x, t)| *x - T::of(*t)).collect();
    let rows: Vec<(&[T], &f32)> = difference.chunks_exact(cols).zip(weight).collect();
    // In f64, since a sum of many squares would lose digits in f32.
    let square = |(d, w): &(&[T], &f32)| f64::from(**w) * d.iter().map(|d| d.f64().powi(2)).sum::<f64>();
    let roots: Vec<f64> =
        rows.chunks_exact(each).map(|g| (g.iter().map(square).sum::<f64>() + SMOOTH * SMOOTH).sqrt()).collect();
    let mean = roots.iter().map(|r| r / (1.0 + r)).sum::<f64>() / groups as f64;
    let (x, weight) = (x.clone(), weight.to_vec());
    let input = x.clone();
    tape.result(&[&input], (1, 1), vec![T::nearest(mean)], move |grads, out| {
        if let Some(dx) = grads.of(&x) {
            for (r, w) in weight.iter().enumerate() {
                let root = roots[r / each];
                let scale = T::nearest(f64::from(*w) / (root * (1.0 + root).powi(2) * groups as f64)) * out[0];
                let own = r * cols..(r + 1) * cols;
                dx[own.clone()].iter_mut().zip(&difference[own]).for_each(|(g, d)| *g += scale * *d);
            }
        }
    })
}

/// Error below which the root is smoothed to a quadratic.
const SMOOTH: f64 = 1e-3;
