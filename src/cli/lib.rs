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
mod output;
mod plausible;
mod predict;
mod progress;
mod report;
mod run;
mod table;
mod train;
mod view;
mod watch;

use base::error::{Error, Result};
use base::interrupt;
use clap::{CommandFactory, Parser, Subcommand};
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
pub use output::{EXIT_ERROR, EXIT_EXPECTATION_FAILED, EXIT_OK, Format};
pub use predict::PredictArgs;
pub use report::ReportArgs;
pub use run::RunArgs;
pub use train::TrainArgs;
pub use view::ViewArgs;
pub use watch::WatchArgs;

/// A parallel gripper with two soft tactile pads squeezes a rigid object.
#[derive(Debug, Parser)]
#[command(name = "tactus", version, long_version = long_version(), arg_required_else_help = true)]
pub struct Cli {
    /// Print only the report and errors: no notes, no progress.
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Print details: a line on the solver for each frame of a run; all systems and components in `check`.
    #[arg(short, long, global = true)]
    pub verbose: bool,
    /// Command to run.
    #[command(subcommand)]
    pub command: Command,
}

impl Cli {
    /// Returns how much is printed in addition to the report.
    fn verbosity(&self) -> Verbosity {
        match (self.quiet, self.verbose) {
            (true, _) => Verbosity::Quiet,
            (_, true) => Verbosity::Verbose,
            _ => Verbosity::Normal,
        }
    }
}

/// Commands of the command line.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Simulate the grasps of a scene.
    Run(RunArgs),
    /// Predict all grasps of a scene with a trained network.
    Predict(PredictArgs),
    /// Check a scene and print it with all includes and defaults written out.
    Check(CheckArgs),
    /// Simulate all grasps of all objects of a scene into a data set; an interrupted run is resumed.
    Dataset(DatasetArgs),
    /// Train a network on data sets; an interrupted training is resumed.
    Train(TrainArgs),
    /// Evaluate a trained network on grasps that were not used for its training.
    Eval(EvalArgs),
    /// Measure speed against error: finite elements at several settings, and networks, on the same grasps.
    Bench(BenchArgs),
    /// Fit Young's modulus, Poisson's ratio, friction and the zero of depth of a press to a measured force-depth curve.
    Fit(FitArgs),
    /// Write one HTML page with results: tables, charts and both pads in 3-D.
    Report(ReportArgs),
    /// Show results in the browser, also while they are being written.
    View(ViewArgs),
    /// Print the completion script of a shell.
    Completions(CompletionsArgs),
    /// Write the manual pages.
    Man(ManArgs),
}

/// Returns the version, the platform, and the versions of the data set layout and of the network features.
fn long_version() -> &'static str {
    static TEXT: LazyLock<String> = LazyLock::new(|| {
        let (os, arch) = (std::env::consts::OS, std::env::consts::ARCH);
        let (data, features) = (::dataset::arrays::FORMAT, net::features::VERSION);
        format!(
            "{}\n{os} {arch}; data set layout {data}, network feature version {features}",
            env!("CARGO_PKG_VERSION")
        )
    });
    &TEXT
}

/// Runs the command given by the process arguments. An error is printed to stderr and gives exit code 2; clap reports
/// invalid arguments with the same code.
pub fn main() -> ExitCode {
    match on_terminal(&Cli::parse()) {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            let text = error.to_string();
            let plain = text.starts_with("error:") || matches!(error, Error::Interrupted(_));
            let start = if plain { "" } else { "error: " };
            Terminal::fail(&format!("{start}{text}"));
            ExitCode::from(EXIT_ERROR)
        }
    }
}

/// Prints the last message of a command that is ended after a signal because it did not check the stop flag in time.
fn print_interrupted() {
    // A failure to write is ignored: the terminal may have been closed.
    Terminal::fail("\ninterrupted; files that were being written keep their previous contents");
}

fn on_terminal(cli: &Cli) -> Result<u8> {
    // The other commands are short; a signal ends them by its default action.
    let short =
        matches!(cli.command, Command::Check(_) | Command::Report(_) | Command::Completions(_) | Command::Man(_));
    if !short {
        interrupt::on_signals(EXIT_ERROR, print_interrupted)?;
    }
    cli.command.run(&Terminal(cli.verbosity()))
}

impl Command {
    /// Runs the command and returns its exit code.
    ///
    /// # Errors
    /// Fails if an argument or a file is invalid, or the command cannot continue.
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
            Command::Completions(args) => completions::completions(args, Cli::command(), console),
            Command::Man(args) => completions::man(args, Cli::command()),
        }
    }
}
