//! RON description of a model: its network and its training.

use base::error::{Error, Result};
use scene::leaf::{Count, Fraction, Positive};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Content of a model file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename = "Model", deny_unknown_fields)]
pub struct Spec {
    /// Kind and sizes of the network.
    pub network: NetworkSpec,
    /// Settings of the training.
    #[serde(default)]
    pub training: Training,
}

/// Available networks, with their sizes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum NetworkSpec {
    /// Message passing on the sensing face, the whole force ramp from one pass: [`super::face`].
    Face(Face),
    /// Network of the tactile paper, through the full pads, once per load: [`super::paper`].
    Paper(Paper),
}

/// Sizes of the face network.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Face {
    /// Number of values per node during message passing.
    pub latent: Count<1, 1024>,
    /// Number of rounds of message passing.
    pub rounds: Count<1, 64>,
    /// Number of values per node during the decoding of a load level.
    pub decoder: Count<1, 1024>,
    /// Number of depth channels from the face to the bonded side.
    pub depths: Count<2, 64>,
}

impl Default for Face {
    fn default() -> Self {
        Self {
            latent: Count::new_unchecked(48),
            rounds: Count::new_unchecked(5),
            decoder: Count::new_unchecked(64),
            depths: Count::new_unchecked(5),
        }
    }
}

/// Sizes of the tactile paper's network.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Paper {
    /// Number of values per node and edge.
    pub latent: Count<1, 1024>,
    /// Number of rounds of message passing, all with the same weights.
    pub rounds: Count<1, 64>,
}

impl Default for Paper {
    fn default() -> Self {
        Self { latent: Count::new_unchecked(128), rounds: Count::new_unchecked(15) }
    }
}

/// Settings of the training of a network.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Training {
    /// Largest number of passes over the training set.
    pub epochs: Count<1, 1000000>,
    /// Number of grasps per step.
    pub batch: Count<1, 4096>,
    /// Number of load levels of a grasp in a step, redrawn in every step.
    pub levels: Count<1, 10000>,
    /// Number of frames per grasp in memory, evenly spaced from the first to the last.
    pub frames: Count<1, 10000>,
    /// Largest step of Adam (Kingma and Ba 2015); linear warm-up over the first 2 % of the steps, then cosine decay.
    pub learning_rate: Positive,
    /// Largest norm of the gradient; longer gradients are clipped to it.
    pub clip: Positive,
    /// Fraction of the training grasps held out for early stopping.
    pub validation: Fraction,
    /// Number of epochs without a smaller validation loss after which training stops.
    pub patience: Count<1, 1000000>,
    /// Weights of stress, contact force, travel and object motion in the loss; displacement has 1.
    pub weights: [f32; 4],
    /// Flag: grasps are mirrored at random, which quadruples the data.
    pub mirror: bool,
    /// Seed of the initial values and of the order of the grasps, their levels and mirrors.
    pub seed: u64,
}

impl Default for Training {
    fn default() -> Self {
        Self {
            epochs: Count::new_unchecked(200),
            batch: Count::new_unchecked(4),
            levels: Count::new_unchecked(4),
            frames: Count::new_unchecked(10),
            learning_rate: Positive::new_unchecked(2e-3),
            clip: Positive::new_unchecked(1.0),
            validation: Fraction::new_unchecked(0.1),
            patience: Count::new_unchecked(60),
            weights: [1.0, 0.3, 3.0, 0.1],
            mirror: true,
            seed: 1,
        }
    }
}

impl Spec {
    /// Reads a model file.
    ///
    /// # Errors
    /// Fails if the file cannot be read or parsed; the message gives file, line and column.
    pub fn read(path: &Path) -> Result<Self> {
        let text =
            std::fs::read_to_string(path).map_err(|e| Error::system(path, format!("cannot be read: {e}"), e.kind()))?;
        let bad = |e: ron::error::SpannedError| {
            let at = e.span.start;
            Error::Scene(format!("error: {}:{}:{}: {}", path.display(), at.line, at.col, e.code))
        };
        scene::dialect::options().from_str(&text).map_err(bad)
    }
}
