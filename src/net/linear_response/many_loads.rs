//! Products of the compliance of a pad with many loads at once, and their transposes.
//!
//! The compliance matrix is far larger than the caches, so each reading of it serves [`LANES`] loads at once. Stress is
//! local: it depends on the displacement of the neighbours of a node.

use super::compliance::Compliance;
use super::deviator::PARTS;
use crate::matrix::Number;
use pulp::{Arch, Simd, WithSimd};

/// Number of loads per reading of the matrix.
const LANES: usize = 8;
/// Number of rows of the matrix per reading of the gradient of the forces.
const ROWS: usize = 12;
/// One number for each of these loads.
type Lanes<T> = [T; LANES];

impl Compliance {
    /// Computes the displacements of the movable nodes (n, moving) under forces (n, forces).
    pub fn displacements<T: Number>(&self, force: &[T]) -> Vec<T> {
        by_lanes(force, self.forces, self.displacement_count(), |x, y| Arch::new().dispatch(Times { pad: self, x, y }))
    }

    /// Applies the transpose of [`Self::displacements`]: (n, moving) to (n, forces).
    pub fn displacements_transposed<T: Number>(&self, moved: &[T]) -> Vec<T> {
        let (k, m) = (self.forces, self.displacement_count());
        by_lanes(moved, m, k, |y, x| Arch::new().dispatch(TimesTransposed { pad: self, y, x }))
    }

    /// Computes the deviatoric stress of all nodes (n, nodes * 5) from displacements of the movable nodes (n, moving).
    pub fn stresses<T: Number>(&self, moved: &[T]) -> Vec<T> {
        let (m, n) = (self.displacement_count(), 5 * self.nodes);
        by_lanes(moved, m, n, |u, s| Arch::new().dispatch(Deviate { pad: self, u, s }))
    }

    /// Applies the transpose of [`Self::stresses`]: (n, nodes * 5) to (n, moving).
    pub fn stresses_transposed<T: Number>(&self, stress: &[T]) -> Vec<T> {
        let (m, n) = (self.displacement_count(), 5 * self.nodes);
        by_lanes(stress, n, m, |s, u| Arch::new().dispatch(DeviateTransposed { pad: self, s, u }))
    }
}

/// Applies `kernel` to the rows of `x` (n, from), [`LANES`] at once: (n, to). The kernel adds to zeros.
fn by_lanes<T: Number>(x: &[T], from: usize, to: usize, kernel: impl FnOnce(&[Lanes<T>], &mut [Lanes<T>])) -> Vec<T> {
    let n = x.len() / from.max(1);
    let mut y = zeros(n, to);
    kernel(&interleaved(x, from), &mut y);
    deinterleaved(&y, to, n)
}

/// Kernel from forces `x` to displacement `y`.
struct Times<'a, T> {
    pad: &'a Compliance,
    x: &'a [Lanes<T>],
    y: &'a mut [Lanes<T>],
}

impl<T: Number> WithSimd for Times<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { pad, x, y } = self;
        let (k, m) = (pad.forces, pad.displacement_count());
        // Three rows per node.
        for (node, rows) in pad.response.chunks_exact(3 * k).enumerate() {
            let (a, rest) = rows.split_at(k);
            let (b, c) = rest.split_at(k);
            let rows = a.as_chunks::<3>().0.iter().zip(b.as_chunks::<3>().0).zip(c.as_chunks::<3>().0);
            for (x, y) in x.chunks_exact(k).zip(y.chunks_exact_mut(m)) {
                // Nine independent sums hide the latency of the addition.
                let mut sum = [[[T::from(0.0); LANES]; 3]; 3];
                for (((a, b), c), x) in rows.clone().zip(x.as_chunks::<3>().0) {
                    for k in 0..3 {
                        add(&mut sum[0][k], a[k], &x[k]);
                        add(&mut sum[1][k], b[k], &x[k]);
                        add(&mut sum[2][k], c[k], &x[k]);
                    }
                }
                for (y, [p, q, r]) in y[3 * node..3 * node + 3].iter_mut().zip(&sum) {
                    *y = *p;
                    for l in 0..LANES {
                        y[l] += q[l];
                        y[l] += r[l];
                    }
                }
            }
        }
    }
}

/// Kernel from the gradient of the displacement to that of the forces.
struct TimesTransposed<'a, T> {
    pad: &'a Compliance,
    y: &'a [Lanes<T>],
    x: &'a mut [Lanes<T>],
}

impl<T: Number> WithSimd for TimesTransposed<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { pad, y, x } = self;
        let (k, m) = (pad.forces, pad.displacement_count());
        for (block, rows) in pad.response.chunks(ROWS * k).enumerate() {
            for (x, y) in x.chunks_exact_mut(k).zip(y.chunks_exact(m)) {
                let y = &y[ROWS * block..m.min(ROWS * (block + 1))];
                match y.as_array::<ROWS>() {
                    Some(y) => {
                        let rows: [&[f32]; ROWS] = std::array::from_fn(|i| &rows[i * k..(i + 1) * k]);
                        // Each gradient stays in a register for all of these rows.
                        for (j, x) in x.iter_mut().enumerate() {
                            rows.iter().zip(y).for_each(|(row, y)| add(x, row[j], y));
                        }
                    }
                    None => {
                        for (row, y) in rows.chunks_exact(k).zip(y) {
                            row.iter().zip(&mut *x).for_each(|(a, x)| add(x, *a, y));
                        }
                    }
                }
            }
        }
    }
}

/// Component of the stress and of the displacement that each coefficient of a neighbour connects ([`PARTS`]).
const ENTRIES: [(usize, usize); PARTS] =
    [(0, 0), (0, 1), (0, 2), (1, 0), (1, 1), (1, 2), (2, 0), (2, 1), (3, 1), (3, 2), (4, 2), (4, 0)];

/// Kernel from displacement to stress.
struct Deviate<'a, T> {
    pad: &'a Compliance,
    u: &'a [Lanes<T>],
    s: &'a mut [Lanes<T>],
}

impl<T: Number> WithSimd for Deviate<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { pad, u, s } = self;
        for (u, s) in u.chunks_exact(pad.displacement_count()).zip(s.chunks_exact_mut(5 * pad.nodes)) {
            for (node, s) in s.as_chunks_mut::<5>().0.iter_mut().enumerate() {
                let (slots, parts) = pad.deviator.of(node);
                for (slot, part) in slots.iter().zip(parts) {
                    let u = &u.as_chunks::<3>().0[*slot as usize];
                    ENTRIES.iter().zip(part).for_each(|((row, column), part)| add(&mut s[*row], *part, &u[*column]));
                }
            }
        }
    }
}

/// Kernel from the gradient of the stress to that of the displacement.
struct DeviateTransposed<'a, T> {
    pad: &'a Compliance,
    s: &'a [Lanes<T>],
    u: &'a mut [Lanes<T>],
}

impl<T: Number> WithSimd for DeviateTransposed<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { pad, s, u } = self;
        for (s, u) in s.chunks_exact(5 * pad.nodes).zip(u.chunks_exact_mut(pad.displacement_count())) {
            let u = u.as_chunks_mut::<3>().0;
            for (node, s) in s.as_chunks::<5>().0.iter().enumerate() {
                let (slots, parts) = pad.deviator.of(node);
                for (slot, part) in slots.iter().zip(parts) {
                    let u = &mut u[*slot as usize];
                    ENTRIES.iter().zip(part).for_each(|((row, column), part)| add(&mut u[*column], *part, &s[*row]));
                }
            }
        }
    }
}

#[inline(always)]
fn add<T: Number>(sum: &mut Lanes<T>, factor: f32, x: &Lanes<T>) {
    let factor = T::from(factor);
    for l in 0..LANES {
        sum[l] += factor * x[l];
    }
}

fn zeros<T: Number>(rows: usize, cols: usize) -> Vec<Lanes<T>> {
    vec![[T::from(0.0); LANES]; rows.div_ceil(LANES) * cols]
}

/// Interleaves rows of `cols` numbers in blocks of [`LANES`] rows; the last block is padded with zeros.
fn interleaved<T: Number>(x: &[T], cols: usize) -> Vec<Lanes<T>> {
    let mut out = zeros(x.len() / cols.max(1), cols);
    for (r, row) in x.chunks_exact(cols.max(1)).enumerate() {
        let own = &mut out[r / LANES * cols..][..cols];
        own.iter_mut().zip(row).for_each(|(lanes, v)| lanes[r % LANES] = *v);
    }
    out
}

/// Inverts [`interleaved`] for `rows` rows.
fn deinterleaved<T: Number>(lanes: &[Lanes<T>], cols: usize, rows: usize) -> Vec<T> {
    let mut out = vec![T::from(0.0); rows * cols];
    for (r, row) in out.chunks_exact_mut(cols).enumerate() {
        row.iter_mut().zip(&lanes[r / LANES * cols..]).for_each(|(v, lanes)| *v = lanes[r % LANES]);
    }
    out
}
