//! Sparsity of one body's stiffness: elimination order, lower block columns, and storage location of each node pair.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;
use glam::DMat3;

/// Marks a node without unknowns (bonded or prescribed).
pub const FIXED: u32 = u32::MAX;

/// Lower-triangular pattern of a symmetric matrix of 3 x 3 node blocks, in elimination order.
///
/// Nodes, not unknowns, are ordered (approximate minimum degree on the node graph): a third of the vertices and the
/// same fill. Unknown `3 p + c` is component `c` of the free node at elimination position `p`.
#[derive(Debug)]
pub struct Pattern {
    /// Elimination position of each node, or [`FIXED`].
    pub position: Vec<u32>,
    /// Number of free nodes.
    pub free: usize,
    /// Column pointers of the lower triangle, `3 free + 1` entries.
    pub col_ptr: Vec<usize>,
    /// Row indices, sorted in each column.
    pub row_idx: Vec<usize>,
    /// Sub-diagonal block rows of each block column, sorted.
    below: Vec<Vec<u32>>,
}

/// Location of the block of a node pair in the value array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Slot {
    /// Index of the first entry of the first column; [`FIXED`] if a node of the pair is fixed.
    base: u32,
    /// Entries in the first column of the block column; top bit set: store the transpose; next bit: diagonal block.
    stride: u32,
}

const TRANSPOSE: u32 = 1 << 31;
const DIAGONAL: u32 = 1 << 30;

impl Pattern {
    /// Builds the pattern from the nodes of each element (slices of any length) and the flags of fixed nodes.
    pub fn new<'a>(elements: impl Iterator<Item = &'a [u32]>, fixed: &[bool]) -> Self {
        let neighbours = neighbours(elements, fixed);
        let position = order(&neighbours, fixed);
        Self::store(&neighbours, position)
    }

    /// Builds the pattern in a given elimination order: `position` of each node, or [`FIXED`].
    pub fn ordered<'a>(elements: impl Iterator<Item = &'a [u32]>, position: Vec<u32>) -> Self {
        let fixed: Vec<bool> = position.iter().map(|p| *p == FIXED).collect();
        Self::store(&neighbours(elements, &fixed), position)
    }

    /// Returns the positions of this order with the nodes `last` moved to the end, in their order.
    pub fn position_with_last(&self, last: &[u32]) -> Vec<u32> {
        let mut position = self.position.clone();
        last.iter().for_each(|&i| position[i as usize] = FIXED);
        let mut others: Vec<usize> = (0..position.len()).filter(|&i| position[i] != FIXED).collect();
        others.sort_unstable_by_key(|&i| position[i]);
        others.extend(last.iter().map(|&i| i as usize));
        others.iter().enumerate().for_each(|(k, &i)| position[i] = k as u32);
        position
    }

    fn store(neighbours: &[Vec<u32>], position: Vec<u32>) -> Self {
        let n = position.len();
        let free = position.iter().filter(|p| **p != FIXED).count();
        let mut below = vec![Vec::new(); free];
        for a in 0..n {
            for &b in &neighbours[a] {
                let (pa, pb) = (position[a], position[b as usize]);
                if pb > pa {
                    below[pa as usize].push(pb);
                }
            }
        }
        let (mut col_ptr, mut row_idx) = (vec![0], Vec::new());
        for (p, list) in below.iter_mut().enumerate() {
            list.sort_unstable();
            for c in 0..3 {
                row_idx.extend((c..3).map(|r| 3 * p + r));
                row_idx.extend(list.iter().flat_map(|&i| (0..3).map(move |r| 3 * i as usize + r)));
                col_ptr.push(row_idx.len());
            }
        }
        Self { position, free, col_ptr, row_idx, below }
    }

    /// Number of unknowns.
    pub fn unknowns(&self) -> usize {
        3 * self.free
    }

    /// Storage slot of the block (row node a, column node b). The pair must share an element.
    pub fn slot(&self, a: u32, b: u32) -> Slot {
        let (pa, pb) = (self.position[a as usize], self.position[b as usize]);
        if pa == FIXED || pb == FIXED {
            return Slot { base: FIXED, stride: 0 };
        }
        let (row, col, flag) = if pa >= pb { (pa, pb, 0) } else { (pb, pa, TRANSPOSE) };
        let start = self.col_ptr[3 * col as usize];
        let stride = (self.col_ptr[3 * col as usize + 1] - start) as u32;
        if row == col {
            return Slot { base: start as u32, stride: stride | DIAGONAL };
        }
        let below = &self.below[col as usize];
        // If all nodes are coupled, the index is known without a search.
        let full = (row - col - 1) as usize;
        let found = if below.get(full) == Some(&row) { Ok(full) } else { below.binary_search(&row) };
        match found {
            Ok(k) => Slot { base: (start + 3 + 3 * k) as u32, stride: stride | flag },
            // Not coupled by any element: there is nothing to store (callers only pass pairs of one element).
            Err(_) => Slot { base: FIXED, stride: 0 },
        }
    }

    /// Adds a 3 x 3 block (rows: node a, columns: node b of [`Pattern::slot`]) to the values.
    #[inline(always)]
    pub fn add(values: &mut [f64], slot: Slot, block: &DMat3) {
        if slot.base == FIXED {
            return;
        }
        let base = slot.base as usize;
        let stride = (slot.stride & !(TRANSPOSE | DIAGONAL)) as usize;
        if slot.stride & DIAGONAL != 0 {
            values[base] += block.x_axis.x;
            values[base + 1] += block.x_axis.y;
            values[base + 2] += block.x_axis.z;
            values[base + stride] += block.y_axis.y;
            values[base + stride + 1] += block.y_axis.z;
            values[base + 2 * stride - 1] += block.z_axis.z;
            return;
        }
        let b = if slot.stride & TRANSPOSE != 0 { block.transpose() } else { *block };
        for (column, start) in [(b.x_axis, base), (b.y_axis, base + stride - 1), (b.z_axis, base + 2 * stride - 3)] {
            let target = &mut values[start..start + 3];
            target[0] += column.x;
            target[1] += column.y;
            target[2] += column.z;
        }
    }
}

/// Free nodes that share an element with each free node, sorted.
fn neighbours<'a>(elements: impl Iterator<Item = &'a [u32]>, fixed: &[bool]) -> Vec<Vec<u32>> {
    let mut neighbours: Vec<Vec<u32>> = vec![Vec::new(); fixed.len()];
    for nodes in elements {
        for &a in nodes {
            for &b in nodes {
                if a != b && !fixed[a as usize] && !fixed[b as usize] {
                    neighbours[a as usize].push(b);
                }
            }
        }
    }
    for list in &mut neighbours {
        list.sort_unstable();
        list.dedup();
    }
    neighbours
}

/// Approximate minimum degree order (Amestoy, Davis & Duff 1996) of the free nodes.
fn order(neighbours: &[Vec<u32>], fixed: &[bool]) -> Vec<u32> {
    let mut compact = vec![FIXED; fixed.len()];
    let free: Vec<usize> = (0..fixed.len()).filter(|&i| !fixed[i]).collect();
    for (k, &i) in free.iter().enumerate() {
        compact[i] = k as u32;
    }
    let (mut ptr, mut idx) = (vec![0usize], Vec::new());
    for &i in &free {
        // The diagonal belongs to the pattern; entries sorted.
        let mut rows: Vec<usize> = neighbours[i].iter().map(|&j| compact[j as usize] as usize).collect();
        rows.push(compact[i] as usize);
        rows.sort_unstable();
        idx.extend(rows);
        ptr.push(idx.len());
    }
    let n = free.len();
    let (mut forward, mut inverse) = (vec![0usize; n], vec![0usize; n]);
    let graph = SymbolicSparseColMatRef::new_checked(n, n, &ptr, None, &idx);
    let mut memory = MemBuffer::new(amd::order_scratch::<usize>(n, idx.len()));
    let ordered =
        amd::order(&mut forward, &mut inverse, graph, amd::Control::default(), MemStack::new(&mut memory)).is_ok();
    let mut position = vec![FIXED; fixed.len()];
    for (k, &i) in free.iter().enumerate() {
        // If the ordering fails, the natural order is still correct, only slower.
        position[i] = if ordered { inverse[k] as u32 } else { k as u32 };
    }
    position
}
