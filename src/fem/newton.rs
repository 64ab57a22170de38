//! Newton's method with line search on the incremental potential.

use super::arrow::{self, ArrowBlock};
use super::body::Body;
use super::state::{Border, MAX_BORDER, State, Step};
use super::term::BodyTerm;
use rayon::prelude::*;
use std::sync::Arc;
use std::time::Instant;

/// When to stop, and how far one iteration may go.
#[derive(Debug, Clone, Copy)]
pub struct Tolerance {
    /// Largest norm of the out-of-balance forces, N.
    pub force: f64,
    /// Largest motion of any unknown in the last iteration, m.
    pub length: f64,
    /// Iterations before an increment is given up.
    pub iterations: u32,
    /// Largest motion of any point in one iteration, m: keeps the closest point on the right side of thin objects.
    pub motion: f64,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self { force: 1e-5, length: 1e-6, iterations: 60, motion: 1e-3 }
    }
}

/// What a converged solve cost and reached.
#[derive(Debug, Clone, Copy, Default)]
pub struct Converged {
    /// Newton iterations (linear solves).
    pub iterations: u32,
    /// Norm of the out-of-balance forces, N.
    pub residual: f64,
}

/// Why a solve stopped without converging.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Failure {
    /// The iteration limit was reached with this residual, N.
    Iterations(f64),
    /// No step along the Newton direction lowers the energy; residual, N.
    LineSearch(f64),
    /// Not positive definite even after projection, or not finite.
    Singular,
}

/// Wall time by stage, s.
#[derive(Debug, Clone, Copy, Default)]
pub struct Profile {
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
}

/// Bodies with their terms, and the border that joins them.
pub struct Newton {
    /// Terms of each body.
    pub terms: Vec<Vec<Box<dyn BodyTerm>>>,
    /// Border layout.
    pub border: Border,
    /// Force along each driven travel, N.
    pub force: Vec<f64>,
    /// Timings.
    pub profile: Profile,
    blocks: Vec<ArrowBlock>,
}

impl Newton {
    /// A solver for `bodies` with `terms` per body.
    pub fn new(bodies: Vec<Arc<Body>>, terms: Vec<Vec<Box<dyn BodyTerm>>>, border: Border) -> Self {
        let blocks: Vec<_> = bodies.into_iter().map(|b| ArrowBlock::new(b, border.size)).collect();
        let force = vec![0.0; blocks.len()];
        Self { terms, border, force, profile: Profile::default(), blocks }
    }

    /// The body with this index.
    pub fn body(&self, index: usize) -> &Arc<Body> {
        &self.blocks[index].body
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
                let view = state.view(i, &self.border);
                self.terms[i].iter().map(|t| t.energy(&self.blocks[i].body, &view)).sum()
            })
            .collect();
        // Summed in body order: the same bits on any number of threads.
        bodies.iter().sum::<f64>() - self.work(state)
    }

    /// Work of the finger forces, J.
    fn work(&self, state: &State) -> f64 {
        let driven = self.border.travel.iter().enumerate().filter(|(_, c)| c.is_some());
        driven.map(|(i, _)| self.force[i] * state.travel[i]).sum()
    }

    /// Assembles every block at `state`.
    pub fn assemble(&mut self, state: &State, project: bool) {
        let border = &self.border;
        self.blocks.par_iter_mut().zip(self.terms.par_iter_mut()).enumerate().for_each(|(i, (b, terms))| {
            b.block.clear();
            let view = state.view(i, border);
            for t in terms {
                t.assemble(&b.body, &view, project, &mut b.block);
            }
        });
    }

    /// Gradient of body `i` after [`Newton::assemble`], N per node (reactions at fixed nodes).
    pub fn gradient(&self, i: usize) -> &[glam::DVec3] {
        &self.blocks[i].block.gradient
    }

    /// Border gradient after [`Newton::assemble`], N.
    pub fn border_gradient(&self) -> [f64; MAX_BORDER] {
        let mut g = [0.0; MAX_BORDER];
        for b in &self.blocks {
            for (g, v) in g.iter_mut().zip(b.block.border_gradient) {
                *g += v;
            }
        }
        for (i, column) in self.border.travel.iter().enumerate() {
            if let Some(c) = column {
                g[*c] -= self.force[i];
            }
        }
        g
    }

    /// Norm of all out-of-balance forces, N.
    fn residual(&self) -> f64 {
        let border: f64 = self.border_gradient()[..self.border.size].iter().map(|v| v * v).sum();
        let nodes: f64 = self
            .blocks
            .iter()
            .map(|b| {
                let free = b.block.gradient.iter().zip(&b.body.fixed).filter(|(_, fixed)| !**fixed);
                free.map(|(g, _)| g.length_squared()).sum::<f64>()
            })
            .sum();
        (border + nodes).sqrt()
    }

    /// Factorises all blocks, re-assembling with projected Hessians if one is not positive definite.
    fn factorize(&mut self, state: &State) -> bool {
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

    /// Minimises the potential from `state`. On failure `state` is left as it was.
    ///
    /// # Errors
    /// [`Failure`] says why; the terms' history is untouched, so a smaller increment can be tried.
    pub fn solve(&mut self, state: &mut State, tolerance: &Tolerance) -> Result<Converged, Failure> {
        let mut now = state.clone();
        let mut last_motion = f64::INFINITY;
        let mut history = [f64::INFINITY; 2];
        let mut iterations = 0;
        loop {
            let clock = Instant::now();
            self.assemble(&now, false);
            self.profile.assembly += clock.elapsed().as_secs_f64();
            let residual = self.residual();
            if std::env::var_os("TACTUS_TRACE").is_some() {
                eprintln!("  it {iterations} residual {residual:.3e} motion {last_motion:.2e} border {:?}", &self.border_gradient()[..self.border.size]);
            }
            if !residual.is_finite() {
                return Err(Failure::Singular);
            }
            if residual <= tolerance.force && (last_motion <= tolerance.length || residual <= 0.01 * tolerance.force) {
                let border = &self.border;
                let bodies = self.blocks.iter().zip(self.terms.iter_mut()).enumerate();
                // Every term must be asked: each may strengthen itself.
                let held = bodies.fold(true, |held, (i, (b, terms))| {
                    let view = now.view(i, border);
                    terms.iter_mut().fold(held, |held, t| t.satisfied(&b.body, &view) && held)
                });
                if held {
                    *state = now;
                    return Ok(Converged { iterations, residual });
                }
                last_motion = f64::INFINITY;
                iterations += 1;
                if iterations >= tolerance.iterations {
                    return Err(Failure::Iterations(residual));
                }
                continue;
            }
            if iterations >= tolerance.iterations {
                return Err(Failure::Iterations(residual));
            }
            if !self.factorize(&now) {
                return Err(Failure::Singular);
            }
            let clock = Instant::now();
            self.blocks.par_iter_mut().for_each(ArrowBlock::solve);
            let gradient = self.border_gradient();
            let step = arrow::step(&self.blocks, &gradient, self.border.size, 1e-3);
            self.profile.solve += clock.elapsed().as_secs_f64();
            // Lagged friction can swing between two states, a point touching in one and not in the other, each a minimum for
            // what the other lags: half a step leads out of the cycle.
            let cycles = (residual - history[0]).abs() < 0.05 * residual;
            history = [history[1], residual];
            let longest = if cycles { 0.5 } else { 1.0 };
            let clock = Instant::now();
            let searched = self.line_search(&now, &step, &gradient, tolerance.motion, longest);
            self.profile.line_search += clock.elapsed().as_secs_f64();
            iterations += 1;
            self.profile.iterations += 1;
            match searched {
                Some((next, motion)) => {
                    now = next;
                    last_motion = motion;
                }
                // At rounding level no step lowers the energy any more: that is as converged as doubles get.
                None if residual <= tolerance.force => last_motion = 0.0,
                None => return Err(Failure::LineSearch(residual)),
            }
        }
    }

    /// Backtracks from the fraction `longest` of the step until the energy falls (Armijo); the new state and its largest
    /// motion, m, which is at most `cap`.
    fn line_search(
        &self,
        now: &State,
        step: &Step,
        border: &[f64; MAX_BORDER],
        cap: f64,
        longest: f64,
    ) -> Option<(State, f64)> {
        let motion = self.motion(step);
        let slope = self.slope(step, border);
        if !motion.is_finite() || !slope.is_finite() {
            return None;
        }
        let start = self.energy(now);
        let mut alpha = (cap / motion.max(f64::MIN_POSITIVE)).min(longest);
        for trial in 0..30 {
            let next = now.moved(&self.border, step, alpha);
            let energy = self.energy(&next);
            if std::env::var_os("TACTUS_TRACE").is_some() {
                eprintln!("      alpha {alpha:.3e} energy {energy:.6e} start {start:.6e} slope {slope:.3e}");
            }
            // Rounding of the sum over elements is about 1e-14 of the energy.
            if energy <= start + 1e-4 * alpha * slope + 1e-14 * start.abs() {
                return Some((next, alpha * motion));
            }
            alpha *= if trial < 2 { 0.5 } else { 0.25 };
        }
        None
    }

    /// Largest motion of any node relative to the object in a step, m.
    fn motion(&self, step: &Step) -> f64 {
        let nodes = step.x.iter().flatten().map(|d| d.length_squared()).fold(0.0, f64::max).sqrt();
        nodes + step.border[..self.border.size].iter().map(|d| d.abs()).fold(0.0, f64::max)
    }

    /// Directional derivative of the energy along the step, J.
    fn slope(&self, step: &Step, border: &[f64; MAX_BORDER]) -> f64 {
        let nodes: f64 = self
            .blocks
            .iter()
            .zip(&step.x)
            .map(|(b, d)| b.block.gradient.iter().zip(d).map(|(g, d)| g.dot(*d)).sum::<f64>())
            .sum();
        nodes + border.iter().zip(&step.border).map(|(g, d)| g * d).sum::<f64>()
    }

    /// Takes over the history of an accepted state.
    pub fn commit(&mut self, state: &State) {
        for (i, (b, terms)) in self.blocks.iter().zip(self.terms.iter_mut()).enumerate() {
            let view = state.view(i, &self.border);
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
