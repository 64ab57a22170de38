//! Range of a training set. Outside it the network gives no answer, or one of unknown error.

use super::GraspFeatures;
use super::pad_range::PadRange;
use crate::features::normalise::MOST;
use base::error::{Error, Result};
use model::Model;
use record::PadTopology;
use serde::{Deserialize, Serialize};

/// Range of the training set.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrainedRange {
    /// Dimensions of the pads.
    pub pads: PadRange,
    /// Law of the gel.
    pub material: String,
    /// Smallest and largest Poisson's ratio.
    pub poisson: [f64; 2],
    /// Smallest and largest friction.
    pub friction: [f64; 2],
    /// Smallest and largest force per finger over `E thickness^2`.
    pub force: [f64; 2],
    /// Largest weight of the object over `E thickness^2`.
    pub weight: f64,
    /// Largest force of a push on the object over `E thickness^2`, and largest torque over `E thickness^3`.
    #[serde(default, skip_serializing_if = "unpushed")]
    pub push: [f64; 2],
    /// True if the object was free.
    pub free: bool,
    /// Number of fingers.
    pub fingers: usize,
    /// Further kinds of grasps: whether the object was free, and the number of fingers.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub others: Vec<(bool, usize)>,
}

fn unpushed(push: &[f64; 2]) -> bool {
    *push == [0.0; 2]
}

/// Tolerance for rounding at the ends of a range.
const SLACK: f64 = 1e-6;
/// Tolerance of the dimensions of a pad, over its thickness: facets of a coarse mesh lie inside the curves they stand for.
const PAD_SLACK: f64 = 0.02;

/// Returns true if `value` is within a range, up to rounding.
fn within(value: f64, [low, high]: [f64; 2]) -> bool {
    (low * (1.0 - SLACK)..=high * (1.0 + SLACK)).contains(&value)
}

impl TrainedRange {
    /// Returns the range of one grasp with these forces per finger, N.
    pub fn of(model: &Model, features: &GraspFeatures, forces: &[f64]) -> Self {
        let unit = features.unit_force();
        let moduli = model.material.moduli();
        let (low, high) = forces.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), f| (l.min(f / unit), h.max(f / unit)));
        Self {
            pads: PadRange::of(&model.fingers[0].topology),
            material: model.material.name().into(),
            poisson: [moduli.poisson; 2],
            friction: [model.friction; 2],
            force: [low, high],
            weight: weight(model, unit),
            push: push(model, unit, features.graph.thickness),
            free: model.free,
            fingers: model.fingers.len(),
            others: Vec::new(),
        }
    }

    /// Extends the range by `other`.
    ///
    /// # Errors
    /// Fails for another law: a network is trained for one.
    pub fn extend(&mut self, other: &Self) -> Result<()> {
        if self.material != other.material {
            return Err(Error::Start("the data set mixes gel laws; train one model for each".into()));
        }
        for kind in other.kinds() {
            if !self.kinds().contains(&kind) {
                self.others.push(kind);
                self.others.sort_unstable();
            }
        }
        self.pads = self.pads.join(other.pads);
        let join = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        self.poisson = join(self.poisson, other.poisson);
        self.friction = join(self.friction, other.friction);
        self.force = join(self.force, other.force);
        self.weight = self.weight.max(other.weight);
        self.push = [0, 1].map(|k| self.push[k].max(other.push[k]));
        Ok(())
    }

    /// Returns the kinds of grasps: whether the object is free, and the number of fingers.
    fn kinds(&self) -> Vec<(bool, usize)> {
        std::iter::once((self.free, self.fingers)).chain(self.others.iter().copied()).collect()
    }

    /// Checks that the dimensions of a pad are within the range.
    ///
    /// # Errors
    /// Fails for another pad; the message gives the dimension and the range.
    pub fn check_pad(&self, pad: &PadTopology) -> Result<()> {
        self.pad_outside(pad).map_or(Ok(()), refuse)
    }

    /// Returns a description of what lies outside the range of pads, if anything does.
    fn pad_outside(&self, pad: &PadTopology) -> Option<String> {
        let (name, value, [low, high]) = self.pads.first_outside(&PadRange::of(pad), PAD_SLACK)?;
        Some(format!(
            "the {name} of its pads is {value:.3} times their thickness, the training range is {low:.3} to {high:.3}"
        ))
    }

    /// Checks that a grasp of `model` is of a supported kind and, unless it may `extrapolate`, within the range under all of its forces. Takes almost no time.
    ///
    /// # Errors
    /// Fails if something is outside; the message states what, by how much, and what to do.
    pub fn check_model(&self, model: &Model, extrapolate: bool) -> Result<()> {
        self.check_model_some_force(model, extrapolate)?;
        self.forces_outside(model).filter(|_| !extrapolate).map_or(Ok(()), untrained)
    }

    /// Checks like [`TrainedRange::check_model`], except that one force within the range is enough.
    ///
    /// # Errors
    /// Fails if all forces, or something else, are outside; the message states what, by how much, and what to do.
    pub fn check_model_some_force(&self, model: &Model, extrapolate: bool) -> Result<()> {
        if !model.has_equal_pads() {
            return refuse("its two pads differ, the network supports only identical pads".into());
        }
        if model.dynamics.is_some() {
            return refuse("its loading is dynamic, the network supports only quasi-static squeezes".into());
        }
        if !model.force_driven {
            return refuse("its loading is a press to a travel, the network supports only squeezes to a force".into());
        }
        let kind = |(free, n): (bool, usize)| {
            format!("a {} object between {n} finger(s)", if free { "free" } else { "fixed" })
        };
        let own = (model.free, model.fingers.len());
        if !self.kinds().contains(&own) {
            let known: Vec<String> = self.kinds().into_iter().map(kind).collect();
            return refuse(format!("{}, the training data have {}", kind(own), known.join(" and ")));
        }
        if model.material.name() != self.material {
            return refuse(format!(
                "its gel is {}, that of the training data {}",
                model.material.name(),
                self.material
            ));
        }
        let none = || self.answerable_frames(model, false).is_empty().then(|| self.forces_outside(model)).flatten();
        let outside = self.outside(model).or_else(none);
        outside.filter(|_| !extrapolate).map_or(Ok(()), untrained)
    }

    /// Returns true if a force over `E thickness^2` is within the range.
    pub fn contains_force(&self, force: f64) -> bool {
        within(force, self.force)
    }

    /// Returns the indices of the frames of `model` that the network answers: those with forces within the range, or
    /// all if it may `extrapolate`.
    pub fn answerable_frames(&self, model: &Model, extrapolate: bool) -> Vec<usize> {
        let unit = unit(model);
        (0..model.levels.len()).filter(|k| extrapolate || self.contains_force(model.levels[*k] / unit)).collect()
    }

    /// Returns a description of the frames of `model` with forces outside the range; None if there are none.
    pub fn forces_outside(&self, model: &Model) -> Option<String> {
        let (unit, inside) = (unit(model), self.answerable_frames(model, false));
        let outside: Vec<usize> = (0..model.levels.len()).filter(|k| !inside.contains(k)).collect();
        let rows = outside.chunk_by(|a, b| a + 1 == *b).map(|row| match (row[0], row[row.len() - 1]) {
            (first, last) if first == last => format!("frame {first} ({:.4} N per finger)", model.levels[first]),
            (first, last) => {
                let [low, high] = [first, last].map(|k| model.levels[k]);
                format!("frames {first} to {last} ({low:.4} to {high:.4} N per finger)")
            }
        });
        let rows: Vec<String> = rows.collect();
        let [low, high] = self.force.map(|f| f * unit);
        let verb = if outside.len() == 1 { "lies" } else { "lie" };
        (!rows.is_empty())
            .then(|| format!("{} {verb} outside the training range of {low:.4} to {high:.4} N", rows.join(" and ")))
    }

    /// Returns a description of the first quantity other than the force that is outside the range.
    pub fn outside(&self, model: &Model) -> Option<String> {
        let finger = model.fingers.first()?;
        let (moduli, t, unit) = (model.material.moduli(), finger.topology.thickness(), unit(model));
        let mut all: Vec<String> = self.pad_outside(&finger.topology).into_iter().collect();
        let mut check = |value: f64, range: [f64; 2], what: &dyn Fn() -> String| {
            if !within(value, range) {
                all.push(what());
            }
        };
        let [a, b] = self.poisson;
        check(moduli.poisson, self.poisson, &|| {
            format!("nu of its gel is {}, the training range is {a} to {b}", moduli.poisson)
        });
        let ([a, b], own) = (self.friction, model.friction);
        check(own, self.friction, &|| format!("friction is {own}, the training range is {a} to {b}"));
        let (own, most) = (weight(model, unit), self.weight);
        check(own, [0.0, most], &|| {
            format!("the object weighs {:.3} N, the training range ends at {:.3} N", own * unit, most * unit)
        });
        for ((own, most), (what, of, unit)) in
            push(model, unit, t).into_iter().zip(self.push).zip([("pushed", "N", unit), ("twisted", "N m", unit * t)])
        {
            check(own, [0.0, most], &|| {
                format!(
                    "the object is {what} with {:.4} {of}, the training range ends at {:.4} {of}",
                    own * unit,
                    most * unit
                )
            });
        }
        all.into_iter().next()
    }

    /// Checks that the values are valid. The error names the field and states what is wrong.
    pub(crate) fn check(&self) -> std::result::Result<(), String> {
        for (name, [low, high]) in [("poisson", self.poisson), ("friction", self.friction), ("force", self.force)] {
            if !(0.0 <= low && low <= high && high <= MOST) {
                return Err(format!(
                    "`range.{name}` goes from {low} to {high}; allowed: from 0, ascending, to {MOST:e}"
                ));
            }
        }
        if !(0.0..=MOST).contains(&self.weight) {
            return Err(format!("`range.weight` is {}; allowed: 0 to {MOST:e}", self.weight));
        }
        let pads = self.pads.spans();
        match pads.into_iter().find(|(_, [low, high])| !(0.0 <= *low && low <= high && *high <= MOST)) {
            Some((name, [low, high])) => {
                Err(format!("`range.pads`: {name} from {low} to {high}; allowed: from 0, ascending, to {MOST:e}"))
            }
            None => Ok(()),
        }
    }
}

/// Returns the error about a scene that the network cannot answer.
fn refuse(what: String) -> Result<()> {
    Err(Error::Start(format!(
        "the network was not trained for this scene: {what}; use stepper: Fem(), or train a network on a suitable data \
         set"
    )))
}

/// Returns the error about a quantity outside the range, which can still be answered by extrapolation.
fn untrained(what: String) -> Result<()> {
    Err(Error::Start(format!(
        "the network was not trained for this scene: {what}; use stepper: Fem(), train a network on a suitable data \
         set, or allow predictions of unknown error: extrapolate: true, --extrapolate"
    )))
}

/// Returns the unit of force of the network, N; 1 without fingers.
fn unit(model: &Model) -> f64 {
    let thickness = model.fingers.first().map(|finger| finger.topology.thickness());
    thickness.map_or(1.0, |t| model.material.moduli().young * t.powi(2))
}

/// Returns force and torque of the full push in units of the network.
fn push(model: &Model, unit: f64, thickness: f64) -> [f64; 2] {
    let whole = model.push.as_ref().map(|push| [push.force.length() / unit, push.torque.length() / (unit * thickness)]);
    whole.unwrap_or_default()
}

fn weight(model: &Model, unit: f64) -> f64 {
    model.gravity.filter(|_| model.free).map_or(0.0, |g| g.length() * model.mass / unit)
}
