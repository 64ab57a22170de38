//! Console of a command: where its report, what it says beside it, and its progress go.

use crate::error::{Error, Result};
use indicatif::ProgressBar;
use std::io::Write;

/// Receives what a command has to say. The terminal is one; Python is another.
pub trait Console: Sync {
    /// Prints a part of the report.
    ///
    /// # Errors
    /// Fails if the report cannot be written.
    fn print(&self, text: &str) -> Result<()>;
    /// Says a line beside the report.
    fn say(&self, line: &str);
    /// Says what a reader should know before a result is trusted.
    fn warn(&self, line: &str) {
        self.say(line);
    }
    /// Returns true if a reader wants to follow what the solver does.
    fn follows(&self) -> bool {
        false
    }
    /// Shows a progress bar.
    fn show(&self, bar: ProgressBar) -> ProgressBar {
        bar
    }
    /// Returns true if the process ends with the command: the system takes its memory back faster than it is given back piece by piece.
    fn ends(&self) -> bool {
        false
    }
}

/// How much is said beside the report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Verbosity {
    /// Errors alone.
    Quiet,
    /// Notes and progress.
    #[default]
    Usual,
    /// Notes, progress, and what the solver does.
    Verbose,
}

/// Terminal: the report goes to stdout, all else to stderr.
#[derive(Debug, Default)]
pub struct Terminal(pub Verbosity);

impl Terminal {
    /// Prints an error on stderr, however little is to be said. A line that cannot be written (`2>/dev/full`, a closed pipe) does not affect the work.
    pub fn fail(line: &str) {
        let _ = std::io::stderr().write_all(format!("{line}\n").as_bytes());
    }
}

impl Console for Terminal {
    /// Prints on stdout; a closed pipe (`tactus check x.ron | head`) is the reader's choice, not an error.
    fn print(&self, text: &str) -> Result<()> {
        match std::io::stdout().write_all(text.as_bytes()) {
            Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::file("<stdout>", e.to_string())),
            _ => Ok(()),
        }
    }

    fn say(&self, line: &str) {
        if self.0 != Verbosity::Quiet {
            Terminal::fail(line);
        }
    }

    fn follows(&self) -> bool {
        self.0 == Verbosity::Verbose
    }

    fn show(&self, bar: ProgressBar) -> ProgressBar {
        if self.0 == Verbosity::Quiet { ProgressBar::hidden() } else { bar }
    }

    fn ends(&self) -> bool {
        true
    }
}
