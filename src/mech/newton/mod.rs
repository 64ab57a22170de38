//! The system that Newton's method solves: bodies with their terms, and the rigid unknowns that couple them.

pub mod arrow;
mod direction;
pub mod effort;
mod failure;
mod lagging;
pub mod object;
pub mod proximal;
mod solve;
mod terms;

use self::arrow::{ArrowBlock, RigidSystem};
use self::effort::Effort;
pub use self::failure::Failure;
use self::object::ObjectTerms;
use self::proximal::ProximalSprings;
pub use self::terms::SavedTerms;
use super::body::Body;
use super::potential::block::RigidBlock;
use super::potential::state::{MAX_RIGID, NewtonStep, RigidUnknowns, State};
use super::potential::term::{Assembly, BodyTerm};
use super::potential::time_step::TimeStep;
use base::error::Result;
use base::scales::{DISPLACEMENT_TOLERANCE, LARGEST_MOTION};
use rayon::prelude::*;
use std::sync::Arc;
use std::time::Instant;

/// Limits of Newton's method: convergence criteria, and largest motion in one iteration.
#[derive(Debug, Clone, Copy)]
pub struct NewtonTolerance {
    /// Largest norm of the out-of-balance forces relative to the contact forces.
    pub relative: f64,
    /// Absolute part of that bound, which remains without contact, N.
    pub force: f64,
    /// Largest motion of any unknown in the last iteration, m.
    pub length: f64,
    /// Maximum number of iterations of an increment.
    pub iterations: u32,
    /// Largest motion of any point in one iteration, m: keeps closest points on the correct side of thin objects.
    pub max_motion: f64,
    /// Flag: the solution is intermediate, not a result; friction may stay lagged where it oscillates.
    pub intermediate: bool,
    /// Contact offset, m: the reference of all lengths of the method.
    pub offset: f64,
}

impl NewtonTolerance {
    /// Creates the usual tolerance for contact with this `offset` (m).
    pub fn new(offset: f64) -> Self {
        let [length, max_motion] = [DISPLACEMENT_TOLERANCE, LARGEST_MOTION].map(|offsets| offsets * offset);
        Self { relative: 2e-4, force: 1e-7, length, iterations: 40, max_motion, intermediate: false, offset }
    }
}

/// Cost and result of a converged solve.
#[derive(Debug, Clone, Copy, Default)]
pub struct Converged {
    /// Newton iterations (linear solves).
    pub iterations: u32,
    /// Norm of the out-of-balance forces, N.
    pub residual: f64,
}

/// Wall time by stage, s.
#[derive(Debug, Clone, Copy, Default)]
pub struct SolverProfile {
    /// Element and contact gradients and Hessians.
    pub assembly: f64,
    /// Numeric Cholesky factorisation.
    pub factorization: f64,
    /// Triangular solves and Schur complement.
    pub solve: f64,
    /// Energies of the line search.
    pub line_search: f64,
    /// Newton iterations.
    pub iterations: u64,
    /// Factorisations that needed a projected Hessian.
    pub projections: u64,
    /// Solves in which friction was lagged.
    pub frozen: u64,
}

/// Bodies with their terms, and the rigid unknowns that couple them.
pub struct Newton {
    /// Terms that represent the gel of each body: its elastic energy, or a substitute.
    pub gel: Vec<Vec<Box<dyn BodyTerm>>>,
    /// Other terms of each body: contact, inertia, drive.
    pub terms: Vec<Vec<Box<dyn BodyTerm>>>,
    /// Terms of the object.
    pub object: ObjectTerms,
    /// Layout of the rigid unknowns.
    pub rigid: RigidUnknowns,
    /// Force along each driven travel, N.
    pub force: Vec<f64>,
    /// Timings.
    pub profile: SolverProfile,
    /// Current time step; None on a quasi-static path.
    pub step: Option<TimeStep>,
    /// Proximal springs of a pseudo-time step; None without pseudo-time.
    pub proximal: Option<ProximalSprings>,
    /// Flag: the object is held fixed, and its pose is not an unknown.
    pub object_fixed: bool,
    /// Limit on the work of the solver.
    pub effort: Effort,
    pub(crate) blocks: Vec<ArrowBlock>,
    /// System of the rigid unknowns of the last direction.
    rigid_system: RigidSystem,
    /// Gradient and Hessian of terms on the rigid unknowns alone, and gradients added to them in a solve.
    pub(crate) object_block: RigidBlock,
    pub(crate) object_extra: RigidBlock,
}

impl Newton {
    /// Creates a solver for `bodies` with `terms` per body, without terms of gel or object.
    ///
    /// # Errors
    /// Fails if the factorisation of a body cannot be analysed.
    pub fn new(bodies: Vec<Arc<Body>>, terms: Vec<Vec<Box<dyn BodyTerm>>>, rigid: RigidUnknowns) -> Result<Self> {
        // The first analysis of each body takes long.
        let blocks: Vec<_> = bodies.into_par_iter().map(|b| ArrowBlock::new(b, rigid.size)).collect::<Result<_>>()?;
        let force = vec![0.0; blocks.len()];
        let gel = blocks.iter().map(|_| Vec::new()).collect();
        Ok(Self {
            gel,
            terms,
            object: ObjectTerms::default(),
            rigid,
            force,
            profile: SolverProfile::default(),
            step: None,
            proximal: None,
            object_fixed: false,
            effort: Effort::default(),
            blocks,
            rigid_system: RigidSystem::default(),
            object_block: RigidBlock::default(),
            object_extra: RigidBlock::default(),
        })
    }

    /// The body with this index.
    pub fn body(&self, index: usize) -> &Arc<Body> {
        &self.blocks[index].body
    }

    /// Replaces body `index` by `body`, which has the same number of nodes; the terms stay.
    ///
    /// # Errors
    /// Fails if its factorisation cannot be analysed.
    pub fn replace_body(&mut self, index: usize, body: Arc<Body>) -> Result<()> {
        self.blocks[index] = ArrowBlock::new(body, self.rigid.size)?;
        Ok(())
    }

    /// Number of bodies.
    pub fn bodies(&self) -> usize {
        self.blocks.len()
    }

    /// Total potential, J.
    pub fn energy(&self, state: &State) -> f64 {
        let bodies: Vec<f64> = (0..self.blocks.len())
            .into_par_iter()
            .map(|i| {
                let view = state.view(i, &self.rigid);
                self.body_terms(i).map(|t| t.energy(&self.blocks[i].body, &view)).sum()
            })
            .collect();
        let object = self.object.energy(state, &self.rigid);
        // Summed in body order: bitwise the same result on any number of threads.
        bodies.iter().sum::<f64>() + object - self.work(state)
            + self.proximal.as_ref().map_or(0.0, |p| p.energy(&self.rigid, &self.blocks, state))
    }

    /// Distance by which every point may move from `state` before anything touches, m.
    pub fn clearance(&self, state: &State) -> f64 {
        let of = |i: usize| {
            let view = state.view(i, &self.rigid);
            self.body_terms(i).map(|t| t.clearance(&self.blocks[i].body, &view)).fold(f64::INFINITY, f64::min)
        };
        (0..self.blocks.len()).map(of).fold(self.object.clearance(state, &self.rigid), f64::min)
    }

    /// Work of the finger forces, J.
    fn work(&self, state: &State) -> f64 {
        let driven = self.rigid.travel.iter().enumerate().filter(|(_, c)| c.is_some());
        driven.map(|(i, _)| self.force[i] * state.travel[i]).sum()
    }

    /// Assembles every block at `state`.
    pub fn assemble(&mut self, state: &State, how: Assembly) {
        self.assemble_some(state, how, true);
    }

    /// Assembles gradients at `state`, and Hessians if wanted.
    pub(crate) fn assemble_some(&mut self, state: &State, how: Assembly, hessian: bool) {
        let (rigid, proximal) = (&self.rigid, &self.proximal);
        let terms = self.gel.par_iter_mut().zip(&mut self.terms);
        self.blocks.par_iter_mut().zip(terms).enumerate().for_each(|(i, (b, (gel, terms)))| {
            b.block.clear(hessian);
            let view = state.view(i, rigid);
            for t in gel.iter_mut().chain(terms) {
                t.assemble(&b.body, &view, how, &mut b.block);
            }
            if let Some(springs) = proximal {
                springs.assemble(i, &b.body, view.x, &mut b.block);
            }
        });
        self.object_block.clear(hessian);
        self.object.assemble(state, rigid, how, &mut self.object_block);
        if let Some(springs) = proximal {
            springs.assemble_rigid(rigid, state, &mut self.object_block);
        }
    }

    /// Gradient of body `i` after [`Newton::assemble`], N per node (reactions at fixed nodes).
    pub fn gradient(&self, i: usize) -> &[glam::DVec3] {
        &self.blocks[i].block.gradient
    }

    /// Gradient of the rigid unknowns after [`Newton::assemble`], N.
    pub fn rigid_gradient(&self) -> [f64; MAX_RIGID] {
        let mut g = [0.0; MAX_RIGID];
        for b in &self.blocks {
            for (g, v) in g.iter_mut().zip(b.block.rigid.gradient) {
                *g += v;
            }
        }
        for (i, column) in self.rigid.travel.iter().enumerate() {
            if let Some(c) = column {
                g[*c] -= self.force[i];
            }
        }
        g.iter_mut().zip(self.object_block.gradient).for_each(|(g, v)| *g += v);
        // The support of a fixed object balances every force on it.
        g[self.unknowns()..].fill(0.0);
        g
    }

    /// Number of rigid columns that are unknowns; those of the pose come last.
    pub(crate) fn unknowns(&self) -> usize {
        self.rigid.pose.filter(|_| self.object_fixed).unwrap_or(self.rigid.size)
    }

    /// Norms of all out-of-balance forces and of the lag of lagged forces, N.
    pub(crate) fn residual(&self) -> (f64, f64) {
        let rigid: f64 = self.rigid_gradient()[..self.rigid.size].iter().map(|v| v * v).sum();
        let nodes: f64 = self
            .blocks
            .iter()
            .map(|b| {
                let free = b.block.gradient.iter().zip(&b.body.fixed).filter(|(_, fixed)| !**fixed);
                free.map(|(g, _)| g.length_squared()).sum::<f64>()
            })
            .sum();
        let lag = self.blocks.iter().map(|b| b.block.rigid.lag).sum::<f64>() + self.object_block.lag;
        ((rigid + nodes).sqrt(), lag.sqrt())
    }

    /// Largest sum of contact force magnitudes on a body, plus that of the forces on the object alone, N.
    pub fn force_scale(&self) -> f64 {
        self.blocks.iter().map(|b| b.block.rigid.force_scale).fold(0.0, f64::max) + self.object_block.force_scale
    }

    /// Returns true if some driven finger carries no contact force.
    pub(crate) fn lacks_contact(&self) -> bool {
        let driven = self.blocks.iter().zip(&self.rigid.travel);
        driven.into_iter().any(|(b, column)| column.is_some() && b.block.rigid.force_scale == 0.0)
    }

    /// Factorises all blocks; assembles again with projected Hessians if one is not positive definite. Returns false if
    /// that fails too.
    pub fn factorize(&mut self, state: &State, how: Assembly) -> bool {
        let clock = Instant::now();
        let good = factorize_all(&mut self.blocks);
        self.profile.factorization += clock.elapsed().as_secs_f64();
        if good {
            return true;
        }
        self.profile.projections += 1;
        self.assemble(state, Assembly { project: true, ..how });
        factorize_all(&mut self.blocks)
    }

    /// Upper bound of the motion of any node relative to the object in a step, m.
    pub(crate) fn step_motion_bound(&self, step: &NewtonStep) -> f64 {
        let nodes = step.x.iter().flatten().map(|d| d.length_squared()).fold(0.0, f64::max).sqrt();
        nodes + step.rigid[..self.rigid.size].iter().map(|d| d.abs()).fold(0.0, f64::max)
    }

    /// Directional derivative of the energy along the step, J.
    pub(crate) fn slope(&self, step: &NewtonStep, rigid: &[f64; MAX_RIGID]) -> f64 {
        let nodes: f64 = self
            .blocks
            .iter()
            .zip(&step.x)
            .map(|(b, d)| b.block.gradient.iter().zip(d).map(|(g, d)| g.dot(*d)).sum::<f64>())
            .sum();
        nodes + rigid.iter().zip(&step.rigid).map(|(g, d)| g * d).sum::<f64>()
    }
}

fn factorize_all(blocks: &mut [ArrowBlock]) -> bool {
    // All blocks are factorised even if one fails, so that the work does not depend on timing.
    blocks.par_iter_mut().map(ArrowBlock::factorize).collect::<Vec<_>>().into_iter().all(|ok| ok)
}
