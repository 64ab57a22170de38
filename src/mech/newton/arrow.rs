//! The Newton system in arrow form: one sparse block per body, one small dense block of rigid unknowns.
//!
//! ```text
//! | K1       B1 | |dx1|     |g1|
//! |     K2   B2 | |dx2| = - |g2|      S = C - sum Bi^T Ki^-1 Bi
//! | B1' B2'  C  | |dy |     |gy|
//! ```

use crate::body::Body;
use crate::body::cholesky::{Factor, dot};
use crate::body::pattern::FIXED;
use crate::potential::block::{BodyBlock, RigidBlock};
use crate::potential::state::{MAX_RIGID, NewtonStep};
use base::error::Result;
use glam::DVec3;
use std::sync::Arc;

/// One body's part of the linear system.
pub struct ArrowBlock {
    /// The body.
    pub body: Arc<Body>,
    /// Its gradient and Hessian.
    pub block: BodyBlock,
    /// Gradients added to those of `block` in a solve.
    pub extra: BodyBlock,
    factor: Factor,
    rhs: Vec<f64>,
    /// `B^T K^-1 B` of the last solve with new columns.
    schur: [[f64; MAX_RIGID]; MAX_RIGID],
}

impl ArrowBlock {
    /// Creates storage for `body` with `columns` rigid columns.
    ///
    /// # Errors
    /// Fails if the factorisation cannot be analysed.
    pub fn new(body: Arc<Body>, columns: usize) -> Result<Self> {
        let block = BodyBlock::new(&body, columns);
        let factor = Factor::new(body.symbolic()?, columns + 1);
        let extra = BodyBlock::gradients(&body);
        Ok(Self { body, block, extra, factor, rhs: Vec::new(), schur: [[0.0; MAX_RIGID]; MAX_RIGID] })
    }

    /// Factorises the block; returns false if it is not positive definite.
    pub fn factorize(&mut self) -> bool {
        self.factor.factorize(self.body.pattern(), &self.block.values)
    }

    /// Solves for the gradient, and for all rigid columns too if `columns` are new.
    pub fn solve(&mut self, columns: bool) {
        let n = self.body.unknowns();
        let coupled = self.block.coupling.len();
        self.rhs.resize(coupled + n, 0.0);
        if columns {
            self.rhs[..coupled].copy_from_slice(&self.block.coupling);
        }
        let gradient = &mut self.rhs[coupled..];
        let nodes = self.block.gradient.iter().zip(&self.extra.gradient);
        for ((g, e), &p) in nodes.zip(&self.body.pattern().position) {
            if p != FIXED {
                gradient[3 * p as usize..3 * p as usize + 3].copy_from_slice(&(*g + *e).to_array());
            }
        }
        let start = if columns { 0 } else { coupled };
        let rhs = &mut self.rhs[start..];
        self.factor.solve(rhs, rhs.len() / n.max(1));
        if columns {
            let coupling = self.block.coupling.chunks_exact(n.max(1));
            for (row, b) in self.schur.iter_mut().zip(coupling) {
                row.iter_mut().zip(self.rhs.chunks_exact(n.max(1))).for_each(|(s, solved)| *s = dot(b, solved));
            }
        }
    }

    /// Computes the motion of the nodes, m, for a motion `rigid` (m) of the rigid unknowns.
    fn motion(&self, rigid: &[f64]) -> Vec<DVec3> {
        let n = self.body.unknowns();
        let entry = |row: usize| {
            let start = self.rhs[rigid.len() * n + row];
            -rigid.iter().enumerate().fold(start, |sum, (c, d)| sum + self.rhs[c * n + row] * d)
        };
        let of = |p: u32| match 3 * p as usize {
            _ if p == FIXED => DVec3::ZERO,
            row => DVec3::new(entry(row), entry(row + 1), entry(row + 2)),
        };
        self.body.pattern().position.iter().map(|p| of(*p)).collect()
    }

    /// Computes `B^T K^-1 g` of this body.
    fn eliminated_gradient(&self) -> impl Iterator<Item = f64> + '_ {
        let solved = &self.rhs[self.block.coupling.len()..];
        self.block.coupling.chunks_exact(self.body.unknowns().max(1)).map(|b| dot(b, solved))
    }
}

/// Smallest stiffness of a rigid unknown over the largest: far below that of any contact, above rounding.
const STIFFNESS_FLOOR: f64 = 1e-10;
/// Number of bisections for the shift, which need not be accurate.
const BISECTIONS: u32 = 30;

/// Schur complement of the rigid unknowns, in its principal axes. Negative or tiny eigenvalues (rigid modes of an
/// object that is not yet held) are replaced by their magnitudes, and all are shifted so that the step under the
/// gradient given at construction is at most `cap` long. The step is then a finite descent direction that does not
/// depend on the basis of modes of equal stiffness. Only the matrix is modified, so that the solution is unchanged.
#[derive(Debug, Clone, Default)]
pub struct RigidSystem {
    /// Principal axes, over the unknowns.
    axes: Vec<[f64; MAX_RIGID]>,
    /// Stiffness along each, N/m.
    stiffness: Vec<f64>,
    /// Number of rigid columns.
    size: usize,
}

impl RigidSystem {
    /// Creates the system from solved blocks and the block of the object alone, under the `gradient` (N) of the rigid
    /// unknowns. The first `unknowns` of the `size` rigid columns may move.
    pub fn new(
        blocks: &[ArrowBlock],
        object: &RigidBlock,
        gradient: &[f64; MAX_RIGID],
        [unknowns, size]: [usize; 2],
        cap: f64,
    ) -> Self {
        let mut s = [[0.0; MAX_RIGID]; MAX_RIGID];
        for i in 0..size {
            for j in 0..size {
                let bodies = blocks.iter().map(|b| b.block.rigid.hessian[i][j] - b.schur[i][j]).sum::<f64>();
                s[i][j] = bodies + object.hessian[i][j];
            }
        }
        let mut system = Self { axes: Vec::new(), stiffness: Vec::new(), size };
        let matrix = faer::Mat::<f64>::from_fn(unknowns, unknowns, |i, j| 0.5 * (s[i][j] + s[j][i]));
        // Fails only for non-finite input; the resulting zero step makes the caller stop with a failure.
        let Ok(eigen) = matrix.self_adjoint_eigen(faer::Side::Lower) else { return system };
        let (u, values) = (eigen.U(), eigen.S());
        let largest = (0..unknowns).map(|k| values[k].abs()).fold(0.0, f64::max);
        let floor = (STIFFNESS_FLOOR * largest).max(f64::MIN_POSITIVE);
        for k in 0..unknowns {
            let mut axis = [0.0; MAX_RIGID];
            (0..unknowns).for_each(|i| axis[i] = u[(i, k)]);
            system.axes.push(axis);
            system.stiffness.push(values[k].abs().max(floor));
        }
        system.limit_step(&system.axis_gradient(blocks, gradient), cap);
        system
    }

    /// Gradient along each axis after elimination of the nodes, N, for the `gradient` of the rigid unknowns.
    fn axis_gradient(&self, blocks: &[ArrowBlock], gradient: &[f64; MAX_RIGID]) -> Vec<f64> {
        let mut g = *gradient;
        for b in blocks {
            g.iter_mut().zip(b.eliminated_gradient()).for_each(|(g, reduced)| *g -= reduced);
        }
        self.axes.iter().map(|axis| axis.iter().zip(&g).map(|(u, g)| u * g).sum()).collect()
    }

    /// Adds to the stiffness the smallest shift for which the step under the gradient `along` the axes (N) is at most
    /// `cap` (m) long.
    fn limit_step(&mut self, along: &[f64], cap: f64) {
        let length = |shift: f64| {
            let parts = along.iter().zip(&self.stiffness).map(|(p, k)| p / (k + shift));
            parts.map(|p| p * p).sum::<f64>().sqrt()
        };
        if length(0.0) > cap {
            // A shift of the force over the cap makes every step short enough.
            let (mut low, mut shift) = (0.0, along.iter().map(|p| p * p).sum::<f64>().sqrt() / cap);
            for _ in 0..BISECTIONS {
                let middle = 0.5 * (low + shift);
                if length(middle) > cap { low = middle } else { shift = middle }
            }
            self.stiffness.iter_mut().for_each(|k| *k += shift);
        }
    }

    /// Full Newton step of solved blocks for the `gradient` (N) of the rigid unknowns.
    pub fn step(&self, blocks: &[ArrowBlock], gradient: &[f64; MAX_RIGID]) -> NewtonStep {
        let mut rigid = [0.0; MAX_RIGID];
        for ((g, axis), stiffness) in self.axis_gradient(blocks, gradient).iter().zip(&self.axes).zip(&self.stiffness) {
            rigid.iter_mut().zip(axis).for_each(|(d, u)| *d -= u * g / stiffness);
        }
        NewtonStep { x: blocks.iter().map(|b| b.motion(&rigid[..self.size])).collect(), rigid }
    }
}
