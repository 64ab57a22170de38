//! Command line: one file per command.

mod bench;
mod check;
mod completions;
mod console;
mod dataset;
mod dataset_table;
mod eval;
mod findings;
mod fit;
mod inspect;
mod plausible;
mod predict;
mod progress;
mod report;
mod run;
mod table;
mod train;
mod view;

use crate::error::{Error, Result};
use crate::interrupt;
use clap::{Parser, Subcommand, ValueEnum};
use std::process::ExitCode;
use std::sync::LazyLock;

pub use bench::BenchArgs;
pub use check::CheckArgs;
pub use completions::{CompletionsArgs, ManArgs};
pub use console::{Console, Terminal, Verbosity};
pub use dataset::{DatasetArgs, DatasetCommand};
pub use eval::EvalArgs;
pub use fit::FitArgs;
pub use inspect::InspectArgs;
pub use predict::PredictArgs;
pub use report::ReportArgs;
pub use run::RunArgs;
pub use train::TrainArgs;
pub use view::{ViewArgs, WatchArgs};

/// Exit code for success: everything requested was done and every expectation held.
pub const OK: u8 = 0;
/// Exit code of a scene that ran, but an expectation did not hold or a grasp failed.
pub const NOT_HELD: u8 = 1;
/// Exit code of wrong arguments or a wrong file: nothing ran.
pub const REFUSED: u8 = 2;

/// A parallel gripper with two soft tactile pads squeezes a rigid object.
#[derive(Debug, Parser)]
#[command(name = "tactus", version, long_version = long_version(), arg_required_else_help = true)]
pub struct Cli {
    /// Say nothing beside the report: no notes, no progress. Errors are said.
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Say what the solver does: a line for each frame of a run.
    #[arg(short, long, global = true)]
    pub verbose: bool,
    /// Command to run.
    #[command(subcommand)]
    pub command: Command,
}

impl Cli {
    /// Returns how much is said beside the report.
    fn verbosity(&self) -> Verbosity {
        match (self.quiet, self.verbose) {
            (true, _) => Verbosity::Quiet,
            (_, true) => Verbosity::Verbose,
            _ => Verbosity::Usual,
        }
    }
}

/// Commands of tactus.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Simulate the grasps of a scene.
    Run(RunArgs),
    /// Predict all grasps of a scene at once by a trained network.
    Predict(PredictArgs),
    /// Load a scene, check everything in it and print it with all defaults written out.
    Check(CheckArgs),
    /// Simulate all grasps of all objects of a scene into a data set, continuing where an earlier run stopped.
    Dataset(DatasetArgs),
    /// Train a network on a data set, continuing where an earlier run stopped.
    Train(TrainArgs),
    /// Judge a trained network on grasps that it has not seen.
    Eval(EvalArgs),
    /// Measure speed against error: all settings of the finite elements and networks on the same grasps.
    Bench(BenchArgs),
    /// Fit Young's modulus, Poisson's ratio, friction and the zero of depth of a press to a measured curve.
    Fit(FitArgs),
    /// Put results into one page: tables, charts, both pads in 3-D.
    Report(ReportArgs),
    /// Show results in the browser, while they are written, too.
    View(ViewArgs),
    /// Print the completions of a shell.
    Completions(CompletionsArgs),
    /// Write the pages of the manual.
    Man(ManArgs),
}

/// Form of what is printed on stdout.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum Format {
    /// Text for readers.
    #[default]
    Text,
    /// JSON object.
    Json,
}

/// Version, and of what the build reads and runs on.
fn long_version() -> &'static str {
    static TEXT: LazyLock<String> = LazyLock::new(|| {
        let (os, arch) = (std::env::consts::OS, std::env::consts::ARCH);
        let (data, features) = (crate::dataset::arrays::FORMAT, crate::net::features::VERSION);
        format!(
            "{}\n{os} {arch}; data sets of layout {data}, networks of features {features}",
            env!("CARGO_PKG_VERSION")
        )
    });
    &TEXT
}

/// Runs the command; an error is printed to stderr and gives exit code 2. Wrong arguments are reported by clap, with the
/// same code.
pub fn main() -> ExitCode {
    match on_terminal(&Cli::parse()) {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            let text = error.to_string();
            let plain = text.starts_with("error:") || matches!(error, Error::Interrupted(_));
            let start = if plain { "" } else { "error: " };
            Terminal::fail(&format!("{start}{text}"));
            ExitCode::from(REFUSED)
        }
    }
}

/// Prints the last message of a command that is ended in the middle of work that does not check the stop flag.
fn last_words() {
    // Whoever asked for the end may have closed the terminal.
    Terminal::fail("\ninterrupted; files that were being written are as they were before");
}

/// Returns the error of a command; if an end was requested, it says what is kept.
fn kept(error: Error, kept: impl FnOnce() -> String) -> Error {
    match error {
        Error::Interrupted(_) => Error::Interrupted(format!("interrupted; {}", kept())),
        other => other,
    }
}

fn on_terminal(cli: &Cli) -> Result<u8> {
    // The others are short; a signal ends them as it ends any program.
    let short =
        matches!(cli.command, Command::Check(_) | Command::Report(_) | Command::Completions(_) | Command::Man(_));
    if !short {
        interrupt::on_signals(REFUSED, last_words)?;
    }
    cli.command.run(&Terminal(cli.verbosity()))
}

impl Command {
    /// Runs the command and returns its exit code.
    ///
    /// # Errors
    /// Fails if an argument or a file is refused, or the command cannot go on.
    pub fn run(&self, console: &dyn Console) -> Result<u8> {
        match self {
            Command::Run(args) => run::run(args, console),
            Command::Predict(args) => predict::predict(args, console),
            Command::Check(args) => check::check(args, console),
            Command::Dataset(args) => dataset::dataset(args, console),
            Command::Train(args) => train::train(args, console),
            Command::Eval(args) => eval::eval(args, console),
            Command::Bench(args) => bench::bench(args, console),
            Command::Fit(args) => fit::fit(args, console),
            Command::Report(args) => report::report_page(args, console),
            Command::View(args) => view::view(args, console),
            Command::Completions(args) => completions::completions(args, console),
            Command::Man(args) => completions::man(args),
        }
    }
}
