//! Console of a command: the destination of its report, messages and progress.

use base::error::{Error, Result};
use indicatif::ProgressBar;
use std::io::Write;

/// Output of a command; implemented by the terminal and by the Python package.
pub trait Console: Sync {
    /// Prints a part of the report.
    ///
    /// # Errors
    /// Fails if the report cannot be written.
    fn print(&self, text: &str) -> Result<()>;
    /// Prints a message in addition to the report.
    fn print_message(&self, line: &str);
    /// Prints a warning that affects whether a result can be trusted.
    fn warn(&self, line: &str) {
        self.print_message(line);
    }
    /// Returns true if details of the solver's work are requested.
    fn is_verbose(&self) -> bool {
        false
    }
    /// Shows a progress bar.
    fn attach_progress_bar(&self, bar: ProgressBar) -> ProgressBar {
        bar
    }
    /// Returns true if the process ends with the command. Memory is then not freed, because the operating system
    /// reclaims it faster.
    fn ends_process(&self) -> bool {
        false
    }
}

/// Amount of output in addition to the report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Verbosity {
    /// Errors only.
    Quiet,
    /// Notes and progress.
    #[default]
    Normal,
    /// Notes, progress, and details of the solver's work.
    Verbose,
}

/// Terminal: the report goes to stdout, everything else to stderr.
#[derive(Debug, Default)]
pub struct Terminal(pub Verbosity);

impl Terminal {
    /// Prints an error on stderr at any verbosity. A line that cannot be written (`2>/dev/full`, a closed pipe) is
    /// ignored.
    pub fn fail(line: &str) {
        let _ = std::io::stderr().write_all(format!("{line}\n").as_bytes());
    }
}

impl Console for Terminal {
    /// Prints on stdout; a closed pipe (`tactus check x.ron | head`) is not an error.
    fn print(&self, text: &str) -> Result<()> {
        match std::io::stdout().write_all(text.as_bytes()) {
            Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::file("<stdout>", e.to_string())),
            _ => Ok(()),
        }
    }

    fn print_message(&self, line: &str) {
        if self.0 != Verbosity::Quiet {
            Terminal::fail(line);
        }
    }

    fn is_verbose(&self) -> bool {
        self.0 == Verbosity::Verbose
    }

    fn attach_progress_bar(&self, bar: ProgressBar) -> ProgressBar {
        if self.0 == Verbosity::Quiet { ProgressBar::hidden() } else { bar }
    }

    fn ends_process(&self) -> bool {
        true
    }
}
