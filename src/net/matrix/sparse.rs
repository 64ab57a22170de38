//! Constant sparse matrices: gathers, sums over receivers, pools and interpolations.

use super::Number;
use std::sync::{Arc, OnceLock};

/// Constant sparse matrix of `f32` in compressed row storage (CSR), with its transpose.
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
    /// Creates the matrix with `cols` columns from the entries (column, weight) of each row; columns are 0-based and
    /// below `cols`.
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

    /// Creates a gather matrix with `cols` columns: row r of its product with a matrix x is row `index[r]` of x.
    pub fn gather(index: impl IntoIterator<Item = usize>, cols: usize) -> Arc<Self> {
        Self::new(&index.into_iter().map(|i| vec![(i as u32, 1.0)]).collect::<Vec<_>>(), cols)
    }

    /// Returns the transpose as a matrix; the transpose of a gather adds each row to its receiver (scatter-add).
    pub fn transposed(&self) -> Arc<Self> {
        Arc::new(Self { forward: self.transpose().clone(), transpose: self.forward.clone().into() })
    }

    /// Returns all stored entries as ((row, column), weight), row by row.
    pub fn entries(&self) -> impl Iterator<Item = ((u32, u32), f32)> + '_ {
        (0..self.rows()).flat_map(|r| self.row(r).iter().map(move |e| ((r as u32, e.0), e.1)))
    }

    /// Returns the stored entries (column, weight) of row `row`.
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

    /// Computes the product of the matrix and `x`. `x` is row-major with `width` columns; it consists of one or more
    /// blocks of `cols` rows, each of which is multiplied. Returns the products, row-major, as blocks of `rows` rows.
    pub fn times<T: Number>(&self, x: &[T], width: usize) -> Vec<T> {
        let mut y = vec![T::from(0.0); x.len() / (self.cols() * width).max(1) * self.rows() * width];
        self.forward.add(x, &mut y, width);
        y
    }

    /// Adds the product of the transpose and `y` to `x`. Both are row-major with `width` columns, and consist of one or
    /// more blocks: of `rows` rows in `y`, of `cols` rows in `x`.
    pub fn add_transposed<T: Number>(&self, y: &[T], x: &mut [T], width: usize) {
        self.transpose().add(y, x, width);
    }
}
