//! Search for the tetrahedron of a deformed pad that contains a point.

use super::inversion::{jacobian, position};
use glam::DVec3;
use record::{ElementNodes, PadTopology};

/// Tetrahedra of a deformed pad, in a uniform grid to find the one that contains a point.
pub struct Tetrahedra<'a> {
    /// Elements of the pad.
    pub elements: &'a ElementNodes,
    /// Positions of the nodes, m.
    pub x: &'a [DVec3],
    low: DVec3,
    cell: DVec3,
    /// Start of each cell in `cells`; one more entry at the end.
    start: Vec<u32>,
    cells: Vec<u32>,
    boxes: Vec<[DVec3; 2]>,
}

/// Number of cells of the grid along each axis.
const CELLS: usize = 16;
/// Barycentric coordinate below which a point counts as outside, so that rounding does not classify touching points as
/// inside.
const INSIDE: f64 = 1e-9;

impl<'a> Tetrahedra<'a> {
    /// Creates the tetrahedra of a pad with its nodes at `x`, m.
    pub fn new(topology: &'a PadTopology, x: &'a [DVec3]) -> Self {
        let elements = &topology.elements;
        let around = |points: &mut dyn Iterator<Item = DVec3>| {
            points.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)])
        };
        let boxes = elements.nodes().chunks_exact(elements.width()).map(|n| {
            let [low, high] = around(&mut n.iter().map(|&i| x[i as usize]));
            // The edges of a curved element exceed the bounding box of its nodes by at most an eighth of its size.
            let bulge = if elements.width() == 10 { (high - low) / 8.0 } else { DVec3::ZERO };
            [low - bulge, high + bulge]
        });
        let boxes: Vec<[DVec3; 2]> = boxes.collect();
        let [low, high] = around(&mut boxes.iter().flatten().copied());
        let cell = (high - low) / CELLS as f64;
        let (start, cells) = (vec![0; CELLS.pow(3) + 1], Vec::new());
        let mut tetrahedra = Self { elements, x, low, cell, start, cells, boxes };
        // Counting sort: every cell has its own range of one list.
        let mut next = vec![0; CELLS.pow(3) + 1];
        tetrahedra.each_cell(|cell, _| next[cell + 1] += 1);
        (0..CELLS.pow(3)).for_each(|cell| next[cell + 1] += next[cell]);
        let mut cells = vec![0; next[CELLS.pow(3)] as usize];
        tetrahedra.start.clone_from(&next);
        tetrahedra.each_cell(|cell, t| {
            cells[next[cell] as usize] = t;
            next[cell] += 1;
        });
        tetrahedra.cells = cells;
        tetrahedra
    }

    /// Calls `visit` with every cell that the bounding box of a tetrahedron overlaps, and the number of the
    /// tetrahedron.
    fn each_cell(&self, mut visit: impl FnMut(usize, u32)) {
        for (t, ends) in self.boxes.iter().enumerate() {
            let [from, to] = ends.map(|p| self.cell_of(p));
            for i in from[0]..=to[0] {
                for j in from[1]..=to[1] {
                    (from[2]..=to[2]).for_each(|k| visit((i * CELLS + j) * CELLS + k, t as u32));
                }
            }
        }
    }

    /// Returns the cell nearest to `p`.
    fn cell_of(&self, p: DVec3) -> [usize; 3] {
        ((p - self.low) / self.cell).to_array().map(|v| (v.max(0.0) as usize).min(CELLS - 1))
    }

    /// Returns true if one of the tetrahedra contains `p`.
    pub fn contains(&self, p: DVec3) -> bool {
        let within = |low: DVec3, high: DVec3| p.cmpge(low).all() && p.cmple(high).all();
        if !within(self.low, self.low + self.cell * CELLS as f64) {
            return false;
        }
        let [i, j, k] = self.cell_of(p);
        let cell = (i * CELLS + j) * CELLS + k;
        let own = self.start[cell] as usize..self.start[cell + 1] as usize;
        let mut near = self.cells[own].iter().map(|&t| t as usize);
        near.any(|t| within(self.boxes[t][0], self.boxes[t][1]) && self.element_contains(t, p))
    }

    fn element_contains(&self, t: usize, p: DVec3) -> bool {
        let node = |i: u32| self.x[i as usize];
        let l = match self.elements {
            ElementNodes::Linear(tets) => {
                let [a, b, c, d] = tets[t].map(node);
                glam::DMat3::from_cols(b - a, c - a, d - a).inverse() * (p - a)
            }
            ElementNodes::Quadratic(tets) => {
                let x = tets[t].map(node);
                let mut l = DVec3::splat(0.25);
                let full = |l: DVec3| [1.0 - l.element_sum(), l.x, l.y, l.z];
                let off = |l: DVec3| p - position(&x, &full(l));
                // Newton's method on the isoparametric map; if it diverges or fails, the point is not in the element.
                for _ in 0..8 {
                    let step = jacobian(&x, &full(l)).inverse() * off(l);
                    l += step;
                    if step.length() < 1e-12 || l.abs().max_element() > 2.0 {
                        break;
                    }
                }
                if off(l).length() > 1e-9 * x[0].distance(x[1]) || !l.is_finite() {
                    return false;
                }
                l
            }
        };
        l.min_element() > INSIDE && l.element_sum() < 1.0 - INSIDE
    }
}
