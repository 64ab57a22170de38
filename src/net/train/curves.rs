//! Loss curve as CSV and PNG.

use crate::error::Result;
use crate::files::atomic::write_atomic;
use crate::render::{encode, render_curves};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Losses of one epoch.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Epoch {
    /// Mean loss over the steps.
    pub training: f64,
    /// Loss of the validation grasps after the epoch.
    pub validation: f64,
    /// Learning rate at the start of the epoch.
    pub rate: f64,
}

/// Writes `curves.csv` and `curves.png`.
///
/// # Errors
/// Fails if the picture cannot be drawn or a file cannot be written.
pub fn write(dir: &Path, epochs: &[Epoch]) -> Result<()> {
    let mut text = String::from("epoch,training_loss,validation_loss,learning_rate\n");
    for (i, e) in epochs.iter().enumerate() {
        text += &format!("{},{},{},{}\n", i + 1, e.training, e.validation, e.rate);
    }
    write_atomic(&dir.join("curves.csv"), text.as_bytes())?;
    let curve = |pick: fn(&Epoch) -> f64| epochs.iter().map(pick).collect::<Vec<_>>();
    let picture = render_curves(&[("training", curve(|e| e.training)), ("validation", curve(|e| e.validation))])?;
    write_atomic(&dir.join("curves.png"), &encode(&picture)?)
}
