//! The incremental potential: bodies with their terms, the rigid unknowns that join them, and the system Newton's method solves.

pub mod arrow;
mod direction;
pub mod effort;
mod lagging;
pub mod proximal;
mod solve;

use self::arrow::ArrowBlock;
use self::effort::Effort;
use self::proximal::Proximal;
use super::body::Body;
use super::potential::state::{Departure, MAX_RIGID, NewtonStep, RigidUnknowns, State};
use super::potential::term::BodyTerm;
use crate::error::Result;
use crate::scales::{DISPLACEMENT_TOLERANCE, LARGEST_MOTION};
use rayon::prelude::*;
use std::sync::Arc;
use std::time::Instant;

/// Limits of Newton's method: when to stop, and how far one iteration may go.
#[derive(Debug, Clone, Copy)]
pub struct NewtonTolerance {
    /// Largest norm of the out-of-balance forces relative to the contact forces.
    pub relative: f64,
    /// Absolute part of that bound, which remains where there is no contact, N.
    pub force: f64,
    /// Largest motion of any unknown in the last iteration, m.
    pub length: f64,
    /// Iterations before an increment is given up.
    pub iterations: u32,
    /// Largest motion of any point in one iteration, m: keeps the closest point on the right side of thin objects.
    pub motion: f64,
    /// Flag: the solve is only on the way to a result; friction may lag where it swings.
    pub passing: bool,
    /// Contact offset, m: the reference of all lengths of the method.
    pub offset: f64,
}

impl NewtonTolerance {
    /// Creates the usual tolerance for contact with this `offset` (m).
    pub fn new(offset: f64) -> Self {
        let [length, motion] = [DISPLACEMENT_TOLERANCE, LARGEST_MOTION].map(|offsets| offsets * offset);
        Self { relative: 2e-4, force: 1e-7, length, iterations: 40, motion, passing: false, offset }
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

/// Reason why a solve stopped without converging.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Failure {
    /// The iteration limit was reached with this residual, N.
    Iterations(f64),
    /// No step along the Newton direction lowers the energy; residual, N.
    LineSearch(f64),
    /// The stiffness is not positive definite even after projection, or not finite.
    Singular,
    /// The corrections of condensed pads do not settle; size of the last one over the displacement.
    Corrections(f64),
    /// The path bends so far that the error of the increment is this many times the error allowed.
    Bent(f64),
    /// Contact has reached nodes that a condensed pad has eliminated.
    Outside,
    /// The object kept rolling or sliding and did not come to rest.
    Unsettled,
    /// A finger closes on nothing: the object left the grasp.
    Lost,
    /// The object moved farther at one load level than counts as held.
    Astray,
    /// The number of Newton iterations reached this limit of a grasp.
    Effort(u64),
    /// The wall time that a grasp may take is over, s.
    Time(f64),
    /// The object is still moving: nothing failed, but its way is followed in stages.
    Underway,
    /// The user asked to stop.
    Interrupted,
}

impl Failure {
    /// Returns true if the object leaves the grasp, as a real one would.
    pub fn leaves_the_grasp(&self) -> bool {
        matches!(self, Failure::Lost | Failure::Astray | Failure::Unsettled)
    }

    /// Returns true if nothing more is to be tried.
    pub fn is_out_of_effort(&self) -> bool {
        matches!(self, Failure::Effort(_) | Failure::Time(_) | Failure::Interrupted)
    }
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Failure::Iterations(r) => write!(f, "no equilibrium within the iteration limit (residual {r:.1e} N)"),
            Failure::LineSearch(r) => write!(f, "line search: no step lowers the energy (residual {r:.1e} N)"),
            Failure::Corrections(e) => write!(f, "the corrections of the condensed pads do not settle (error {e:.1e})"),
            Failure::Bent(error) => write!(f, "the path bends {error:.1} times as far as one increment may"),
            Failure::Outside => f.write_str("contact outgrows what the pads are condensed onto"),
            Failure::Lost => f.write_str("a finger closes on nothing: the object was squeezed out"),
            Failure::Astray => f.write_str("the object moves too far to count as held"),
            Failure::Effort(most) => write!(
                f,
                "no equilibrium within {most} Newton iterations, the most that a grasp of so many steps may take"
            ),
            Failure::Time(seconds) => {
                write!(f, "no equilibrium within the {seconds} s of wall time that a grasp may take")
            }
            Failure::Underway => f.write_str("the object is still moving"),
            Failure::Interrupted => f.write_str("interrupted"),
            Failure::Unsettled => f.write_str("the object keeps rolling or sliding and does not come to rest"),
            Failure::Singular => f.write_str("the stiffness is not positive definite or not finite"),
        }
    }
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
    /// Solutions in which friction was frozen.
    pub frozen: u64,
}

/// Bodies with their terms, and the rigid unknowns that join them.
pub struct Newton {
    /// Terms of each body.
    pub terms: Vec<Vec<Box<dyn BodyTerm>>>,
    /// Layout of the rigid unknowns.
    pub rigid: RigidUnknowns,
    /// Force along each driven travel, N.
    pub force: Vec<f64>,
    /// Timings.
    pub profile: SolverProfile,
    /// The springs of a pseudo-time step, on paths without stable equilibria.
    pub proximal: Option<Proximal>,
    /// Flag: the object is held where it is, and its pose is no unknown.
    pub object_fixed: bool,
    /// Limit on the work of the solver.
    pub effort: Effort,
    pub(crate) blocks: Vec<ArrowBlock>,
}

impl Newton {
    /// Creates a solver for `bodies` with `terms` per body.
    ///
    /// # Errors
    /// Fails if the factorisation of a body cannot be analysed.
    pub fn new(bodies: Vec<Arc<Body>>, terms: Vec<Vec<Box<dyn BodyTerm>>>, rigid: RigidUnknowns) -> Result<Self> {
        // Analyses take long the first time.
        let blocks: Vec<_> = bodies.into_par_iter().map(|b| ArrowBlock::new(b, rigid.size)).collect::<Result<_>>()?;
        let force = vec![0.0; blocks.len()];
        Ok(Self {
            terms,
            rigid,
            force,
            profile: SolverProfile::default(),
            proximal: None,
            object_fixed: false,
            effort: Effort::default(),
            blocks,
        })
    }

    /// The body with this index.
    pub fn body(&self, index: usize) -> &Arc<Body> {
        &self.blocks[index].body
    }

    /// Puts `body` in the place of body `index`, of as many nodes; the terms stay.
    ///
    /// # Errors
    /// Fails if its factorisation cannot be analysed.
    pub fn exchange(&mut self, index: usize, body: Arc<Body>) -> Result<()> {
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
                self.terms[i].iter().map(|t| t.energy(&self.blocks[i].body, &view)).sum()
            })
            .collect();
        // Summed in body order: the same bits on any number of threads.
        bodies.iter().sum::<f64>() - self.work(state) + self.proximal.as_ref().map_or(0.0, |p| p.energy(self, state))
    }

    /// A distance that every point may move from `state` before anything is touched, m.
    pub fn clearance(&self, state: &State) -> f64 {
        let of = |(i, terms): (usize, &Vec<Box<dyn BodyTerm>>)| {
            let view = state.view(i, &self.rigid);
            terms.iter().map(|t| t.clearance(&self.blocks[i].body, &view)).fold(f64::INFINITY, f64::min)
        };
        self.terms.iter().enumerate().map(of).fold(f64::INFINITY, f64::min)
    }

    /// Work of the finger forces, J.
    fn work(&self, state: &State) -> f64 {
        let driven = self.rigid.travel.iter().enumerate().filter(|(_, c)| c.is_some());
        driven.map(|(i, _)| self.force[i] * state.travel[i]).sum()
    }

    /// Assembles every block at `state`.
    pub fn assemble(&mut self, state: &State, project: bool) {
        self.assemble_some(state, project, true);
    }

    /// Assembles gradients at `state`, and Hessians if wanted.
    pub(crate) fn assemble_some(&mut self, state: &State, project: bool, hessian: bool) {
        let (rigid, proximal) = (&self.rigid, &self.proximal);
        self.blocks.par_iter_mut().zip(self.terms.par_iter_mut()).enumerate().for_each(|(i, (b, terms))| {
            b.block.clear(hessian);
            let view = state.view(i, rigid);
            for t in terms {
                t.assemble(&b.body, &view, project, &mut b.block);
            }
            if let Some(springs) = proximal {
                springs.assemble(i, &b.body, view.x, &mut b.block);
            }
        });
    }

    /// Gradient of body `i` after [`Newton::assemble`], N per node (reactions at fixed nodes).
    pub fn gradient(&self, i: usize) -> &[glam::DVec3] {
        &self.blocks[i].block.gradient
    }

    /// Gradient of the rigid unknowns after [`Newton::assemble`] at `state`, N.
    pub fn rigid_gradient(&self, state: &State) -> [f64; MAX_RIGID] {
        let mut g = [0.0; MAX_RIGID];
        for b in &self.blocks {
            for (g, v) in g.iter_mut().zip(b.block.rigid_gradient) {
                *g += v;
            }
        }
        for (i, column) in self.rigid.travel.iter().enumerate() {
            if let Some(c) = column {
                g[*c] -= self.force[i];
            }
        }
        if let Some(springs) = &self.proximal {
            g.iter_mut().zip(springs.rigid_gradient(self, state)).for_each(|(g, pull)| *g += pull);
        }
        // What holds the object answers every force on it.
        g[self.unknowns()..].fill(0.0);
        g
    }

    /// Number of rigid columns that are unknowns: those of the pose come last.
    pub(crate) fn unknowns(&self) -> usize {
        self.rigid.pose.filter(|_| self.object_fixed).unwrap_or(self.rigid.size)
    }

    /// Norm of all out-of-balance forces, and norm of what lagged forces still miss, N.
    pub(crate) fn residual(&self, state: &State) -> (f64, f64) {
        let rigid: f64 = self.rigid_gradient(state)[..self.rigid.size].iter().map(|v| v * v).sum();
        let nodes: f64 = self
            .blocks
            .iter()
            .map(|b| {
                let free = b.block.gradient.iter().zip(&b.body.fixed).filter(|(_, fixed)| !**fixed);
                free.map(|(g, _)| g.length_squared()).sum::<f64>()
            })
            .sum();
        let lag: f64 = self.blocks.iter().map(|b| b.block.lag).sum();
        ((rigid + nodes).sqrt(), lag.sqrt())
    }

    /// Largest contact force on a body, N.
    pub(crate) fn activity(&self) -> f64 {
        self.blocks.iter().map(|b| b.block.activity).fold(0.0, f64::max)
    }

    /// Returns true if some driven finger carries no contact force at all.
    pub(crate) fn untouched(&self) -> bool {
        let driven = self.blocks.iter().zip(&self.rigid.travel);
        driven.into_iter().any(|(b, column)| column.is_some() && b.block.activity == 0.0)
    }

    /// Factorises all blocks; assembles again with projected Hessians if one is not positive definite. Returns false if that
    /// fails too.
    pub(crate) fn factorize(&mut self, state: &State) -> bool {
        let clock = Instant::now();
        let good = factorize_all(&mut self.blocks);
        self.profile.factorization += clock.elapsed().as_secs_f64();
        if good {
            return true;
        }
        self.profile.projections += 1;
        self.assemble(state, true);
        factorize_all(&mut self.blocks)
    }

    /// Largest motion of any node relative to the object in a step, m.
    pub(crate) fn motion(&self, step: &NewtonStep) -> f64 {
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

    /// Sets how far lagged quantities follow in one iteration.
    pub(crate) fn damp(&mut self, damping: f64) {
        self.terms.iter_mut().flatten().for_each(|t| t.damp(damping));
    }

    /// Sets whether Hessians have all second derivatives.
    pub(crate) fn sharpen(&mut self, sharp: bool) {
        self.terms.iter_mut().flatten().for_each(|t| t.sharpen(sharp));
    }

    /// Copies all terms with their history.
    pub fn save(&self) -> Vec<Vec<Box<dyn BodyTerm>>> {
        self.terms.iter().map(|terms| terms.iter().map(|t| t.boxed_clone()).collect()).collect()
    }

    /// Begins an increment at the accepted state `from`.
    pub(crate) fn depart(&mut self, from: &State) {
        let from = Arc::new(from.clone());
        for (i, terms) in self.terms.iter_mut().enumerate() {
            let departure = Departure::new(from.clone(), i, &self.rigid);
            terms.iter_mut().for_each(|t| t.depart(&departure));
        }
    }

    /// Takes over the history of an accepted state.
    pub fn commit(&mut self, state: &State) {
        for (i, (b, terms)) in self.blocks.iter().zip(self.terms.iter_mut()).enumerate() {
            let view = state.view(i, &self.rigid);
            terms.iter_mut().for_each(|t| t.commit(&b.body, &view));
        }
    }

    /// Forgets what terms learnt since the last commit.
    pub fn rollback(&mut self) {
        self.terms.iter_mut().flatten().for_each(|t| t.rollback());
    }
}

fn factorize_all(blocks: &mut [ArrowBlock]) -> bool {
    // Every block is factorised whatever the others give, so that the work does not depend on timing.
    blocks.par_iter_mut().map(ArrowBlock::factorize).collect::<Vec<_>>().into_iter().all(|ok| ok)
}
