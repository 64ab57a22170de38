//! Single-threaded products of row-major matrices.
#![allow(unsafe_code, reason = "the `gemm` crate takes pointers and strides; every one is checked here")]

use super::real::Real;
use gemm::{Parallelism, gemm};

/// Computes `out (m x n) = keep * out + a (m x k) * b (k x n)`; `transposed` flags whether `a` and `b` are stored
/// transposed.
pub fn product<T: Real>(
    (m, k, n): (usize, usize, usize),
    keep: bool,
    out: &mut [T],
    a: &[T],
    b: &[T],
    transposed: (bool, bool),
) {
    assert!(out.len() == m * n && a.len() == m * k && b.len() == k * n, "matrix sizes must fit");
    let strides = |rows: usize, cols: usize, t: bool| if t { (rows as isize, 1) } else { (1, cols as isize) };
    let ((a_cs, a_rs), (b_cs, b_rs)) = (strides(m, k, transposed.0), strides(k, n, transposed.1));
    // SAFETY: the lengths are checked above, and the strides address only entries within them.
    unsafe {
        let (a, b) = (a.as_ptr(), b.as_ptr());
        let alpha = T::of(if keep { 1.0 } else { 0.0 });
        gemm(
            m,
            n,
            k,
            out.as_mut_ptr(),
            1,
            n as isize,
            keep,
            a,
            a_cs,
            a_rs,
            b,
            b_cs,
            b_rs,
            alpha,
            T::of(1.0),
            false,
            false,
            false,
            Parallelism::None,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_match_sums_in_every_layout() {
        let (m, k, n) = (3, 4, 2);
        let a: Vec<f32> = (0..m * k).map(|i| i as f32 * 0.3 - 1.0).collect();
        let b: Vec<f32> = (0..k * n).map(|i| 2.0 - i as f32 * 0.7).collect();
        let flip = |x: &[f32], r: usize, c: usize| {
            (0..c).flat_map(|j| (0..r).map(move |i| (i, j))).map(|(i, j)| x[i * c + j]).collect::<Vec<f32>>()
        };
        for (ta, tb) in [(false, false), (true, false), (false, true), (true, true)] {
            let a = if ta { flip(&a, m, k) } else { a.clone() };
            let b = if tb { flip(&b, k, n) } else { b.clone() };
            let mut out = vec![1.0; m * n];
            product((m, k, n), true, &mut out, &a, &b, (ta, tb));
            for i in 0..m {
                for j in 0..n {
                    let at = |i: usize, l: usize| if ta { a[l * m + i] } else { a[i * k + l] };
                    let bt = |l: usize, j: usize| if tb { b[j * k + l] } else { b[l * n + j] };
                    let exact: f32 = 1.0 + (0..k).map(|l| at(i, l) * bt(l, j)).sum::<f32>();
                    assert!((out[i * n + j] - exact).abs() < 1e-5, "entry ({i}, {j}), transposed {ta} {tb}");
                }
            }
        }
    }
}
