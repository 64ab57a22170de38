//! The incremental potential: bodies with their terms, the rigid unknowns that join them, and the system Newton's method solves.

pub mod arrow;
mod direction;
pub mod effort;
mod lagging;
pub mod object;
pub mod proximal;
mod solve;

use self::arrow::ArrowBlock;
use self::effort::Effort;
use self::object::ObjectTerms;
use self::proximal::Proximal;
use super::body::Body;
use super::potential::block::RigidBlock;
use super::potential::edge::{EdgeReading, EdgeState};
use super::potential::state::{Departure, MAX_RIGID, NewtonStep, RigidUnknowns, State};
use super::potential::term::{Assembly, BodyTerm};
use super::potential::time_step::TimeStep;
use crate::error::Result;
use crate::history::{HistoryReader, HistoryWriter};
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

/// Copy of all terms, with their history.
pub struct SavedTerms {
    gel: Vec<Vec<Box<dyn BodyTerm>>>,
    terms: Vec<Vec<Box<dyn BodyTerm>>>,
    object: ObjectTerms,
}

/// Bodies with their terms, and the rigid unknowns that join them.
pub struct Newton {
    /// Terms of each body: the law of its gel, or what stands for it.
    pub gel: Vec<Vec<Box<dyn BodyTerm>>>,
    /// Terms of each body beside its gel: contact, inertia, drive.
    pub terms: Vec<Vec<Box<dyn BodyTerm>>>,
    /// Terms of the object.
    pub object: ObjectTerms,
    /// Layout of the rigid unknowns.
    pub rigid: RigidUnknowns,
    /// Force along each driven travel, N.
    pub force: Vec<f64>,
    /// Timings.
    pub profile: SolverProfile,
    /// The time step that is solved for; None on a quasi-static path.
    pub step: Option<TimeStep>,
    /// The springs of a pseudo-time step, on paths without stable equilibria.
    pub proximal: Option<Proximal>,
    /// Flag: the object is held where it is, and its pose is no unknown.
    pub object_fixed: bool,
    /// Limit on the work of the solver.
    pub effort: Effort,
    pub(crate) blocks: Vec<ArrowBlock>,
    /// Gradient and Hessian of what acts on the rigid unknowns alone, and gradients to be solved for beside them.
    pub(crate) object_block: RigidBlock,
    pub(crate) object_extra: RigidBlock,
}

impl Newton {
    /// Creates a solver for `bodies` with `terms` per body, without terms of gel or object.
    ///
    /// # Errors
    /// Fails if the factorisation of a body cannot be analysed.
    pub fn new(bodies: Vec<Arc<Body>>, terms: Vec<Vec<Box<dyn BodyTerm>>>, rigid: RigidUnknowns) -> Result<Self> {
        // Analyses take long the first time.
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
            object_block: RigidBlock::default(),
            object_extra: RigidBlock::default(),
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
                self.body_terms(i).map(|t| t.energy(&self.blocks[i].body, &view)).sum()
            })
            .collect();
        let object = self.object.energy(state, &self.rigid);
        // Summed in body order: the same bits on any number of threads.
        bodies.iter().sum::<f64>() + object - self.work(state)
            + self.proximal.as_ref().map_or(0.0, |p| p.energy(self, state))
    }

    /// A distance that every point may move from `state` before anything is touched, m.
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

    /// Terms of body `i`: its gel, then the others.
    fn body_terms(&self, i: usize) -> impl Iterator<Item = &dyn BodyTerm> {
        self.gel[i].iter().chain(&self.terms[i]).map(|t| &**t)
    }

    /// Terms of all bodies.
    fn all_terms(&mut self) -> impl Iterator<Item = &mut Box<dyn BodyTerm>> {
        self.gel.iter_mut().chain(&mut self.terms).flatten()
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
        // What holds the object answers every force on it.
        g[self.unknowns()..].fill(0.0);
        g
    }

    /// Number of rigid columns that are unknowns: those of the pose come last.
    pub(crate) fn unknowns(&self) -> usize {
        self.rigid.pose.filter(|_| self.object_fixed).unwrap_or(self.rigid.size)
    }

    /// Norm of all out-of-balance forces, and norm of what lagged forces still miss, N.
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

    /// Largest contact force on a body, and the forces on the object alone, N.
    pub(crate) fn activity(&self) -> f64 {
        self.blocks.iter().map(|b| b.block.rigid.activity).fold(0.0, f64::max) + self.object_block.activity
    }

    /// Returns true if some driven finger carries no contact force at all.
    pub(crate) fn untouched(&self) -> bool {
        let driven = self.blocks.iter().zip(&self.rigid.travel);
        driven.into_iter().any(|(b, column)| column.is_some() && b.block.rigid.activity == 0.0)
    }

    /// Factorises all blocks; assembles again with projected Hessians if one is not positive definite. Returns false if that
    /// fails too.
    pub(crate) fn factorize(&mut self, state: &State, how: Assembly) -> bool {
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

    /// Copies all terms with their history.
    pub fn save(&self) -> SavedTerms {
        let copy = |terms: &Vec<Vec<Box<dyn BodyTerm>>>| {
            terms.iter().map(|terms| terms.iter().map(|t| t.boxed_clone()).collect()).collect()
        };
        SavedTerms { gel: copy(&self.gel), terms: copy(&self.terms), object: self.object.clone() }
    }

    /// Puts saved terms back.
    pub fn restore(&mut self, saved: SavedTerms) {
        (self.gel, self.terms, self.object) = (saved.gel, saved.terms, saved.object);
    }

    /// Begins an increment at the accepted state `from`.
    pub fn depart(&mut self, from: &State) {
        let (from, step) = (Arc::new(from.clone()), self.step);
        for (i, (gel, terms)) in self.gel.iter_mut().zip(&mut self.terms).enumerate() {
            let departure = Departure::new(from.clone(), i, &self.rigid, step);
            gel.iter_mut().chain(terms).for_each(|t| t.depart(&departure));
        }
        step.iter().for_each(|step| self.object.begin(step));
    }

    /// Takes over the history of an accepted state.
    pub fn commit(&mut self, state: &State) {
        let terms = self.gel.iter_mut().zip(&mut self.terms);
        for (i, (b, (gel, terms))) in self.blocks.iter().zip(terms).enumerate() {
            let view = state.view(i, &self.rigid);
            gel.iter_mut().chain(terms).for_each(|t| t.commit(&b.body, &view));
        }
        self.object.commit(state, &self.rigid);
    }

    /// Forgets what terms learnt since the last commit.
    pub fn rollback(&mut self) {
        self.all_terms().for_each(|t| t.rollback());
        self.object.rollback();
    }

    /// Returns true if the converged `state` satisfies every term; each is asked, since each may strengthen itself.
    pub(crate) fn satisfied(&mut self, state: &State) -> bool {
        let (rigid, blocks) = (&self.rigid, &self.blocks);
        let terms = self.gel.par_iter_mut().zip(&mut self.terms).enumerate();
        let ask = |(i, (gel, terms)): (usize, (&mut Vec<Box<dyn BodyTerm>>, &mut Vec<Box<dyn BodyTerm>>))| {
            let view = state.view(i, rigid);
            let asked = gel.iter_mut().chain(terms).map(|t| t.satisfied(&blocks[i].body, &view));
            asked.filter(|satisfied| !satisfied).count() == 0
        };
        let bodies: Vec<bool> = terms.map(ask).collect();
        self.object.satisfied() && bodies.into_iter().all(|satisfied| satisfied)
    }

    /// Contact edges of body `i` that are not open at `state`, numbered within the body.
    pub fn edge_readings(&self, state: &State, i: usize) -> Vec<EdgeReading> {
        let view = state.view(i, &self.rigid);
        let (mut all, mut first) = (Vec::new(), 0);
        for term in self.body_terms(i) {
            let numbered = |edge: EdgeReading| EdgeReading { number: first + edge.number, ..edge };
            all.extend(term.edge_readings(&view).into_iter().map(numbered));
            first += term.edge_count();
        }
        all
    }

    /// Puts the accepted edges of body `i` that are not open back, with their numbers within the body in rising order.
    pub fn set_edges(&mut self, i: usize, edges: &[(usize, EdgeState)]) {
        let (mut rest, mut first) = (edges, 0);
        for term in self.gel[i].iter_mut().chain(&mut self.terms[i]) {
            let next = first + term.edge_count();
            let (own, others) = rest.split_at(rest.partition_point(|(number, _)| *number < next));
            let own: Vec<_> = own.iter().map(|(number, edge)| (number - first, *edge)).collect();
            term.set_edges(&own);
            (rest, first) = (others, next);
        }
    }

    /// Writes the history of all terms.
    pub fn write_history(&self, history: &mut HistoryWriter) {
        (0..self.blocks.len()).flat_map(|i| self.body_terms(i)).for_each(|t| t.write_history(history));
        self.object.write_history(history);
    }

    /// Reads the history of the same terms.
    ///
    /// # Errors
    /// Fails for a history of something else.
    pub fn read_history(&mut self, history: &mut HistoryReader) -> Result<()> {
        for (gel, terms) in self.gel.iter_mut().zip(&mut self.terms) {
            gel.iter_mut().chain(terms).try_for_each(|t| t.read_history(history))?;
        }
        self.object.read_history(history)
    }
}

fn factorize_all(blocks: &mut [ArrowBlock]) -> bool {
    // Every block is factorised whatever the others give, so that the work does not depend on timing.
    blocks.par_iter_mut().map(ArrowBlock::factorize).collect::<Vec<_>>().into_iter().all(|ok| ok)
}
