//! Best times, and the rate of arithmetic that they are compared with.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use std::hint::black_box;
use std::time::Instant;

/// Wall time of `work`, the best of at least five turns and half a second, s.
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

/// Products of large matrices by `faer`, which uses the widest registers that there are, floating-point operations a second of one thread.
pub fn sgemm() -> f64 {
    let (m, n) = (1536, 384);
    let matrix = |rows: usize, cols: usize| Mat::from_fn(rows, cols, |i, j| ((i * cols + j) as f32 * 0.37).sin());
    let (a, b, mut out) = (matrix(m, n), matrix(n, n), Mat::<f32>::zeros(m, n));
    let time = best(|| matmul(black_box(&mut out), Accum::Replace, &a, &b, 1.0, Par::Seq));
    2.0 * (m * n * n) as f64 / time
}
