//! Energy of a condensed pad, as a term of the potential.

use faer::Mat;
use glam::DVec3;
use mech::body::Body;
use mech::body::pattern::FIXED;
use mech::potential::block::BodyBlock;
use mech::potential::state::BodyView;
use mech::potential::term::{Assembly, BodyTerm};
use pulp::{Arch, NullaryFnOnce};
use std::sync::Arc;

/// Elastic energy of a statically condensed pad (Guyan 1965), J: `1/2 (x - c)' S (x - c)` for the positions `x` of the
/// nodes of a patch, which are the free nodes of the body, in the same order. `S` is [`CondensedEnergy::stiffness`],
/// `c` is [`CondensedEnergy::center`].
#[derive(Debug, Clone)]
pub struct CondensedEnergy {
    /// Equilibrium position of each patch node without contact, m, relative to the finger.
    pub center: Vec<DVec3>,
    /// Indices of the pad nodes that form the patch, 0-based.
    pub patch: Arc<[u32]>,
    /// Condensed stiffness `S`, N/m: a symmetric matrix with three rows and columns per patch node (x, y, z), the Schur
    /// complement of the pad's stiffness.
    pub stiffness: Arc<Mat<f64>>,
}

impl CondensedEnergy {
    /// Returns the displacement `x - c`, m, and the gradient of the energy, `S (x - c)`, N, each with three entries per
    /// patch node. `x` are the positions of all nodes of the pad relative to the finger, m.
    pub fn force(&self, x: &[DVec3]) -> (Vec<f64>, Vec<f64>) {
        let moved = self.patch.iter().zip(&self.center).flat_map(|(&n, c)| (x[n as usize] - *c).to_array());
        let moved: Vec<f64> = moved.collect();
        let mut force = vec![0.0; moved.len()];
        Arch::new().dispatch(Force { stiffness: &self.stiffness, moved: &moved, force: &mut force });
        (moved, force)
    }
}

impl BodyTerm for CondensedEnergy {
    fn energy(&self, _: &Body, view: &BodyView) -> f64 {
        let (moved, force) = self.force(view.x);
        0.5 * moved.iter().zip(&force).map(|(d, f)| d * f).sum::<f64>()
    }

    fn assemble(&mut self, body: &Body, view: &BodyView, _: Assembly, block: &mut BodyBlock) {
        let (_, force) = self.force(view.x);
        for (&n, f) in self.patch.iter().zip(force.chunks_exact(3)) {
            block.gradient[n as usize] += DVec3::from_slice(f);
        }
        if block.wants_hessian() {
            debug_assert!(self.patch.iter().all(|&n| body.pattern().position[n as usize] != FIXED));
            let columns = &body.pattern().col_ptr;
            for (j, column) in self.stiffness.col_iter().enumerate() {
                let values = &mut block.values[columns[j]..columns[j + 1]];
                values.iter_mut().zip(column.iter().skip(j)).for_each(|(v, s)| *v += s);
            }
        }
    }
}

/// Product of the stiffness with a displacement, as a struct that is compiled for the vector instructions of the
/// processor.
struct Force<'a> {
    stiffness: &'a Mat<f64>,
    moved: &'a [f64],
    force: &'a mut [f64],
}

impl NullaryFnOnce for Force<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        for (column, d) in self.stiffness.col_iter().zip(self.moved) {
            // Columns of a matrix are contiguous.
            let column = column.try_as_col_major().map_or(&[][..], |c| c.as_slice());
            self.force.iter_mut().zip(column).for_each(|(f, s)| *f += s * d);
        }
    }
}
