//! Folder of a trained model: `weights.safetensors`, and `card.ron` with the network, its training and the data set.

use super::Normalisers;
use super::interval::{MIN_GRASPS, PredictionInterval};
use super::shipped;
use super::slip_interval::SlipInterval;
use super::spec::{NetworkSpec, Spec};
use crate::features::VERSION;
use crate::features::normalise::MOST;
use crate::features::range::TrainedRange;
use base::error::{Error, Result};
use base::files::atomic::write_durable;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::path::Path;

/// Name of the card in the folder of a model.
pub const CARD: &str = "card.ron";
/// Models shipped with earlier versions.
const FORMER_NAMES: [&str; 2] = ["gelsight_mini", "gelsight_mini_fine"];
/// Name of the weights file.
pub const WEIGHTS: &str = "weights.safetensors";

/// Description of a trained model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Card {
    /// Version of tactus that trained it.
    pub tactus: String,
    /// Version ([`VERSION`]) of its input features.
    #[serde(default)]
    pub features: u32,
    /// Network and training.
    pub spec: Spec,
    /// Hash of the data set's plan.
    pub data: String,
    /// Split of the training.
    pub split: String,
    /// Hash of the data sets of the model from which the training started; empty if it started from random weights.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub start: String,
    /// Number of training grasps.
    pub grasps: usize,
    /// Number of values in the weights.
    pub parameters: usize,
    /// Units of the predictions.
    pub units: String,
    /// Loss on the validation grasps.
    pub validation_loss: f64,
    /// Number of epochs after which these weights were reached.
    pub epochs: usize,
    /// Statistics of the training set.
    pub normalisers: Normalisers,
    /// Range of the training set, in which the model may be used.
    pub range: TrainedRange,
    /// Number of grasps held out from the training; zero in older models.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub kept: usize,
    /// Prediction interval; None if fewer than [`MIN_GRASPS`] grasps were held out from the training.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interval: Option<PredictionInterval>,
    /// Load at which objects slip; None if fewer than [`MIN_GRASPS`] grasps of the training data did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slip: Option<SlipInterval>,
    /// BLAKE3 hash of the fields above and of the weights; empty in older models.
    #[serde(default)]
    pub checksum: String,
}

/// Origin of a model, which the cards of all versions contain.
#[derive(Debug, Deserialize)]
#[serde(rename = "Card")]
struct CardOrigin {
    tactus: String,
    #[serde(default)]
    features: u32,
}

fn is_zero(number: &usize) -> bool {
    *number == 0
}

/// Model read from a folder or shipped in the program.
#[derive(Debug)]
pub struct StoredModel {
    /// Card of the model.
    pub card: Card,
    /// Weights of the model, safetensors.
    pub weights: Cow<'static, [u8]>,
}

impl StoredModel {
    /// Reads the model in the folder `model`, or the shipped one of this name.
    ///
    /// # Errors
    /// Fails if there is no model, if its format or the version of its features differs, or if it is damaged.
    pub fn read(model: &Path) -> Result<Self> {
        let path = model.join(CARD);
        let (text, weights) = match shipped::by_name(model) {
            Some(shipped) => (shipped.card.into(), shipped.weights.into()),
            None => {
                let text = std::fs::read_to_string(&path).map_err(|e| missing(model, &path, &e))?;
                let path = model.join(WEIGHTS);
                let weights =
                    std::fs::read(&path).map_err(|e| Error::system(&path, format!("cannot be read: {e}"), e.kind()))?;
                (Cow::from(text), Cow::from(weights))
            }
        };
        // Cards of other versions have other fields, so the versions are read first.
        let made: CardOrigin =
            ron::from_str(&text).map_err(|e| Error::file(&path, format!("is not a model card: {e}")))?;
        if made.features != VERSION {
            let message = format!(
                "its network was trained by tactus {} with feature version {}, but this is tactus {} with feature \
                 version {VERSION}; train it again with `tactus train`, on a new data set, or use a built-in network: \
                 {}",
                made.tactus,
                made.features,
                env!("CARGO_PKG_VERSION"),
                shipped::names()
            );
            return Err(Error::file(&path, message));
        }
        let card: Card = ron::from_str(&text).map_err(|e| Error::file(&path, format!("is not a model card: {e}")))?;
        let read = Self { card, weights };
        read.card
            .check()
            .map_err(|what| Error::file(&path, format!("{what}; restore the model from a copy, or train it again")))?;
        read.verified(&path)
    }

    /// Returns the model if the checksum of card and weights is correct.
    fn verified(self, path: &Path) -> Result<Self> {
        if !self.card.checksum.is_empty() && self.card.sum(&self.weights)? != self.card.checksum {
            let message = "this card or its weights were changed or damaged after the training; restore both from a \
                copy, or train again";
            return Err(Error::file(path, message));
        }
        Ok(self)
    }
}

fn missing(model: &Path, path: &Path, e: &std::io::Error) -> Error {
    if let Some(name) = FORMER_NAMES.iter().find(|name| model.file_name().is_some_and(|own| own == **name)) {
        let message = format!(
            "{name:?} is a network of version 0.1; use the built-in network that replaces it: {}",
            shipped::names()
        );
        return Error::file(model, message);
    }
    let message = format!(
        "cannot be read: {e}; a model is created by `tactus train DATASET --model M.ron -o {}`; built-in networks: {}",
        model.display(),
        shipped::names()
    );
    Error::system(path, message, e.kind())
}

impl Card {
    /// Checks that the values are valid. The error names the field and states what is wrong.
    fn check(&self) -> std::result::Result<(), String> {
        self.normalisers.check(matches!(self.spec.network, NetworkSpec::Paper(_)))?;
        self.range.check()?;
        self.interval.iter().try_for_each(PredictionInterval::check)?;
        self.slip.iter().try_for_each(SlipInterval::check)?;
        match self.validation_loss {
            loss if (0.0..=MOST).contains(&loss) => Ok(()),
            loss => Err(format!("`validation_loss` is {loss}; allowed: 0 to {MOST:e}")),
        }
    }

    /// Returns the prediction interval, if it was fitted to enough grasps.
    pub fn interval(&self) -> Option<PredictionInterval> {
        self.interval.filter(PredictionInterval::has_enough_grasps)
    }

    /// Returns why the error of its predictions is unknown; None if it has a prediction interval.
    pub fn unknown_error(&self) -> Option<String> {
        self.interval().is_none().then(|| {
            let kept = if self.kept > 0 { self.kept.to_string() } else { "fewer".into() };
            format!(
                "the error of the network is unknown: its estimate needs at least {MIN_GRASPS} grasps that are not used \
                 for training, and there were {kept}; train on more grasps, or with a larger `validation`"
            )
        })
    }

    /// Computes [`Self::checksum`] for these weights.
    fn sum(&self, weights: &[u8]) -> Result<String> {
        let own = Self { checksum: String::new(), ..self.clone() };
        let mut hasher = blake3::Hasher::new();
        hasher.update(
            ron::to_string(&own).map_err(|e| Error::Solver(format!("the card cannot be written: {e}")))?.as_bytes(),
        );
        Ok(hasher.update(weights).finalize().to_hex().to_string())
    }

    /// Sets the checksum for `weights` and writes both files, the card last.
    ///
    /// # Errors
    /// Fails if the card or a file cannot be written.
    pub fn write(&mut self, dir: &Path, weights: &[u8]) -> Result<()> {
        self.checksum = self.sum(weights)?;
        write_durable(&dir.join(WEIGHTS), weights)?;
        let path = dir.join(CARD);
        let text = ron::ser::to_string_pretty(self, ron::ser::PrettyConfig::new().compact_arrays(true))
            .map_err(|e| Error::file(&path, e.to_string()))?;
        write_durable(&path, (text + "\n").as_bytes())
    }
}
