//! State of a training run between epochs.

use super::adam::Adam;
use super::curves::Epoch;
use crate::network::parameters::Parameters;

/// State after an epoch.
#[derive(Debug, Clone)]
pub struct TrainingState {
    /// Current weights.
    pub parameters: Parameters,
    /// Weights of the epoch with the smallest validation loss.
    pub best: Parameters,
    /// State of the optimiser.
    pub adam: Adam,
    /// Loss curve so far.
    pub epochs: Vec<Epoch>,
}

impl TrainingState {
    /// Returns the epoch with the smallest validation loss, and that loss.
    pub fn best_epoch(&self) -> Option<(usize, f64)> {
        let losses = self.epochs.iter().map(|e| e.validation).enumerate();
        losses.min_by(|a, b| a.1.total_cmp(&b.1))
    }
}
