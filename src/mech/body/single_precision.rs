//! Factor `L D L^T` in single precision, for corrections of a state whose residual the law gives in double precision.
//!
//! A solve for one right-hand side reads every entry of the factor twice with little arithmetic, so that it is bound by
//! memory bandwidth. The relative error of a solution is the rounding of single precision, 6e-8, times the condition
//! number. The diagonal of `L` is one: its entries are ratios of stiffnesses, so that their rounding does not depend on
//! the size of the scene.

use super::cholesky::{Factor, Symbolic};
use faer::sparse::linalg::cholesky::supernodal::{SupernodalLltRef, SupernodeRef};
use pulp::{Arch, Simd, WithSimd};
use std::sync::Arc;

/// Factor `L D L^T` in single precision.
pub struct SinglePrecisionFactor {
    symbolic: Arc<Symbolic>,
    /// Entries of `L`, in the blocks of the symbolic analysis.
    lower: Vec<f32>,
    /// Entries of `D^-1`.
    inverse: Vec<f32>,
}

impl SinglePrecisionFactor {
    /// Divides the columns of `factor` by their diagonal entries and rounds them.
    pub fn new(factor: &Factor) -> Self {
        let symbolic = factor.symbolic.clone();
        let (mut lower, mut inverse) = (vec![0.0; factor.values.len()], Vec::new());
        let unit = factor.unit;
        if let Some(factor) = factor.supernodal() {
            let mut rest = lower.as_mut_slice();
            for k in 0..factor.symbolic().n_supernodes() {
                let block = factor.supernode(k).val();
                let (own, others) = rest.split_at_mut(block.nrows() * block.ncols());
                rest = others;
                for (c, (rounded, exact)) in
                    own.chunks_exact_mut(block.nrows().max(1)).zip(block.col_iter()).enumerate()
                {
                    let diagonal = exact[c];
                    inverse.push((diagonal * diagonal * unit).recip() as f32);
                    rounded.iter_mut().zip(exact.iter()).skip(c + 1).for_each(|(r, v)| *r = (v / diagonal) as f32);
                }
            }
        }
        Self { symbolic, lower, inverse }
    }

    /// Solves in place for the right-hand side `x`.
    pub fn solve(&self, x: &mut [f32]) {
        let Some(factor) = self.supernodal() else { return };
        Arch::new().dispatch(Forward { factor, x: &mut *x });
        x.iter_mut().zip(&self.inverse).for_each(|(x, d)| *x *= d);
        Arch::new().dispatch(Backward { factor, unknowns: x.len(), x });
    }

    /// Computes the unknowns `x` before the last `size`, which are given, without load on the others: the back
    /// substitution of a solve.
    pub fn back_substitute(&self, x: &mut [f32], size: usize) {
        let (Some(factor), unknowns) = (self.supernodal(), x.len() - size) else { return };
        x[..unknowns].fill(0.0);
        Arch::new().dispatch(Backward { factor, unknowns, x });
    }

    /// Returns the dense blocks of the factor; None for a matrix without unknowns.
    fn supernodal(&self) -> Option<SupernodalLltRef<'_, usize, f32>> {
        self.symbolic.supernodal_blocks().map(|symbolic| SupernodalLltRef::new(symbolic, &self.lower))
    }
}

/// Number of columns that are read together: each entry of a vector is then loaded once for all of them.
const COLUMNS_PER_PASS: usize = 4;

/// Forward substitution, `L^-1 x`: a callable struct, compiled for the widest vector registers of the processor.
struct Forward<'a> {
    factor: SupernodalLltRef<'a, usize, f32>,
    x: &'a mut [f32],
}

impl WithSimd for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { factor, x } = self;
        let mut below = Vec::new();
        for k in 0..factor.symbolic().n_supernodes() {
            let node = factor.supernode(k);
            let columns = node.val().ncols();
            let own = &mut x[node.start()..node.start() + columns];
            for c in 0..columns {
                let (solved, rest) = own[c..].split_at_mut(1);
                add_columns(simd, rest, [&column(&node, c)[c + 1..columns]], [-solved[0]]);
            }
            below.clear();
            below.extend(node.pattern().iter().map(|row| x[*row]));
            let own = &x[node.start()..node.start() + columns];
            let outside = |c: usize| &column(&node, c)[columns..];
            let blocks = columns / COLUMNS_PER_PASS * COLUMNS_PER_PASS;
            for c in (0..blocks).step_by(COLUMNS_PER_PASS) {
                let entries: [&[f32]; COLUMNS_PER_PASS] = std::array::from_fn(|k| outside(c + k));
                add_columns(simd, &mut below, entries, std::array::from_fn(|k| -own[c + k]));
            }
            (blocks..columns).for_each(|c| add_columns(simd, &mut below, [outside(c)], [-own[c]]));
            node.pattern().iter().zip(&below).for_each(|(row, value)| x[*row] = *value);
        }
    }
}

/// Back substitution, `L^-T x`, for the first `unknowns`; the others are given.
struct Backward<'a> {
    factor: SupernodalLltRef<'a, usize, f32>,
    unknowns: usize,
    x: &'a mut [f32],
}

impl WithSimd for Backward<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { factor, unknowns, x } = self;
        let mut below = Vec::new();
        for k in (0..factor.symbolic().n_supernodes()).rev() {
            let node = factor.supernode(k);
            let (start, columns) = (node.start(), node.val().ncols());
            let wanted = columns.min(unknowns.saturating_sub(start));
            below.clear();
            below.extend(node.pattern().iter().map(|row| x[*row]));
            let own = &mut x[start..start + columns];
            let outside = |c: usize| &column(&node, c)[columns..];
            let blocks = wanted / COLUMNS_PER_PASS * COLUMNS_PER_PASS;
            for c in (0..blocks).step_by(COLUMNS_PER_PASS) {
                let sums = products(simd, std::array::from_fn::<_, COLUMNS_PER_PASS, _>(|k| outside(c + k)), &below);
                own[c..].iter_mut().zip(sums).for_each(|(x, sum)| *x -= sum);
            }
            (blocks..wanted).for_each(|c| own[c] -= products(simd, [outside(c)], &below)[0]);
            for c in (0..wanted).rev() {
                own[c] -= products(simd, [&column(&node, c)[c + 1..columns]], &own[c + 1..])[0];
            }
        }
    }
}

/// Returns column `c` of the block `node`; columns of a block are contiguous.
#[inline(always)]
fn column<'a>(node: &SupernodeRef<'a, usize, f32>, c: usize) -> &'a [f32] {
    node.val().col(c).try_as_col_major().map_or(&[][..], |c| c.as_slice())
}

/// Adds each of the `columns` times its factor to `sum`.
#[inline(always)]
fn add_columns<S: Simd, const N: usize>(simd: S, sum: &mut [f32], columns: [&[f32]; N], factors: [f32; N]) {
    let columns = columns.map(|column| S::as_simd_f32s(&column[..sum.len()]));
    let (sums, last) = S::as_mut_simd_f32s(sum);
    let vectors = columns.map(|(vectors, _)| &vectors[..sums.len()]);
    let splat = factors.map(|f| simd.splat_f32s(f));
    for (i, sum) in sums.iter_mut().enumerate() {
        *sum = (0..N).fold(*sum, |sum, k| simd.mul_add_f32s(vectors[k][i], splat[k], sum));
    }
    for (i, sum) in last.iter_mut().enumerate() {
        *sum = (0..N).fold(*sum, |sum, k| columns[k].1[i].mul_add(factors[k], sum));
    }
}

/// Computes the scalar products of `columns` with `x`.
#[inline(always)]
fn products<S: Simd, const N: usize>(simd: S, columns: [&[f32]; N], x: &[f32]) -> [f32; N] {
    let columns = columns.map(|column| S::as_simd_f32s(&column[..x.len()]));
    let (x, last) = S::as_simd_f32s(x);
    let vectors = columns.map(|(vectors, _)| &vectors[..x.len()]);
    let mut sums = [simd.splat_f32s(0.0); N];
    for (i, x) in x.iter().enumerate() {
        (0..N).for_each(|k| sums[k] = simd.mul_add_f32s(vectors[k][i], *x, sums[k]));
    }
    std::array::from_fn(|k| {
        columns[k].1.iter().zip(last).fold(simd.reduce_sum_f32s(sums[k]), |sum, (a, b)| a.mul_add(*b, sum))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::pattern::Pattern;

    /// A chain of nodes with springs of 1 to 5 N/m, held at its ends: solutions agree with those in double precision to
    /// 1e-5, also those of the back substitution alone.
    #[test]
    fn solutions_are_those_of_double_precision() {
        let elements: Vec<[u32; 2]> = (0..60).map(|i| [i, i + 1]).collect();
        let pattern = Pattern::new(elements.iter().map(|e| &e[..]), &[false; 61]);
        let mut values = vec![0.0; pattern.row_idx.len()];
        let mut spring = |a: u32, b: u32, k: f64| {
            Pattern::add(&mut values, pattern.slot(a, b), &glam::DMat3::from_diagonal(glam::DVec3::splat(k)))
        };
        for (i, [a, b]) in elements.iter().enumerate() {
            let k = 1.0 + (i % 5) as f64;
            spring(*a, *a, k);
            spring(*b, *b, k);
            spring(*a, *b, -k);
        }
        spring(0, 0, 1.0);
        spring(60, 60, 1.0);
        let mut exact = Factor::new(&Arc::new(Symbolic::new(&pattern).unwrap()), 1);
        assert!(exact.factorize(&pattern, &values));
        let rounded = SinglePrecisionFactor::new(&exact);
        let mut wanted = vec![0.0; pattern.unknowns()];
        let last = wanted.len() - 3;
        wanted[last..].copy_from_slice(&[1.0, -2.0, 0.5]);
        let mut found: Vec<f32> = wanted.iter().map(|v| *v as f32).collect();
        exact.solve(&mut wanted, 1);
        rounded.solve(&mut found);
        let apart =
            |found: &[f32]| found.iter().zip(&wanted).map(|(a, b)| (f64::from(*a) - b).abs()).fold(0.0, f64::max);
        let size = wanted.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        assert!(apart(&found) < 1e-5 * size, "{} of {size} m", apart(&found));
        found[..last].fill(7.0);
        rounded.back_substitute(&mut found, 3);
        assert!(apart(&found) < 1e-5 * size, "{} of {size} m", apart(&found));
    }
}
