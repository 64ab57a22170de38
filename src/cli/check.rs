//! `tactus check`: is the scene right, and what does it say once defaults and includes are in?

use super::{Format, OK};
use crate::error::{Error, Result};
use crate::scene::{load, to_ron};
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `tactus check`.
#[derive(Debug, clap::Args)]
pub struct CheckArgs {
    /// The scene file.
    pub scene: PathBuf,
    /// Form of the output.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Loads the scene and prints it.
pub fn check(args: &CheckArgs) -> Result<ExitCode> {
    let loaded = load(&args.scene)?;
    let text = match args.format {
        Format::Text => to_ron(&loaded.scene)?,
        Format::Json => {
            let object = serde_json::json!({
                "scene": loaded.scene,
                "sources": loaded.sources,
                "problems": [],
            });
            format!("{object}\n")
        }
    };
    match std::io::stdout().write_all(text.as_bytes()) {
        // a closed pipe (`tactus check x.ron | head`) is the reader's choice, not an error
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::file("<stdout>", e.to_string())),
        _ => Ok(ExitCode::from(OK)),
    }
}
