//! Load levels of a grasp: first contact if needed, the load, and the fall-back from condensed to full pads.

use super::solver::GraspSolver;
use base::scales::DROP_DISTANCE;
use geometry::Pose;
use glam::DVec3;
use mech::newton::Failure;
use mech::newton::effort::{agent_step_iteration_limit, iteration_limit};
use mech::path::continuation::FullPads;
use mech::path::grasp_limits::GraspLimits;
use mech::path::{AdvanceCost, Load};
use model::push::FIRST_FRACTION;
use model::{DropLimits, Model};
use world::schedule::{EarlyTermination, StepLoad};

/// Number of steps in which the weight of an object passes from its support to the fingers.
const WEIGHT_STEPS: u32 = 4;

/// Fraction of the contact pressure at the Coulomb limit from which on an object without equilibrium under a push
/// slips.
const SLIPPING_FRACTION: f64 = 0.7;

/// Fraction of the contact pressure at the Coulomb limit above which the object slides even in equilibrium: such an
/// equilibrium exists only because a dead push has less moment the further the object has rotated.
const SLIDING_FRACTION: f64 = 0.99;

/// Reason why a level was not reached.
enum LevelFailure {
    /// No equilibrium exists, or the effort is exhausted.
    Final(EarlyTermination),
    /// No equilibrium was found, though one may exist.
    NotFound(EarlyTermination),
    /// Condensed pads cannot reach the level.
    CondensedPads(EarlyTermination),
}

impl LevelFailure {
    fn stop(self) -> EarlyTermination {
        let (LevelFailure::Final(stop) | LevelFailure::NotFound(stop) | LevelFailure::CondensedPads(stop)) = self;
        stop
    }
}

impl GraspSolver {
    /// Brings the state to `target`. The first call starts from first contact.
    ///
    /// # Errors
    /// Returns the cause of the stop, for the record; the state is then the last accepted one.
    pub fn advance(&mut self, model: &Model, target: StepLoad) -> std::result::Result<AdvanceCost, EarlyTermination> {
        self.steps += 1;
        let (each, steps) = (self.settings().max_iterations.get() as u32, model.levels.len().max(self.steps));
        let agent = model.needs.task && self.progress.started;
        let usual = if agent { agent_step_iteration_limit(each) } else { iteration_limit(each, steps) };
        let most = self.settings().effort.map_or(usual, |most| most.get() as u64);
        let newton = &mut self.path.newton;
        newton.effort.from = if agent { newton.profile.iterations } else { 0 };
        newton.effort.iterations = most;
        let progress = self.progress;
        let checkpoint = self.condensed.is_some().then(|| self.path.checkpoint());
        let stuck = match (self.attempt_level(model, target), checkpoint) {
            (Err(LevelFailure::CondensedPads(_)), Some(checkpoint)) => checkpoint,
            // An object that rotates far before it is held may leave the patches of the condensed pads.
            (Err(LevelFailure::NotFound(_)), Some(checkpoint)) if !progress.started => checkpoint,
            (done, _) => return done.map_err(LevelFailure::stop),
        };
        self.path.restore(stuck);
        self.path.methods.full_pads += 1;
        self.progress = progress;
        self.fall_back_to_full_pads(model).map_err(EarlyTermination::fault)?;
        self.attempt_level(model, target).map_err(LevelFailure::stop)
    }

    /// Attempts [`GraspSolver::advance`] once.
    fn attempt_level(&mut self, model: &Model, target: StepLoad) -> std::result::Result<AdvanceCost, LevelFailure> {
        let StepLoad { level, push } = target;
        let before = self.path.state.clone();
        let load = if model.force_driven { Load::Force } else { Load::Travel };
        let mut done = AdvanceCost::default();
        let begins = !std::mem::replace(&mut self.progress.started, true);
        // At the first level the object is not held yet and may roll to its equilibrium.
        self.path.largest_drift = model.max_drift.filter(|_| !begins);
        if begins {
            done.add(self.make_contact(model, level.min(model.release))?);
        }
        self.path.grasp_limits = model.dropped_after.map(|after| self.grasp_limits(model, after));
        if self.path.newton.object_fixed && level >= model.release {
            done.add(self.apply_load(model, load, model.release)?);
            done.add(self.release_object(model)?);
        }
        let at = if push > 0.0 {
            done.add(self.apply_push(model, level, push)?);
            describe_level(Load::Push, push)
        } else {
            done.add(self.apply_load(model, load, level)?);
            describe_level(load, level)
        };
        if !self.has_no_near_inversion() {
            let reason = format!("{at}: an element of a condensed pad is inverted");
            return Err(LevelFailure::CondensedPads(EarlyTermination::fault(reason)));
        }
        let slides = push > 0.0 && self.slipping_fraction(model) > SLIDING_FRACTION;
        let sliding = || slides.then(|| "the object slips: the whole contact is at the Coulomb limit".to_string());
        if let Some(reason) = self.lost_contact_reason(model).or_else(sliding) {
            self.path.state = before;
            return Err(LevelFailure::Final(EarlyTermination {
                dropped: model.free,
                reason: format!("{at}: {reason}"),
            }));
        }
        self.path.halve_spent_iterations();
        Ok(done)
    }

    /// Returns the region that the object may not leave.
    fn grasp_limits(&self, model: &Model, after: DropLimits) -> GraspLimits {
        let Pose { position, rotation } = self.progress.start;
        let faces = model.fingers.iter().map(|finger| finger.placement.origin);
        let center = faces.sum::<DVec3>() / model.fingers.len().max(1) as f64;
        GraspLimits { position, rotation, center, distance: after.distance, angle: after.angle }
    }

    /// Makes contact at a force of at most `most` (N per finger), with the object held fixed.
    fn make_contact(&mut self, model: &Model, most: f64) -> std::result::Result<AdvanceCost, LevelFailure> {
        let stuck = |reason| LevelFailure::CondensedPads(EarlyTermination::fault(reason));
        if !model.force_driven {
            return self.condense(model).map(|()| AdvanceCost::default()).map_err(stuck);
        }
        let first = model.contact_force().min(most);
        self.apply_weight_fraction(0.0);
        self.path.tolerance = self.tolerance(model, first);
        self.progress.start = self.path.state.pose();
        self.approach_object(model).map_err(|reason| LevelFailure::Final(EarlyTermination::fault(reason)))?;
        self.condense(model).map_err(stuck)?;
        self.path.newton.object_fixed = model.free;
        let made = self.path.establish_contact(first);
        made.map_err(|f| self.level_failure(model, &format!("establishing contact at {first:.4} N per finger"), f))
    }

    /// Releases the object; its weight, if any, passes step by step from its support to the fingers.
    fn release_object(&mut self, model: &Model) -> std::result::Result<AdvanceCost, LevelFailure> {
        self.path.newton.object_fixed = false;
        let heavy = model.gravity.is_some();
        let largest_drift = self.path.largest_drift;
        self.path.largest_drift = heavy.then_some(DROP_DISTANCE * model.offset);
        let steps = if heavy { WEIGHT_STEPS } else { 1 };
        let mut done = AdvanceCost::default();
        for k in 1..=steps {
            self.apply_weight_fraction(f64::from(k) / f64::from(steps));
            // The path under the force does not predict the path under the weight.
            self.path.previous = None;
            let more = self.advance_path(model, Load::Force, self.path.level);
            let letting_go = format!("releasing the object {}", describe_level(Load::Force, self.path.level));
            done.add(more.map_err(|f| self.level_failure(model, &letting_go, f))?);
        }
        self.path.largest_drift = largest_drift;
        Ok(done)
    }

    /// Raises the push to the fraction `part` at the force `force` (N per finger).
    fn apply_push(&mut self, model: &Model, force: f64, part: f64) -> std::result::Result<AdvanceCost, LevelFailure> {
        if !std::mem::replace(&mut self.progress.pushing, true) {
            self.path.begin_load(FIRST_FRACTION);
            self.condensed.iter_mut().for_each(|pads| pads.begin_load());
        }
        self.path.tolerance = self.tolerance(model, force);
        self.advance_path(model, Load::Push, part).map_err(|failure| {
            let (slipping, at) = (self.slipping_fraction(model), describe_level(Load::Push, part));
            if failure.is_out_of_effort() || slipping < SLIPPING_FRACTION {
                return self.level_failure(model, &at, failure);
            }
            let [slipping, held] = [slipping, self.path.level].map(|part| 100.0 * part);
            let reason = format!(
                "{at}: the object slips; at {held:.1} % of the push, {slipping:.0} % of the contact is at the Coulomb \
                 limit"
            );
            LevelFailure::Final(EarlyTermination { dropped: true, reason })
        })
    }

    /// Returns the fraction of the contact pressure that acts where friction is at its limit.
    fn slipping_fraction(&self, model: &Model) -> f64 {
        let edges = (0..model.fingers.len()).flat_map(|i| self.path.newton.edge_readings(&self.path.state, i));
        let sums = edges.fold((0.0, 0.0), |(slips, all), edge| {
            let pressure = edge.state.pressure;
            (if edge.state.slips { slips + pressure } else { slips }, all + pressure)
        });
        sums.0 / f64::max(sums.1, f64::MIN_POSITIVE)
    }

    fn apply_load(&mut self, model: &Model, load: Load, level: f64) -> std::result::Result<AdvanceCost, LevelFailure> {
        self.path.tolerance = self.tolerance(model, level);
        self.advance_path(model, load, level).map_err(|f| self.level_failure(model, &describe_level(load, level), f))
    }

    /// Advances the path with the current pads, condensed or full.
    fn advance_path(&mut self, model: &Model, load: Load, level: f64) -> std::result::Result<AdvanceCost, Failure> {
        match &mut self.condensed {
            Some(pads) => self.path.advance(load, level, &mut pads.discretisation(model)),
            None => self.path.advance(load, level, &mut FullPads),
        }
    }

    fn level_failure(&self, model: &Model, at: &str, failure: Failure) -> LevelFailure {
        let dropped = model.free && failure.leaves_the_grasp();
        let stop = EarlyTermination { dropped, reason: self.failure_message(model, at, failure) };
        match failure {
            Failure::Corrections(_) | Failure::Singular => LevelFailure::CondensedPads(stop),
            Failure::Iterations(_) | Failure::LineSearch(_) | Failure::Unsettled | Failure::PathError(_) => {
                LevelFailure::NotFound(stop)
            }
            Failure::LostContact | Failure::MovedTooFar => LevelFailure::Final(stop),
            Failure::Effort(_) | Failure::Time(_) | Failure::Interrupted => LevelFailure::Final(stop),
        }
    }
}

fn describe_level(load: Load, level: f64) -> String {
    match load {
        Load::Force => format!("at {level:.4} N per finger"),
        Load::Travel => format!("at {:.4} mm after contact", level * 1e3),
        Load::Push => format!("at {:.1} % of the push", level * 100.0),
    }
}
