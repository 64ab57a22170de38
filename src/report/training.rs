//! Section of a training: loss curves so far, and the model once finished.

use super::chart::{Abscissa, Chart, ChartQuantity, Series};
use super::page::{Page, PageBlock, Section};
use super::run::name;
use base::error::Result;
use base::number::format_count;
use net::network::card::{CARD, StoredModel};
use net::train::curves::{self, Epoch};
use std::path::Path;

/// Adds the training in `dir`.
///
/// # Errors
/// Fails if the loss curves cannot be read.
pub fn training(dir: &Path, page: &mut Page) -> Result<()> {
    let epochs = curves::read(dir)?;
    let best = epochs.iter().enumerate().min_by(|a, b| a.1.validation.total_cmp(&b.1.validation));
    let best = best.map_or(String::new(), |(at, epoch)| {
        format!(" The smallest validation loss is {:.5}, of epoch {}.", epoch.validation, at + 1)
    });
    let mut blocks = vec![PageBlock::Chart(losses(&epochs))];
    let count = format_count(epochs.len(), "epoch");
    let lead = match dir.join(CARD).exists().then(|| StoredModel::read(dir)) {
        None => format!("The training is not finished: so far {count}.{best}"),
        Some(Ok(StoredModel { card, .. })) => {
            let learnt = format!("{}, {} parameters", format_count(card.grasps, "training grasp"), card.parameters);
            format!("{count}, {learnt}, split {}.{best}", card.split)
        }
        Some(Err(error)) => {
            blocks.push(PageBlock::Note(error.to_string()));
            format!("{count}.{best}")
        }
    };
    page.sections.push(Section::new(format!("Training {}", name(dir)), lead, blocks));
    Ok(())
}

fn losses(epochs: &[Epoch]) -> Chart {
    let of = |pick: fn(&Epoch) -> f64| epochs.iter().map(pick).collect::<Vec<_>>();
    let quantity = |name: &str, series| ChartQuantity { name: name.into(), unit: "1".into(), series };
    let loss = vec![Series::new("training", of(|e| e.training)), Series::new("validation", of(|e| e.validation))];
    let rate = vec![Series::new("learning rate", of(|e| e.rate))];
    Chart {
        title: "Loss".into(),
        over: Abscissa::Axis { label: "epoch".into(), at: (1..=epochs.len()).map(|epoch| epoch as f64).collect() },
        quantities: vec![quantity("loss", loss), quantity("learning rate", rate)],
    }
}
