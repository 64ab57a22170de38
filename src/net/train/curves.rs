//! Loss curve as CSV, extended after every epoch, and as PNG.

use base::error::{Error, Result};
use base::files::atomic::write_atomic;
use record::render::{encode, render_curves};
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

/// Name of the table.
pub const CURVES: &str = "curves.csv";
/// Header of the table.
const HEADER: &str = "epoch,training_loss,validation_loss,learning_rate";

/// Writes `curves.csv` atomically.
///
/// # Errors
/// Fails if the file cannot be written.
pub fn write(dir: &Path, epochs: &[Epoch]) -> Result<()> {
    let mut text = format!("{HEADER}\n");
    for (i, e) in epochs.iter().enumerate() {
        text += &format!("{},{},{},{}\n", i + 1, e.training, e.validation, e.rate);
    }
    write_atomic(&dir.join(CURVES), text.as_bytes())
}

/// Reads `curves.csv`.
///
/// # Errors
/// Fails if the file cannot be read or does not have the format of [`write()`].
pub fn read(dir: &Path) -> Result<Vec<Epoch>> {
    let path = dir.join(CURVES);
    let text =
        std::fs::read_to_string(&path).map_err(|e| Error::system(&path, format!("cannot be read: {e}"), e.kind()))?;
    let epoch = |line: &str| {
        let numbers: Option<Vec<f64>> = line.split(',').map(|field| field.parse().ok()).collect();
        let [_, training, validation, rate] = numbers?.try_into().ok()?;
        Some(Epoch { training, validation, rate })
    };
    let epochs = text.strip_prefix(HEADER).and_then(|rows| rows.trim().lines().map(epoch).collect());
    epochs.ok_or_else(|| Error::file(&path, "is not the loss curve that `tactus train` writes"))
}

/// Draws `curves.png`.
///
/// # Errors
/// Fails if the picture cannot be drawn or the file cannot be written.
pub fn draw(dir: &Path, epochs: &[Epoch]) -> Result<()> {
    let curve = |pick: fn(&Epoch) -> f64| epochs.iter().map(pick).collect::<Vec<_>>();
    let picture = render_curves(&[("training", curve(|e| e.training)), ("validation", curve(|e| e.validation))])?;
    write_atomic(&dir.join("curves.png"), &encode(&picture)?)
}
