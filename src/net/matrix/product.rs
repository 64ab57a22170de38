//! Matrix products with packed weights; bias and activation are applied in the same pass over the result.
//!
//! The weights are stored in panels of up to 48 columns, row by row, in the order in which the innermost loop reads
//! them; that loop keeps a tile of the result in registers. Every entry of a result is one chain of fused multiply-adds
//! in the order of the rows of the weights, so tiles, threads and register width do not change a single bit (except on
//! processors without such an instruction, which round twice). The instruction set (AVX-512, AVX2 or neither) is
//! detected at run time.
#![allow(
    unsafe_code,
    reason = "the compiler cannot infer that all rows of a tile have the same length; bounds checks would occupy its \
        registers"
)]

use super::activation::{Act, activate};
use pulp::{Arch, Simd, WithSimd};

/// Number that all column counts are multiples of: the width of an AVX-512 register in f32.
pub const LANES: usize = 16;

/// Returns `n` rounded up to a multiple of [`LANES`].
pub fn padded(n: usize) -> usize {
    n.next_multiple_of(LANES)
}

/// Matrix of weights (rows, cols), stored in panels.
#[derive(Debug, Clone, Default)]
pub struct PackedMatrix {
    /// Number of rows: the inner dimension of a product.
    pub rows: usize,
    /// Number of columns, [`padded`] with zeros.
    pub cols: usize,
    data: Vec<f32>,
}

impl PackedMatrix {
    /// Packs a row-major matrix with `cols` columns.
    pub fn new(weights: &[f32], cols: usize) -> Self {
        let mut packed = Self::default();
        packed.fill(weights.len() / cols.max(1), cols, |r, c| weights[r * cols + c]);
        packed
    }

    /// Fills the matrix in place: entry (r, c) is `entry(r, c)`.
    pub fn fill(&mut self, rows: usize, cols: usize, entry: impl Fn(usize, usize) -> f32) {
        (self.rows, self.cols) = (rows, padded(cols));
        self.data.clear();
        self.data.reserve(rows * self.cols);
        for (start, width) in panels(self.cols) {
            for r in 0..rows {
                self.data.extend((start..start + width).map(|c| if c < cols { entry(r, c) } else { 0.0 }));
            }
        }
    }
}

/// Returns first column and width of each panel: 48 where possible, but 32 + 32 instead of 48 + 16.
fn panels(cols: usize) -> impl Iterator<Item = (usize, usize)> {
    let mut start = 0;
    std::iter::from_fn(move || {
        let width = match (cols - start) / LANES {
            0 => return None,
            1 => 1,
            2 | 4 => 2,
            _ => 3,
        };
        start += width * LANES;
        Some((start - width * LANES, width * LANES))
    })
}

/// View of the rows of a row-major matrix.
#[derive(Debug, Clone, Copy)]
pub struct RowsView<'a> {
    /// Numbers; row i starts at `i * stride`.
    pub data: &'a [f32],
    /// Distance between the starts of consecutive rows, in numbers.
    pub stride: usize,
    /// Number of rows.
    pub count: usize,
}

/// Arguments of the product `out = act(keep * out + bias + a w)`.
#[derive(Debug)]
pub struct Product<'a> {
    /// Left factor; its rows have at least as many entries as `w` has rows.
    pub a: RowsView<'a>,
    /// Right factor: the weights.
    pub w: &'a PackedMatrix,
    /// Flag: the previous content of `out` is added.
    pub keep: bool,
    /// Row added to every row of the result, with at least as many entries as `w` has columns.
    pub bias: Option<&'a [f32]>,
    /// Activation applied to the result.
    pub act: Act,
    /// Result: row i starts at `i * stride`.
    pub out: &'a mut [f32],
    /// Distance between the starts of consecutive rows of the result, in numbers.
    pub stride: usize,
}

impl WithSimd for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        product(simd, self);
    }
}

/// Computes a [`Product`] with the instruction set of `simd`.
#[inline(always)]
pub fn product<S: Simd>(simd: S, p: Product) {
    let Product { a, w, keep, bias, act, out, stride } = p;
    let mut at = 0;
    for (col, width) in panels(w.cols) {
        let panel = &w.data[at..at + width * w.rows];
        at += width * w.rows;
        let bias = bias.map(|b| &b[col..col + width]);
        let mut part = Panel { a, k: w.rows, panel, keep, bias, act, out: &mut *out, stride, col };
        // Register tiles (registers per panel row, registers per tile row, rows): the accumulators occupy all registers
        // except a few.
        match (S::F32_LANES, width / LANES) {
            (16, 3) => part.run::<S, 3, 3, 8>(simd),
            (16, 2) => part.run::<S, 2, 2, 12>(simd),
            (16, _) => part.run::<S, 1, 1, 16>(simd),
            (8, 3) => part.run::<S, 6, 2, 6>(simd),
            (8, 2) => part.run::<S, 4, 2, 6>(simd),
            (8, _) => part.run::<S, 2, 2, 6>(simd),
            (4, 3) => part.run::<S, 12, 4, 4>(simd),
            (4, 2) => part.run::<S, 8, 4, 4>(simd),
            (4, _) => part.run::<S, 4, 4, 4>(simd),
            (_, 3) => part.run::<S, 48, 16, 1>(simd),
            (_, 2) => part.run::<S, 32, 16, 1>(simd),
            _ => part.run::<S, 16, 16, 1>(simd),
        }
    }
}

/// One panel of a product.
struct Panel<'a, 'b> {
    a: RowsView<'a>,
    k: usize,
    panel: &'a [f32],
    keep: bool,
    bias: Option<&'a [f32]>,
    act: Act,
    out: &'b mut [f32],
    stride: usize,
    col: usize,
}

impl Panel<'_, '_> {
    #[inline(always)]
    fn run<S: Simd, const P: usize, const N: usize, const M: usize>(&mut self, simd: S) {
        for first in (0..P).step_by(N) {
            let mut row = 0;
            while row + M <= self.a.count {
                self.tile::<S, P, N, M>(simd, row, first);
                row += M;
            }
            while row < self.a.count {
                self.tile::<S, P, N, 1>(simd, row, first);
                row += 1;
            }
        }
    }

    #[inline(always)]
    fn tile<S: Simd, const P: usize, const N: usize, const M: usize>(&mut self, simd: S, row: usize, first: usize) {
        let k = self.k;
        let a: [&[f32]; M] = std::array::from_fn(|i| &self.a.data[(row + i) * self.a.stride..][..k]);
        let b = &S::as_simd_f32s(self.panel).0.as_chunks::<P>().0[..k];
        let mut sum = [[simd.splat_f32s(0.0); N]; M];
        for (p, b) in b.iter().enumerate() {
            let b = &b[first..first + N];
            for i in 0..M {
                // SAFETY: every row has been sliced to k numbers, and b has k rows.
                let x = simd.splat_f32s(unsafe { *a[i].get_unchecked(p) });
                for j in 0..N {
                    sum[i][j] = simd.mul_add_e_f32s(x, b[j], sum[i][j]);
                }
            }
        }
        let width = N * S::F32_LANES;
        for (i, sum) in sum.iter().enumerate() {
            let out = &mut self.out[(row + i) * self.stride + self.col + first * S::F32_LANES..][..width];
            let out = S::as_mut_simd_f32s(out).0;
            for j in 0..N {
                let mut z = sum[j];
                if self.keep {
                    z = simd.add_f32s(z, out[j]);
                }
                if let Some(bias) = self.bias {
                    z = simd.add_f32s(z, S::as_simd_f32s(bias).0[first + j]);
                }
                out[j] = activate(simd, self.act, z);
            }
        }
    }
}

/// Computes `out = a w` for `w` of [`LANES`] columns of which only the first `used` are needed.
pub fn multiply_lanes(a: RowsView, w: &PackedMatrix, used: usize, out: &mut [f32]) {
    if used <= MAX_DOT_COLUMNS {
        return Arch::new().dispatch(Dots { a, w, used, out });
    }
    let stride = w.cols;
    Arch::new().dispatch(Product { a, w, keep: false, bias: None, act: Act::None, out, stride });
}

/// Number of columns up to which dot products along the rows are faster than a register of columns.
const MAX_DOT_COLUMNS: usize = 4;

/// Product with few columns, computed along the rows.
struct Dots<'a> {
    a: RowsView<'a>,
    w: &'a PackedMatrix,
    used: usize,
    out: &'a mut [f32],
}

impl WithSimd for Dots<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { a, w, used, out } = self;
        for column in 0..used {
            let x: Vec<f32> = w.data.iter().skip(column).step_by(w.cols).copied().collect();
            let (x, end) = S::as_simd_f32s(&x);
            for (row, out) in out.chunks_exact_mut(w.cols).enumerate().take(a.count) {
                let (row, rest) = S::as_simd_f32s(&a.data[row * a.stride..][..w.rows]);
                // Four independent sums: a single one would be bound by the latency of the addition.
                let mut sum = [simd.splat_f32s(0.0); 4];
                let (x4, x1) = x.as_chunks::<4>();
                let (row4, row1) = row.as_chunks::<4>();
                for (x, row) in x4.iter().zip(row4) {
                    for k in 0..4 {
                        sum[k] = simd.mul_add_e_f32s(x[k], row[k], sum[k]);
                    }
                }
                for (x, row) in x1.iter().zip(row1) {
                    sum[0] = simd.mul_add_e_f32s(*x, *row, sum[0]);
                }
                let sum = simd.add_f32s(simd.add_f32s(sum[0], sum[1]), simd.add_f32s(sum[2], sum[3]));
                let rest: f32 = end.iter().zip(rest).map(|(x, r)| x * r).sum();
                out[column] = simd.reduce_sum_f32s(sum) + rest;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_match_sums_at_every_size() {
        for (m, k, n) in [(1, 1, 1), (3, 5, 16), (17, 48, 48), (29, 12, 64), (40, 7, 33), (9, 20, 112)] {
            let a: Vec<f32> = (0..m * k).map(|i| (i as f32 * 0.7).sin()).collect();
            let w: Vec<f32> = (0..k * n).map(|i| (i as f32 * 0.3).cos()).collect();
            let packed = PackedMatrix::new(&w, n);
            let mut out = vec![1.0; m * packed.cols];
            let stride = packed.cols;
            let rows = RowsView { data: &a, stride: k, count: m };
            Arch::new().dispatch(Product {
                a: rows,
                w: &packed,
                keep: true,
                bias: None,
                act: Act::None,
                out: &mut out,
                stride,
            });
            for i in 0..m {
                for j in 0..n {
                    let exact: f32 = 1.0 + (0..k).map(|p| a[i * k + p] * w[p * n + j]).sum::<f32>();
                    assert!((out[i * stride + j] - exact).abs() < 1e-4, "entry ({i}, {j}) of {m} x {k} x {n}");
                }
            }
        }
    }
}
