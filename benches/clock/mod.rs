//! Best-of-several times and the arithmetic rate with which they are compared.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use std::hint::black_box;
use std::time::Instant;

/// Measures the wall time of `work`, s: the minimum over at least five repetitions and half a second.
pub fn best(mut work: impl FnMut()) -> f64 {
    let (start, mut best, mut turns) = (Instant::now(), f64::INFINITY, 0);
    while turns < 5 || start.elapsed().as_secs_f64() < 0.5 {
        let clock = Instant::now();
        work();
        best = best.min(clock.elapsed().as_secs_f64());
        turns += 1;
    }
    best
}

/// Measures the rate of products of large matrices by `faer` (with the widest available registers), one thread, FLOP/s.
pub fn sgemm() -> f64 {
    let (m, n) = (1536, 384);
    let matrix = |rows: usize, cols: usize| Mat::from_fn(rows, cols, |i, j| ((i * cols + j) as f32 * 0.37).sin());
    let (a, b, mut out) = (matrix(m, n), matrix(n, n), Mat::<f32>::zeros(m, n));
    let time = best(|| matmul(black_box(&mut out), Accum::Replace, &a, &b, 1.0, Par::Seq));
    2.0 * (m * n * n) as f64 / time
}
