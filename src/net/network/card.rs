//! The folder of a trained model: `weights.safetensors`, and `card.ron`, which says what the weights are and what they
//! were trained on.

use super::Normalisers;
use super::shipped;
use super::spec::{NetworkSpec, Spec};
use crate::error::{Error, Result};
use crate::files::atomic::write_durable;
use crate::net::features::VERSION;
use crate::net::features::normalise::MOST;
use crate::net::features::range::TrainedRange;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
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
    /// BLAKE3 of the numbers above and of the weights; empty in models of earlier times.
    #[serde(default)]
    pub checksum: String,
}

/// A model as it was read.
#[derive(Debug)]
pub struct Trained {
    /// What it is.
    pub card: Card,
    /// Its weights, safetensors.
    pub weights: Cow<'static, [u8]>,
}

impl Trained {
    /// The model in the folder `model`, or the one that ships under this name.
    ///
    /// # Errors
    /// No model there, one of another make, one that reads other features, or one that is damaged.
    pub fn read(model: &Path) -> Result<Self> {
        let path = model.join(CARD);
        let (text, weights) = match shipped::named(model) {
            Some(shipped) => (shipped.card.into(), shipped.weights.into()),
            None => {
                let text = std::fs::read_to_string(&path).map_err(|e| missing(model, &path, &e))?;
                let path = model.join(WEIGHTS);
                let weights = std::fs::read(&path).map_err(|e| Error::file(&path, format!("cannot be read: {e}")))?;
                (Cow::from(text), Cow::from(weights))
            }
        };
        let card: Card = ron::from_str(&text).map_err(|e| Error::file(&path, format!("is no card of a model: {e}")))?;
        if card.features != VERSION {
            let message = format!(
                "its network reads features of version {}, this tactus makes version {VERSION}; train it again",
                card.features
            );
            return Err(Error::file(&path, message));
        }
        card.check()
            .map_err(|what| Error::file(&path, format!("{what}; take the model from a copy, or train it again")))?;
        if !card.checksum.is_empty() && card.sum(&weights)? != card.checksum {
            let message = "this card or the weights beside it were changed or damaged since the training; take both from a copy, \
                           or train again";
            return Err(Error::file(&path, message));
        }
        Ok(Self { card, weights })
    }
}

fn missing(model: &Path, path: &Path, e: &std::io::Error) -> Error {
    let message = format!(
        "cannot be read: {e}; a model is made by `tactus train DATASET --model M.ron -o {}`, and these ship: {}",
        model.display(),
        shipped::names()
    );
    Error::file(path, message)
}

impl Card {
    /// Whether all numbers are such as training gives; what is wrong, with the field.
    fn check(&self) -> std::result::Result<(), String> {
        self.normalisers.check(matches!(self.spec.network, NetworkSpec::Paper(_)))?;
        self.range.check()?;
        match self.validation_loss {
            loss if (0.0..=MOST).contains(&loss) => Ok(()),
            loss => Err(format!("`validation_loss` is {loss}; allowed: 0 to {MOST:e}")),
        }
    }

    /// What [`Self::checksum`] is with these weights.
    fn sum(&self, weights: &[u8]) -> Result<String> {
        let own = Self { checksum: String::new(), ..self.clone() };
        let mut hasher = blake3::Hasher::new();
        hasher.update(
            ron::to_string(&own).map_err(|e| Error::Solver(format!("the card cannot be written: {e}")))?.as_bytes(),
        );
        Ok(hasher.update(weights).finalize().to_hex().to_string())
    }

    /// Gives it the checksum of `weights` and writes both, the card last.
    ///
    /// # Errors
    /// What cannot be written.
    pub fn write(&mut self, dir: &Path, weights: &[u8]) -> Result<()> {
        self.checksum = self.sum(weights)?;
        write_durable(&dir.join(WEIGHTS), weights)?;
        let path = dir.join(CARD);
        let text = ron::ser::to_string_pretty(self, ron::ser::PrettyConfig::new().compact_arrays(true))
            .map_err(|e| Error::file(&path, e.to_string()))?;
        write_durable(&path, (text + "\n").as_bytes())
    }
}
