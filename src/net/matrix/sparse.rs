//! Constant sparse matrices: gathers, sums over receivers, pools and interpolations.

use super::Number;
use std::sync::{Arc, OnceLock};

/// Sparse matrix in compressed rows, and its transpose.
#[derive(Debug, Clone)]
pub struct Sparse {
    forward: Rows,
    /// Transpose, computed on first use; only gradients need it.
    transpose: OnceLock<Rows>,
}

#[derive(Debug, Clone, PartialEq)]
struct Rows {
    cols: usize,
    /// Index of the first entry of each row, and the number of entries at the end.
    start: Vec<u32>,
    entry: Vec<(u32, f32)>,
}

impl Rows {
    fn new(rows: &[Vec<(u32, f32)>], cols: usize) -> Self {
        let mut start = vec![0];
        start.extend(rows.iter().scan(0, |n, row| {
            *n += row.len() as u32;
            Some(*n)
        }));
        Self { cols, start, entry: rows.concat() }
    }

    fn rows(&self) -> usize {
        self.start.len() - 1
    }

    /// Adds `self * x` to `y` for every block of rows of x.
    fn add<T: Number>(&self, x: &[T], y: &mut [T], width: usize) {
        let blocks = x.chunks_exact((self.cols * width).max(1)).zip(y.chunks_exact_mut((self.rows() * width).max(1)));
        for (x, y) in blocks {
            for (row, y) in y.chunks_exact_mut(width).enumerate() {
                for &(col, weight) in &self.entry[self.start[row] as usize..self.start[row + 1] as usize] {
                    let x = &x[col as usize * width..(col as usize + 1) * width];
                    let weight = T::from(weight);
                    y.iter_mut().zip(x).for_each(|(y, x)| *y += weight * *x);
                }
            }
        }
    }
}

impl Sparse {
    /// Creates the matrix from the entries (column, weight) of every row.
    pub fn new(rows: &[Vec<(u32, f32)>], cols: usize) -> Arc<Self> {
        Arc::new(Self { forward: Rows::new(rows, cols), transpose: OnceLock::new() })
    }

    fn transpose(&self) -> &Rows {
        self.transpose.get_or_init(|| {
            let mut columns = vec![Vec::new(); self.cols()];
            self.entries().for_each(|((r, c), w)| columns[c as usize].push((r, w)));
            Rows::new(&columns, self.rows())
        })
    }

    /// Creates a gather: row r of its product with x is row `index[r]` of x.
    pub fn gather(index: impl IntoIterator<Item = usize>, cols: usize) -> Arc<Self> {
        Self::new(&index.into_iter().map(|i| vec![(i as u32, 1.0)]).collect::<Vec<_>>(), cols)
    }

    /// Returns the transpose: that of a gather is a scatter-add to the receivers.
    pub fn transposed(&self) -> Arc<Self> {
        Arc::new(Self { forward: self.transpose().clone(), transpose: self.forward.clone().into() })
    }

    /// Returns all entries: ((row, column), weight).
    pub fn entries(&self) -> impl Iterator<Item = ((u32, u32), f32)> + '_ {
        (0..self.rows()).flat_map(|r| self.row(r).iter().map(move |e| ((r as u32, e.0), e.1)))
    }

    /// Returns the entries (column, weight) of a row.
    pub fn row(&self, row: usize) -> &[(u32, f32)] {
        let Rows { start, entry, .. } = &self.forward;
        &entry[start[row] as usize..start[row + 1] as usize]
    }

    /// Returns the number of rows.
    pub fn rows(&self) -> usize {
        self.forward.rows()
    }

    /// Returns the number of columns.
    pub fn cols(&self) -> usize {
        self.forward.cols
    }

    /// Computes `self * x` for a row-major x of `width` columns.
    pub fn times<T: Number>(&self, x: &[T], width: usize) -> Vec<T> {
        let mut y = vec![T::from(0.0); x.len() / (self.cols() * width).max(1) * self.rows() * width];
        self.forward.add(x, &mut y, width);
        y
    }

    /// Adds `transpose(self) * y` to `x`; both are row-major with `width` columns.
    pub fn add_transposed<T: Number>(&self, y: &[T], x: &mut [T], width: usize) {
        self.transpose().add(y, x, width);
    }
}
