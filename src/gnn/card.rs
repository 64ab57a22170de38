//! The folder of a trained model: `weights.safetensors`, and `card.ron`, which says what the weights are and what they
//! were trained on.

use super::features::{Features, VERSION};
use super::network::Normalisers;
use super::spec::Spec;
use crate::error::{Error, Result};
use crate::model::Model;
use crate::record::files::write_atomic;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Name of the card in the folder of a model.
pub const CARD: &str = "card.ron";
/// Name of the weights.
pub const WEIGHTS: &str = "weights.safetensors";

/// What a trained model is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Card {
    /// Version of tactus that trained it.
    pub tactus: String,
    /// [`VERSION`] of the features that it reads.
    #[serde(default)]
    pub features: u32,
    /// Network and training.
    pub spec: Spec,
    /// Hash of the plan of the data set.
    pub data: String,
    /// Split that it was trained on.
    pub split: String,
    /// Training grasps.
    pub grasps: usize,
    /// Numbers in the weights.
    pub parameters: usize,
    /// Units of what it predicts.
    pub units: String,
    /// Loss on the validation grasps.
    pub validation_loss: f64,
    /// Epochs that the weights have seen.
    pub epochs: usize,
    /// Statistics of the training set.
    pub normalisers: Normalisers,
    /// What it was trained on, and may be used for.
    pub range: TrainedRange,
}

/// What the training set holds. Outside of it a network is not asked.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrainedRange {
    /// Hash of the pad's mesh.
    pub pad: String,
    /// Law of the gel.
    pub material: String,
    /// Poisson's ratio, from and to.
    pub poisson: [f64; 2],
    /// Friction, from and to.
    pub friction: [f64; 2],
    /// Force per finger over `E thickness^2`, from and to.
    pub force: [f64; 2],
    /// Weight of the object over `E thickness^2`, at most.
    pub weight: f64,
    /// Whether the object was free.
    pub free: bool,
    /// Number of fingers.
    pub fingers: usize,
}

/// Room for rounding at the ends of a range.
const SLACK: f64 = 1e-6;

impl TrainedRange {
    /// That of one grasp with these forces per finger, N.
    pub fn of(model: &Model, features: &Features, forces: &[f64]) -> Self {
        let unit = features.unit_force();
        let moduli = model.material.moduli();
        let (low, high) = forces.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), f| (l.min(f / unit), h.max(f / unit)));
        Self {
            pad: features.graph.hash.clone(),
            material: model.material.name().into(),
            poisson: [moduli.poisson; 2],
            friction: [model.law.friction; 2],
            force: [low, high],
            weight: weight(model, unit),
            free: model.free,
            fingers: model.fingers.len(),
        }
    }

    /// Takes in `other`.
    ///
    /// # Errors
    /// Another pad, law, number of fingers or kind of object: one model is for one of each.
    pub fn extend(&mut self, other: &Self) -> Result<()> {
        let kind = |r: &Self| (r.pad.clone(), r.material.clone(), r.free, r.fingers);
        if kind(self) != kind(other) {
            let message = "the data set mixes pads, gel laws, fixed and free objects or numbers of fingers; train one model for each";
            return Err(Error::Start(message.into()));
        }
        let join = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        self.poisson = join(self.poisson, other.poisson);
        self.friction = join(self.friction, other.friction);
        self.force = join(self.force, other.force);
        self.weight = self.weight.max(other.weight);
        Ok(())
    }

    /// Whether a grasp of `model` may be asked about, at forces `levels` (N per finger).
    ///
    /// # Errors
    /// What lies outside, by how much, and what to do.
    pub fn admits(&self, model: &Model, pad: &str, unit_force: f64, levels: &[f64]) -> Result<()> {
        let refuse = |what: String| {
            Err(Error::Start(format!(
                "the network was not trained for this scene: {what}; use stepper: Fem(), or train on such a data set"
            )))
        };
        let moduli = model.material.moduli();
        let outside = |v: f64, [low, high]: [f64; 2]| v < low - SLACK * low.abs() || v > high + SLACK * high.abs();
        if !model.force_driven {
            return refuse("it presses by travel, the network squeezes by force".into());
        }
        if pad != self.pad {
            return refuse("its pads are another sensor or another mesh".into());
        }
        if model.material.name() != self.material || outside(moduli.poisson, self.poisson) {
            let (own, [a, b]) = (model.material.name(), self.poisson);
            return refuse(format!(
                "its gel is {own} with nu = {}, trained was {} with nu {a} to {b}",
                moduli.poisson, self.material
            ));
        }
        if outside(model.law.friction, self.friction) {
            let [a, b] = self.friction;
            return refuse(format!("friction is {}, trained was {a} to {b}", model.law.friction));
        }
        if model.free != self.free || model.fingers.len() != self.fingers {
            let kind = |free: bool, n: usize| {
                format!("a {} object between {n} finger(s)", if free { "free" } else { "fixed" })
            };
            return refuse(format!(
                "{}, trained was {}",
                kind(model.free, model.fingers.len()),
                kind(self.free, self.fingers)
            ));
        }
        let weight = weight(model, unit_force);
        if weight > self.weight * (1.0 + SLACK) {
            let most = self.weight * unit_force;
            return refuse(format!("the object weighs {:.3} N, trained was up to {most:.3} N", weight * unit_force));
        }
        let [low, high] = self.force.map(|f| f * unit_force);
        match levels.iter().find(|l| outside(**l, [low, high])) {
            Some(level) => refuse(format!("{level:.4} N per finger is outside the trained {low:.4} to {high:.4} N")),
            None => Ok(()),
        }
    }
}

fn weight(model: &Model, unit: f64) -> f64 {
    model.gravity.filter(|_| model.free).map_or(0.0, |g| g.length() * model.mass / unit)
}

impl Card {
    /// Reads the card of a model's folder.
    ///
    /// # Errors
    /// No model there, one of another make, or one that reads other features.
    pub fn read(dir: &Path) -> Result<Self> {
        let path = dir.join(CARD);
        let text = std::fs::read_to_string(&path).map_err(|e| {
            Error::file(
                &path,
                format!(
                    "cannot be read: {e}; a model is made by `tactus train DATASET --model M.ron -o {}`",
                    dir.display()
                ),
            )
        })?;
        let card: Self = ron::from_str(&text).map_err(|e| Error::file(&path, format!("is no card of a model: {e}")))?;
        if card.features != VERSION {
            let message = format!(
                "its network reads features of version {}, this tactus makes version {VERSION}; train it again",
                card.features
            );
            return Err(Error::file(&path, message));
        }
        Ok(card)
    }

    /// Writes it, whole or not at all.
    pub fn write(&self, dir: &Path) -> Result<()> {
        let path = dir.join(CARD);
        let text = ron::ser::to_string_pretty(self, ron::ser::PrettyConfig::new().compact_arrays(true))
            .map_err(|e| Error::file(&path, e.to_string()))?;
        write_atomic(&path, (text + "\n").as_bytes())
    }
}
