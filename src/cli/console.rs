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
    /// Shows a progress bar.
    fn show(&self, bar: ProgressBar) -> ProgressBar {
        bar
    }
    /// Returns true if the process ends with the command: the system takes its memory back faster than it is given back piece by piece.
    fn ends(&self) -> bool {
        false
    }
}

/// Terminal: the report goes to stdout, all else to stderr.
#[derive(Debug)]
pub struct Terminal;

impl Console for Terminal {
    /// Prints on stdout; a closed pipe (`tactus check x.ron | head`) is the reader's choice, not an error.
    fn print(&self, text: &str) -> Result<()> {
        match std::io::stdout().write_all(text.as_bytes()) {
            Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::file("<stdout>", e.to_string())),
            _ => Ok(()),
        }
    }

    /// Prints a line on stderr. A line that cannot be written (`2>/dev/full`, a closed pipe) does not affect the work.
    fn say(&self, line: &str) {
        let _ = std::io::stderr().write_all(format!("{line}\n").as_bytes());
    }

    fn ends(&self) -> bool {
        true
    }
}
