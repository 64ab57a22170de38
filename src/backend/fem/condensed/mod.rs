//! Static condensation of the pads onto the part of their surface that can touch the object: the fast mode.
//!
//! ```text
//! full pad at x:   stiffness K, forces g(x)        every node, rarely
//!                  | eliminate all but the patch
//! patch:           1/2 (x_p - c_p)' S (x_p - c_p)  Newton, contact and friction as usual, on few unknowns
//!                  | K^-1
//! full pad:        x = c + K^-1 S (x_p - c_p)      once per load level
//!                  | c -= K^-1 (g(x) - contact)    correction by the full material law at x
//! ```
//!
//! `S` is the Schur complement of `K` (static condensation: Guyan 1965). `c` is the equilibrium of the unloaded pad if
//! its stiffness stayed constant. The gel is nonlinear, so `c` changes with the load. Correcting it once per level with
//! the existing factor is a modified Newton step for the full pad. The size of this step, over the displacement, is the
//! error that the user accepts. When corrections are not enough, the pad is recondensed in its current state. When that
//! is not enough either (elements close to inversion), the grasp falls back to the full model.

mod pad;
mod patch;
mod term;

pub use pad::CondensedPad;
pub use patch::patch_nodes;
pub use term::CondensedEnergy;

use base::error;
use base::saved_state::{StateReader, StateWriter};
use base::scales::FIRST_PATCH_PENETRATION;
use geometry::Pose;
use glam::DVec3;
use mech::newton::Failure;
use mech::path::continuation::PadDiscretisation;
use mech::path::{AdvanceCost, Path};
use mech::potential::state::{RigidUnknowns, State};
use mech::potential::stencil::Stencil;
use model::Model;
use rayon::prelude::*;
use std::time::Instant;

/// The condensed pads of one grasp.
pub struct Condensation {
    pads: Vec<CondensedPad>,
    /// Accepted size of a correction: its change of the displacement, over the displacement.
    error: f64,
    /// Levels of the last two accepted states. The centres are predicted from their change between these levels.
    levels: [Option<f64>; 2],
}

/// Out-of-balance force accepted in a result, over the contact forces and over the accepted error.
const RESULT_TOLERANCE_RATIO: f64 = 0.1;
/// Number of corrections after which a level fails.
const MAX_CORRECTIONS: u32 = 8;
/// Largest ratio of a correction to the previous one. Above it, the stiffness is out of date.
const LARGEST_CORRECTION_RATIO: f64 = 0.3;

impl Condensation {
    /// Creates the condensation of the pads of `model` under the dead loads `dead` (N per node; empty lists for none).
    /// No pad is condensed yet.
    pub fn new(model: &Model, dead: Vec<Vec<DVec3>>, error: f64) -> Self {
        let pads = model.fingers.iter().zip(dead).map(|(f, dead)| CondensedPad::new(f, dead)).collect();
        Self { pads, error, levels: [None; 2] }
    }

    /// Returns the condensed pad of finger `i`.
    pub fn pad(&self, i: usize) -> &CondensedPad {
        &self.pads[i]
    }

    /// Condenses the pads at first contact, in the state of `path`. The patches include the nodes that the force of
    /// first contact may bring into contact.
    ///
    /// # Errors
    /// Returns [`Failure::Singular`] if the stiffness cannot be factorised.
    pub fn condense_at_contact(&mut self, path: &mut Path, model: &Model) -> Result<(), Failure> {
        let patches = self.patches(path, model, FIRST_PATCH_PENETRATION * model.offset);
        self.condense(path, patches)
    }

    /// Returns the condensed pads of `model`, for a continuation.
    pub fn discretisation<'a>(&'a mut self, model: &'a Model) -> CondensedPads<'a> {
        CondensedPads { pads: self, model }
    }

    /// Corrects the pads of `model` at the equilibrium found at `level` until their error is small enough and contact
    /// lies within their patches. If it is a `result`, the out-of-balance forces must be small, too.
    fn correct_until_converged(
        &mut self,
        path: &mut Path,
        model: &Model,
        level: f64,
        result: bool,
        done: &mut AdvanceCost,
    ) -> Result<(), Failure> {
        let mut last = f64::INFINITY;
        for _ in 0..MAX_CORRECTIONS {
            let (error, residual) = self.correct(path)?;
            done.residual = residual;
            let grown = self.enlarge_patches(path, model)?;
            // Only a result has to satisfy the balance of forces.
            let balanced = !result || residual <= RESULT_TOLERANCE_RATIO * self.error * path.newton.force_scale();
            if error <= self.error && balanced && !grown {
                self.accept(level);
                return Ok(());
            }
            if error > LARGEST_CORRECTION_RATIO * last && !grown {
                self.recondense(path)?;
            }
            last = error;
            done.add(path.solve_tightly()?);
        }
        Err(Failure::Corrections(last))
    }

    /// Corrects the pads of `model` once at the intermediate state found at `level`; recondenses them if the correction
    /// exceeds the accepted error or contact has outgrown their patches.
    fn correct_once(&mut self, path: &mut Path, model: &Model, level: f64) -> Result<(), Failure> {
        let (error, _) = self.correct(path)?;
        self.accept(level);
        if !self.enlarge_patches(path, model)? && error > self.error {
            self.recondense(path)?;
        }
        Ok(())
    }

    /// Recondenses the pads whose contact has outgrown their patches onto larger ones, in the state of `path`; returns
    /// true if there are any.
    fn enlarge_patches(&mut self, path: &mut Path, model: &Model) -> Result<bool, Failure> {
        let outside: Vec<bool> = (0..self.pads.len()).map(|i| self.exceeds_patch(path, i)).collect();
        if !outside.contains(&true) {
            return Ok(false);
        }
        path.methods.recondensed += 1;
        let patches = self.patches(path, model, 0.0).into_iter().zip(outside);
        let patches = patches.map(|(patch, outside)| patch.filter(|_| outside)).collect();
        self.condense(path, patches)?;
        Ok(true)
    }

    /// Stores the pads as those of the accepted `level`.
    fn accept(&mut self, level: f64) {
        self.levels = [self.levels[1], Some(level)];
        self.pads.iter_mut().for_each(CondensedPad::accept);
    }

    /// Recondenses the pads onto the same nodes, with their stiffness in the state of `path`.
    fn recondense(&mut self, path: &mut Path) -> Result<(), Failure> {
        let same = self.pads.iter().map(|pad| Some(pad.patch().to_vec())).collect();
        self.condense(path, same)
    }

    /// Condenses the pads for which `patches` has nodes onto these nodes, with their stiffness in the state of `path`.
    fn condense(&mut self, path: &mut Path, patches: Vec<Option<Vec<u32>>>) -> Result<(), Failure> {
        let clock = Instant::now();
        let work = self.pads.par_iter_mut().zip(patches).zip(&path.state.x);
        let condense = |((pad, patch), x): ((&mut CondensedPad, Option<Vec<u32>>), &Vec<DVec3>)| {
            patch.map_or(Ok(None), |patch| pad.condense(x, patch))
        };
        let bodies: Vec<_> = work.map(condense).collect();
        // A pad that could not be condensed keeps its patch; the solver still gets the new bodies of the others.
        let mut condensed = Ok(());
        for (i, body) in bodies.into_iter().enumerate() {
            match body {
                Ok(None) => {}
                Ok(Some(body)) => path.newton.replace_body(i, body).map_err(|_| Failure::Singular)?,
                Err(failure) => condensed = Err(failure),
            }
        }
        self.install_terms(path);
        path.newton.profile.factorization += clock.elapsed().as_secs_f64();
        condensed
    }

    /// Computes the full pads from their patches and corrects them by the full material law. Returns the size of the
    /// correction over the displacement, and the out-of-balance force, N.
    fn correct(&mut self, path: &mut Path) -> Result<(f64, f64), Failure> {
        let clock = Instant::now();
        let pads = self.pads.par_iter_mut().zip(path.state.x.par_iter_mut());
        let corrections: Vec<_> = pads.map(|(pad, x)| pad.correct(x)).collect();
        let sum = |pick: fn(&pad::Correction) -> f64| corrections.iter().map(pick).sum::<f64>();
        let error = (sum(|c| c.change) / sum(|c| c.displacement).max(f64::MIN_POSITIVE)).sqrt();
        let residual = sum(|c| c.residual).sqrt();
        path.newton.profile.solve += clock.elapsed().as_secs_f64();
        if !error.is_finite() {
            return Err(Failure::Singular);
        }
        self.install_terms(path);
        Ok((error, residual))
    }

    /// Begins another kind of load, for which the previous levels predict nothing.
    pub(crate) fn begin_load(&mut self) {
        self.levels = [None; 2];
    }

    /// Extrapolates the centres to `level` from the last two accepted levels.
    fn predict(&mut self, path: &mut Path, level: f64) {
        let [Some(before), Some(last)] = self.levels else { return };
        let factor = (level - last) / (last - before);
        if factor.is_finite() {
            self.pads.iter_mut().for_each(|pad| pad.predict(factor.clamp(0.0, 2.0)));
            self.install_terms(path);
        }
    }

    /// Passes the terms of the pads to the solver.
    fn install_terms(&self, path: &mut Path) {
        for (pad, gel) in self.pads.iter().zip(&mut path.newton.gel) {
            *gel = vec![Box::new(pad.term())];
        }
    }

    /// Writes everything that the next level depends on.
    pub(crate) fn save_state(&self, history: &mut StateWriter) {
        history.write(&self.levels);
        self.pads.iter().for_each(|pad| pad.save_state(history));
    }

    /// Reads what [`Condensation::save_state`] wrote, and condenses the pads of `path` as before.
    ///
    /// # Errors
    /// Fails if the history does not match.
    pub(crate) fn restore_state(&mut self, path: &mut Path, history: &mut StateReader) -> error::Result<()> {
        self.levels = history.read()?;
        for (i, pad) in self.pads.iter_mut().enumerate() {
            if let Some(body) = pad.restore_state(history)? {
                path.newton.replace_body(i, body)?;
            }
        }
        self.install_terms(path);
        Ok(())
    }

    /// Returns true if contact has reached nodes of pad `i` outside its patch.
    fn exceeds_patch(&self, path: &Path, i: usize) -> bool {
        pressed_stencils(path, i).any(|stencil| !self.pads[i].contains(&stencil))
    }

    /// Returns, for every pad, the nodes that may touch the object in the state of `path`, or would if the object came
    /// `nearer` (m).
    fn patches(&self, path: &Path, model: &Model, nearer: f64) -> Vec<Option<Vec<u32>>> {
        let pads = model.fingers.par_iter().enumerate();
        let of = |(i, finger)| {
            let view = path.state.view(i, &path.newton.rigid);
            Some(patch_nodes(finger, &view, &model.object, model.offset, nearer, pressed_stencils(path, i)))
        };
        pads.map(of).collect()
    }
}

/// Condensed pads of a model, as the discretisation of a continuation.
pub struct CondensedPads<'a> {
    pads: &'a mut Condensation,
    model: &'a Model,
}

impl PadDiscretisation for CondensedPads<'_> {
    fn needs_checkpoint(&self) -> bool {
        true
    }

    fn predict(&mut self, path: &mut Path, level: f64) {
        self.pads.predict(path, level);
    }

    fn correct(&mut self, path: &mut Path, level: f64, result: bool, done: &mut AdvanceCost) -> Result<(), Failure> {
        self.pads.correct_until_converged(path, self.model, level, result, done)
    }

    fn correct_once(&mut self, path: &mut Path, level: f64) -> Result<(), Failure> {
        self.pads.correct_once(path, self.model, level)
    }

    fn restore(&mut self, path: &mut Path) {
        self.pads.pads.iter_mut().for_each(CondensedPad::restore);
        // The terms restored with the path belong to the previous patches.
        self.pads.install_terms(path);
    }
}

/// Returns the number of nodes that each pad would be condensed onto at first contact, with the object at `pose` and
/// the fingers at `travel` (m).
pub fn nodes_at_contact(model: &Model, pose: &Pose, travel: &[f64]) -> Vec<usize> {
    // Only the positions of the pads matter here.
    let closing = model.fingers.iter().map(|f| f.placement.closing).collect();
    let rigid = RigidUnknowns { closing, ..RigidUnknowns::none(model.fingers.len()) };
    let state = State {
        x: model.fingers.iter().map(|f| f.body.rest.clone()).collect(),
        travel: travel.to_vec(),
        position: pose.position,
        rotation: pose.rotation,
    };
    let pads = model.fingers.iter().enumerate();
    let patch = |(i, f)| patch_nodes(f, &state.view(i, &rigid), &model.object, model.offset, 0.0, std::iter::empty());
    pads.map(|pad| patch(pad).len()).collect()
}

/// Returns the stencils of pad `i` that are under contact pressure.
fn pressed_stencils(path: &Path, i: usize) -> impl Iterator<Item = Stencil> {
    let edges = path.newton.edge_readings(&path.state, i).into_iter();
    edges.filter(|edge| edge.state.pressure > 0.0).map(|edge| edge.touched)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fem::solver::GraspSolver;
    use mech::potential::term::Assembly;
    use model::grasp::grasp_poses;
    use scene::from_ron;

    /// After a failed attempt in which a patch grew, stiffness and unknowns belong to the same patch: the system can be
    /// factorised in the restored state.
    #[test]
    fn a_patch_that_grew_outlives_the_attempt_that_failed() {
        let text =
            "Scene(object: (shape: Sphere(radius: 0.02), motion: Fixed), gripper: (pads: GelSightMini(spacing: 1.5e-3)),
                    loading: Squeeze(force: 6.0), stepper: Fem())";
        let scene = from_ron(text).unwrap();
        let (model, place) = (Model::build(&scene).unwrap(), grasp_poses(&scene).unwrap()[0].inverse());
        let pose = Pose { position: place.position, rotation: place.rotation };
        let scene::StepperChoice::Fem(settings) = &scene.stepper else { panic!("finite elements") };
        let mut solver = GraspSolver::new(&model, pose, settings).unwrap();
        solver.approach_object(&model).unwrap();
        let mut pads = Condensation::new(&model, vec![Vec::new(); model.fingers.len()], 0.01);
        pads.condense_at_contact(&mut solver.path, &model).unwrap();
        let (saved, before) = (solver.path.checkpoint(), pads.pad(0).patch().len());
        solver.path.state.travel.iter_mut().for_each(|travel| *travel += 1e-3);
        let deeper = solver.path.state.clone();
        solver.path.newton.assemble(&deeper, Assembly::COMPLETE);
        solver.path.newton.commit(&deeper);
        pads.discretisation(&model).correct_once(&mut solver.path, 1.0).unwrap();
        assert!(pads.pad(0).patch().len() > before, "{before} nodes, and no more 1 mm deeper");
        solver.path.restore(saved);
        pads.discretisation(&model).restore(&mut solver.path);
        let (state, newton) = (solver.path.state.clone(), &mut solver.path.newton);
        newton.assemble(&state, Assembly::COMPLETE);
        assert!(newton.factorize(&state, Assembly::COMPLETE) && newton.profile.projections == 0);
    }
}
