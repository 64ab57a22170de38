//! The Newton system in arrow form: one sparse block per body, one small dense block of rigid unknowns.
//!
//! ```text
//! | K1       B1 | |dx1|     |g1|
//! |     K2   B2 | |dx2| = - |g2|      S = C - sum Bi^T Ki^-1 Bi
//! | B1' B2'  C  | |dy |     |gy|
//! ```

use crate::error::Result;
use crate::mech::body::Body;
use crate::mech::body::cholesky::{Factor, dot};
use crate::mech::body::pattern::FIXED;
use crate::mech::potential::block::{BodyBlock, RigidBlock};
use crate::mech::potential::state::{MAX_RIGID, NewtonStep};
use glam::DVec3;
use std::sync::Arc;

/// One body's part of the linear system.
pub struct ArrowBlock {
    /// The body.
    pub body: Arc<Body>,
    /// Its gradient and Hessian.
    pub block: BodyBlock,
    /// Gradients to be solved for beside those of `block`.
    pub extra: BodyBlock,
    factor: Factor,
    rhs: Vec<f64>,
    /// `B^T K^-1 B` of the last columns that were solved for.
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

    /// Factorises the block; false if it is not positive definite.
    pub fn factorize(&mut self) -> bool {
        self.factor.factorize(self.body.pattern(), &self.block.values)
    }

    /// Solves for the gradient; for all rigid columns at once if `columns` are new.
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

    /// Computes `B^T K^-1 g` of this body.
    fn reduced(&self) -> impl Iterator<Item = f64> + '_ {
        let solved = &self.rhs[self.block.coupling.len()..];
        self.block.coupling.chunks_exact(self.body.unknowns().max(1)).map(|b| dot(b, solved))
    }
}

/// Combines solved blocks, and the block of the object alone, into the full Newton step. Negative or
/// tiny curvature of the rigid unknowns (rigid modes of an object that nothing holds yet) is replaced by its magnitude and
/// shifted so that the rigid unknowns move by at most `cap` (m). The step descends and stays finite, and does not depend on the
/// basis of modes of equal stiffness. The solution is not changed, because only the matrix is. The first `unknowns` of the
/// `size` rigid columns move.
pub fn step(
    blocks: &[ArrowBlock],
    object: &RigidBlock,
    rigid_gradient: &[f64; MAX_RIGID],
    [unknowns, size]: [usize; 2],
    cap: f64,
) -> NewtonStep {
    let (mut s, mut g) = ([[0.0; MAX_RIGID]; MAX_RIGID], *rigid_gradient);
    for b in blocks {
        for i in 0..size {
            for j in 0..size {
                s[i][j] += b.block.rigid.hessian[i][j] - b.schur[i][j];
            }
        }
        g.iter_mut().zip(b.reduced()).for_each(|(g, reduced)| *g -= reduced);
    }
    (0..size).for_each(|i| (0..size).for_each(|j| s[i][j] += object.hessian[i][j]));
    let dy = solve_rigid(&s, &g, unknowns, cap);
    let x = blocks
        .iter()
        .map(|b| {
            let n = b.body.unknowns();
            let solution = &b.rhs;
            let entry = |row: usize| {
                let mut v = solution[size * n + row];
                for c in 0..size {
                    v += solution[c * n + row] * dy[c];
                }
                -v
            };
            let position = &b.body.pattern().position;
            position
                .iter()
                .map(|&p| {
                    if p == FIXED {
                        return DVec3::ZERO;
                    }
                    let row = 3 * p as usize;
                    DVec3::new(entry(row), entry(row + 1), entry(row + 2))
                })
                .collect()
        })
        .collect();
    NewtonStep { x, rigid: dy }
}

/// Smallest stiffness of a rigid unknown that is divided by, over the largest: far below any contact, above rounding.
const STIFFNESS_FLOOR: f64 = 1e-10;
/// Number of bisections for the shift, which need not be sharp.
const BISECTIONS: u32 = 30;

/// Solves `|S| dy = -g` through the eigenvalues of the rigid unknowns' Schur complement.
fn solve_rigid(s: &[[f64; MAX_RIGID]; MAX_RIGID], g: &[f64; MAX_RIGID], size: usize, cap: f64) -> [f64; MAX_RIGID] {
    let mut dy = [0.0; MAX_RIGID];
    if size == 0 {
        return dy;
    }
    let matrix = faer::Mat::<f64>::from_fn(size, size, |i, j| 0.5 * (s[i][j] + s[j][i]));
    // Fails only for non-finite input; a zero step then makes the caller stop with a fault.
    let Ok(eigen) = matrix.self_adjoint_eigen(faer::Side::Lower) else { return dy };
    let (u, values) = (eigen.U(), eigen.S());
    let projected: Vec<f64> = (0..size).map(|k| (0..size).map(|i| u[(i, k)] * g[i]).sum()).collect();
    let largest = (0..size).map(|k| values[k].abs()).fold(0.0, f64::max);
    let floor = (STIFFNESS_FLOOR * largest).max(f64::MIN_POSITIVE);
    let stiffness: Vec<f64> = (0..size).map(|k| values[k].abs().max(floor)).collect();
    let length = |shift: f64| {
        let parts = projected.iter().zip(&stiffness).map(|(p, k)| p / (k + shift));
        parts.map(|p| p * p).sum::<f64>().sqrt()
    };
    let mut shift = 0.0;
    if length(shift) > cap {
        // With the force over the cap every step is short enough; the smallest shift that does is bisected for.
        let mut low = shift;
        shift = projected.iter().map(|p| p * p).sum::<f64>().sqrt() / cap;
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + shift);
            if length(middle) > cap { low = middle } else { shift = middle }
        }
    }
    for k in 0..size {
        let along = -projected[k] / (stiffness[k] + shift);
        for i in 0..size {
            dy[i] += u[(i, k)] * along;
        }
    }
    dy
}
