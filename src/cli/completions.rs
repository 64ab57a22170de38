//! Commands `tactus completions` and `tactus man`: files that a package installs with the program.

use super::console::Console;
use super::output::EXIT_OK;
use base::error::{Error, Result};
use base::files::atomic::create_dir;
use clap::Command;
use clap_complete::Shell;
use std::path::PathBuf;

/// Arguments of `tactus completions`.
#[derive(Debug, clap::Args)]
pub struct CompletionsArgs {
    /// Shell that uses the script.
    #[arg(value_enum)]
    pub shell: Shell,
}

/// Arguments of `tactus man`.
#[derive(Debug, clap::Args)]
pub struct ManArgs {
    /// Folder for the manual pages: `tactus.1` and one for each command.
    #[arg(short, long, value_name = "DIR")]
    pub out: PathBuf,
}

/// Prints the completion script of a shell for `command`, the whole command line.
///
/// # Errors
/// Fails if stdout cannot be written.
pub fn completions(args: &CompletionsArgs, mut command: Command, console: &dyn Console) -> Result<u8> {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut command, "tactus", &mut text);
    console.print(&String::from_utf8_lossy(&text))?;
    Ok(EXIT_OK)
}

/// Writes the manual pages of `command`, the whole command line.
///
/// # Errors
/// Fails if a file cannot be written.
pub fn man(args: &ManArgs, command: Command) -> Result<u8> {
    create_dir(&args.out)?;
    clap_mangen::generate_to(command, &args.out).map_err(|e| Error::file(&args.out, e.to_string()))?;
    Ok(EXIT_OK)
}
