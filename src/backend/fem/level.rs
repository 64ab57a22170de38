//! Load levels of a grasp: first contact if needed, the load, and the fall-back from condensed to full pads.

use super::solver::GraspSolver;
use base::scales::DROP_DISTANCE;
use geometry::Pose;
use glam::DVec3;
use mech::newton::Failure;
use mech::newton::effort::{most_iterations, most_iterations_of_agent_step};
use mech::path::continuation::FullPads;
use mech::path::grasp_place::GraspLimits;
use mech::path::{Advanced, Load};
use model::push::FIRST_FRACTION;
use model::{DropLimits, Model};
use world::schedule::{StepLoad, Stop};

/// Number of steps in which the weight of an object passes from its support to the fingers.
const WEIGHT_STEPS: u32 = 4;

/// Fraction of the contact pressure at the Coulomb limit from which on an object without equilibrium under a push
/// slips.
const SLIPS: f64 = 0.7;

/// Fraction of the contact pressure at the Coulomb limit above which the object slides even in equilibrium: such an
/// equilibrium exists only because a dead push has less moment the further the object has rotated.
const SLIDES: f64 = 0.99;

/// Reason why a level was not reached.
enum Refusal {
    /// No equilibrium exists, or the effort is exhausted.
    Final(Stop),
    /// No equilibrium was found, though one may exist.
    Unfound(Stop),
    /// Condensed pads cannot reach the level.
    Condensed(Stop),
}

impl Refusal {
    fn stop(self) -> Stop {
        let (Refusal::Final(stop) | Refusal::Unfound(stop) | Refusal::Condensed(stop)) = self;
        stop
    }
}

impl GraspSolver {
    /// Brings the state to `target`. The first call starts from first contact.
    ///
    /// # Errors
    /// Returns the cause of the stop, for the record; the state is then the last accepted one.
    pub fn advance(&mut self, model: &Model, target: StepLoad) -> std::result::Result<Advanced, Stop> {
        self.steps += 1;
        let (each, steps) = (self.settings().max_iterations.get() as u32, model.levels.len().max(self.steps));
        let agent = model.needs.task && self.progress.started;
        let usual = if agent { most_iterations_of_agent_step(each) } else { most_iterations(each, steps) };
        let most = self.settings().effort.map_or(usual, |most| most.get() as u64);
        let newton = &mut self.path.newton;
        newton.effort.from = if agent { newton.profile.iterations } else { 0 };
        newton.effort.iterations = most;
        let progress = self.progress;
        let checkpoint = self.condensed.is_some().then(|| self.path.checkpoint());
        let stuck = match (self.raise(model, target), checkpoint) {
            (Err(Refusal::Condensed(_)), Some(checkpoint)) => checkpoint,
            // An object that rotates far before it is held may leave the patches of the condensed pads.
            (Err(Refusal::Unfound(_)), Some(checkpoint)) if !progress.started => checkpoint,
            (done, _) => return done.map_err(Refusal::stop),
        };
        self.path.restore(stuck);
        self.path.methods.whole += 1;
        self.progress = progress;
        self.release(model).map_err(Stop::fault)?;
        self.raise(model, target).map_err(Refusal::stop)
    }

    /// Attempts [`GraspSolver::advance`] once.
    fn raise(&mut self, model: &Model, target: StepLoad) -> std::result::Result<Advanced, Refusal> {
        let StepLoad { level, push } = target;
        let before = self.path.state.clone();
        let load = if model.force_driven { Load::Force } else { Load::Travel };
        let mut done = Advanced::default();
        let begins = !std::mem::replace(&mut self.progress.started, true);
        // At the first level the object is not held yet and may roll to its equilibrium.
        self.path.largest_drift = model.max_drift.filter(|_| !begins);
        if begins {
            done.add(self.begin(model, level.min(model.release))?);
        }
        self.path.place = model.dropped_after.map(|after| self.place(model, after));
        if self.path.newton.object_fixed && level >= model.release {
            done.add(self.load(model, load, model.release)?);
            done.add(self.release_object(model)?);
        }
        let at = if push > 0.0 {
            done.add(self.push(model, level, push)?);
            at(Load::Push, push)
        } else {
            done.add(self.load(model, load, level)?);
            at(load, level)
        };
        if !self.has_no_near_inversion() {
            let reason = format!("{at}: an element of a condensed pad is inverted");
            return Err(Refusal::Condensed(Stop::fault(reason)));
        }
        let slides = push > 0.0 && self.slipping(model) > SLIDES;
        let sliding = || slides.then(|| "the object slips: the whole contact is at the Coulomb limit".to_string());
        if let Some(reason) = self.lost_grip(model).or_else(sliding) {
            self.path.state = before;
            return Err(Refusal::Final(Stop { dropped: model.free, reason: format!("{at}: {reason}") }));
        }
        self.path.recover();
        Ok(done)
    }

    /// Returns the region that the object may not leave.
    fn place(&self, model: &Model, after: DropLimits) -> GraspLimits {
        let Pose { position, rotation } = self.progress.start;
        let faces = model.fingers.iter().map(|finger| finger.placement.origin);
        let center = faces.sum::<DVec3>() / model.fingers.len().max(1) as f64;
        GraspLimits { position, rotation, center, distance: after.distance, angle: after.angle }
    }

    /// Makes contact at a force of at most `most` (N per finger), with the object held fixed.
    fn begin(&mut self, model: &Model, most: f64) -> std::result::Result<Advanced, Refusal> {
        let stuck = |reason| Refusal::Condensed(Stop::fault(reason));
        if !model.force_driven {
            return self.condense(model).map(|()| Advanced::default()).map_err(stuck);
        }
        let first = model.contact_force().min(most);
        self.hand_over(0.0);
        self.path.tolerance = self.tolerance(model, first);
        self.progress.start = Pose { position: self.path.state.position, rotation: self.path.state.rotation };
        self.back_off(model).map_err(|reason| Refusal::Final(Stop::fault(reason)))?;
        self.condense(model).map_err(stuck)?;
        self.path.newton.object_fixed = model.free;
        let made = self.path.establish(first);
        made.map_err(|f| self.refuse(model, &format!("establishing contact at {first:.4} N per finger"), f))
    }

    /// Releases the object; its weight, if any, passes step by step from its support to the fingers.
    fn release_object(&mut self, model: &Model) -> std::result::Result<Advanced, Refusal> {
        self.path.newton.object_fixed = false;
        let heavy = model.gravity.is_some();
        let largest_drift = self.path.largest_drift;
        self.path.largest_drift = heavy.then_some(DROP_DISTANCE * model.offset);
        let steps = if heavy { WEIGHT_STEPS } else { 1 };
        let mut done = Advanced::default();
        for k in 1..=steps {
            self.hand_over(f64::from(k) / f64::from(steps));
            // The path under the force does not predict the path under the weight.
            self.path.history = None;
            let more = self.follow(model, Load::Force, self.path.level);
            let letting_go = format!("releasing the object {}", at(Load::Force, self.path.level));
            done.add(more.map_err(|f| self.refuse(model, &letting_go, f))?);
        }
        self.path.largest_drift = largest_drift;
        Ok(done)
    }

    /// Raises the push to the fraction `part` at the force `force` (N per finger).
    fn push(&mut self, model: &Model, force: f64, part: f64) -> std::result::Result<Advanced, Refusal> {
        if !std::mem::replace(&mut self.progress.pushing, true) {
            self.path.begin_load(FIRST_FRACTION);
            self.condensed.iter_mut().for_each(|pads| pads.begin_load());
        }
        self.path.tolerance = self.tolerance(model, force);
        self.follow(model, Load::Push, part).map_err(|failure| {
            let (slipping, at) = (self.slipping(model), at(Load::Push, part));
            if failure.is_out_of_effort() || slipping < SLIPS {
                return self.refuse(model, &at, failure);
            }
            let [slipping, held] = [slipping, self.path.level].map(|part| 100.0 * part);
            let reason = format!(
                "{at}: the object slips; at {held:.1} % of the push, {slipping:.0} % of the contact is at the Coulomb \
                 limit"
            );
            Refusal::Final(Stop { dropped: true, reason })
        })
    }

    /// Returns the fraction of the contact pressure that acts where friction is at its limit.
    fn slipping(&self, model: &Model) -> f64 {
        let edges = (0..model.fingers.len()).flat_map(|i| self.path.newton.edge_readings(&self.path.state, i));
        let sums = edges.fold((0.0, 0.0), |(slips, all), edge| {
            let pressure = edge.state.pressure;
            (if edge.state.slips { slips + pressure } else { slips }, all + pressure)
        });
        sums.0 / f64::max(sums.1, f64::MIN_POSITIVE)
    }

    fn load(&mut self, model: &Model, load: Load, level: f64) -> std::result::Result<Advanced, Refusal> {
        self.path.tolerance = self.tolerance(model, level);
        self.follow(model, load, level).map_err(|f| self.refuse(model, &at(load, level), f))
    }

    /// Advances the path with the current pads, condensed or full.
    fn follow(&mut self, model: &Model, load: Load, level: f64) -> std::result::Result<Advanced, Failure> {
        match &mut self.condensed {
            Some(pads) => self.path.advance(load, level, &mut pads.of(model)),
            None => self.path.advance(load, level, &mut FullPads),
        }
    }

    fn refuse(&self, model: &Model, at: &str, failure: Failure) -> Refusal {
        let dropped = model.free && failure.leaves_the_grasp();
        let stop = Stop { dropped, reason: self.explain(model, at, failure) };
        match failure {
            Failure::Corrections(_) | Failure::Singular => Refusal::Condensed(stop),
            Failure::Iterations(_) | Failure::LineSearch(_) | Failure::Unsettled | Failure::Bent(_) => {
                Refusal::Unfound(stop)
            }
            Failure::Lost | Failure::Astray => Refusal::Final(stop),
            Failure::Effort(_) | Failure::Time(_) | Failure::Interrupted => Refusal::Final(stop),
        }
    }
}

fn at(load: Load, level: f64) -> String {
    match load {
        Load::Force => format!("at {level:.4} N per finger"),
        Load::Travel => format!("at {:.4} mm after contact", level * 1e3),
        Load::Push => format!("at {:.1} % of the push", level * 100.0),
    }
}
