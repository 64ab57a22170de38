//! Command `tactus train`: trains a network on a data set.

use super::console::Console;
use super::output::{EXIT_OK, Format, with_kept_note};
use super::run::pool;
use super::watch::{WatchArgs, run_watched};
use base::error::Result;
use base::machine::machine_threads;
use dataset::DataSet;
use indicatif::{ProgressBar, ProgressStyle};
use net::network::spec::Spec;
use net::train::{Trainer, TrainingEnd};
use serde_json::json;
use std::path::PathBuf;
use std::time::Instant;

/// Arguments of `tactus train`.
#[derive(Debug, clap::Args)]
pub struct TrainArgs {
    /// Folders of data sets made by `tactus dataset`; several are combined for training.
    #[arg(required = true)]
    pub data: Vec<PathBuf>,
    /// Model file: architecture of the network and settings of the training.
    #[arg(long, value_name = "M.ron")]
    pub model: PathBuf,
    /// Folder of the trained model; an unfinished training is resumed.
    #[arg(short, long, value_name = "DIR")]
    pub out: PathBuf,
    /// Training grasps: `poses`, `all`, `single:OBJECT` or `without:OBJECT,OBJECT`, which excludes all objects whose
    /// name is OBJECT or begins with `OBJECT-`.
    #[arg(long, default_value = "poses")]
    pub split: String,
    /// Model whose weights the training starts from, instead of random ones: a folder, or the name of a built-in model.
    #[arg(long, value_name = "MODEL")]
    pub from: Option<PathBuf>,
    /// Format of the report on stdout.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
    /// Number of threads; the default is all threads of the machine. The weights do not depend on it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1024))]
    pub threads: Option<u64>,
    /// Options of the page in the browser.
    #[command(flatten)]
    pub watch: WatchArgs,
}

/// Trains a network.
///
/// # Errors
/// Fails if the data set or the model file cannot be read, the split is invalid, or a file cannot be written.
pub fn train(args: &TrainArgs, console: &dyn Console) -> Result<u8> {
    let pool = pool(args.threads.map_or_else(machine_threads, |n| n as usize))?;
    run_watched(&args.watch, &args.out, console, || pool.install(|| run(args, console)))
}

fn run(args: &TrainArgs, console: &dyn Console) -> Result<u8> {
    let spec = Spec::read(&args.model)?;
    let sets = args.data.iter().map(DataSet::open).collect::<Result<Vec<_>>>()?;
    let mut trainer = Trainer::new(&sets, &spec, &args.split, &args.out, args.from.as_deref())?;
    trainer.notices.iter().for_each(|notice| console.warn(&format!("note: {notice}")));
    let (training, validation) = trainer.counts();
    let resumed = trainer.epochs().len();
    console.print_message(&format!(
        "{} parameters; {training} grasps for training, {validation} for early stopping{}",
        trainer.card().parameters,
        if resumed > 0 { format!("; {resumed} epochs are already finished") } else { String::new() }
    ));
    let bar = console.attach_progress_bar(ProgressBar::new((spec.training.epochs.get() - resumed) as u64));
    // The template is a constant; if it were invalid, the default style would be used.
    if let Ok(style) = ProgressStyle::with_template("{wide_bar} {msg}  epoch {pos}/{len}  {elapsed}, {eta} left") {
        bar.set_style(style);
    }
    let clock = Instant::now();
    let end = trainer.run(|trainer| {
        bar.inc(1);
        if let Some(last) = trainer.epochs().last() {
            bar.set_message(format!("loss {:.4}, validation {:.4}", last.training, last.validation));
        }
    });
    bar.finish_and_clear();
    let end = end.map_err(|error| {
        with_kept_note(error, || {
            let (done, all) = (trainer.epochs().len(), spec.training.epochs.get());
            format!("{done} of {all} epochs are saved in {}; the same command resumes from there", args.out.display())
        })
    })?;
    let wall = clock.elapsed().as_secs_f64();
    let card = trainer.card();
    let why = match end {
        TrainingEnd::Epochs => "all epochs done",
        TrainingEnd::Patience => "stopped early",
    };
    let text = match args.format {
        Format::Text => format!(
            "{}: {why}; best epoch {} of {}, validation loss {:.5}; {wall:.1} s\n",
            args.out.display(),
            card.epochs,
            trainer.epochs().len(),
            card.validation_loss
        ),
        Format::Json => {
            let object = json!({
                "dir": args.out, "end": why, "epochs": trainer.epochs().len(), "best_epoch": card.epochs,
                "validation_loss": card.validation_loss, "parameters": card.parameters, "resumed_epochs": resumed,
                "wall_s": wall, "curve": trainer.epochs(),
            });
            format!("{object}\n")
        }
    };
    console.print(&text)?;
    card.unknown_error().iter().for_each(|notice| console.warn(&format!("note: {notice}")));
    Ok(EXIT_OK)
}
