//! Cost of the solves along a path.

use crate::newton::Converged;

/// Cost of one advance.
#[derive(Debug, Clone, Copy, Default)]
pub struct AdvanceCost {
    /// Newton iterations, failed increments included.
    pub iterations: u32,
    /// Accepted increments.
    pub increments: u32,
    /// Residual of the last one, N.
    pub residual: f64,
}

impl AdvanceCost {
    /// Adds the cost of a subsequent advance.
    pub fn add(&mut self, more: AdvanceCost) {
        self.iterations += more.iterations;
        self.increments += more.increments;
        if more.increments > 0 {
            self.residual = more.residual;
        }
    }

    pub(crate) fn accept(&mut self, converged: Converged) {
        self.iterations += converged.iterations;
        self.increments += 1;
        self.residual = converged.residual;
    }
}
