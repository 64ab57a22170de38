//! `tactus run`: simulate the grasps of a scene.

use super::Format;
use crate::error::{Error, Result};
use crate::scene::leaf::Count;
use crate::scene::{Fem, Loaded, Loading, Stepper, load};
use clap::ValueEnum;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `tactus run`.
#[derive(Debug, clap::Args)]
pub struct RunArgs {
    /// The scene file.
    pub scene: PathBuf,
    /// Folder for the results; without it nothing is written.
    #[arg(short, long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Form of the report on stdout.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
    /// Threads, instead of the scene's.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1024))]
    pub threads: Option<u64>,
    /// Only this grasp of the scene (from 0); may be given again.
    #[arg(long, value_name = "I")]
    pub grasp: Vec<usize>,
    /// Recorded frames, instead of the scene's.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=10000))]
    pub frames: Option<u64>,
    /// Draw no pictures.
    #[arg(long)]
    pub no_pictures: bool,
    /// Backend, instead of the scene's.
    #[arg(long, value_enum)]
    pub backend: Option<Backend>,
}

/// What advances the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Backend {
    /// Finite elements.
    Fem,
    /// A trained network.
    Gnn,
}

impl RunArgs {
    /// The scene with the arguments taken over.
    pub fn load(&self) -> Result<Loaded> {
        let mut loaded = load(&self.scene)?;
        let scene = &mut loaded.scene;
        match (self.backend, &scene.stepper) {
            (Some(Backend::Fem), Stepper::Gnn(_)) => scene.stepper = Stepper::default(),
            (Some(Backend::Gnn), Stepper::Fem(_)) => {
                return Err(refused("--backend gnn needs a scene with stepper: Gnn(model: \"...\")"));
            }
            _ => {}
        }
        if let Some(threads) = self.threads {
            let threads = Count::new(threads).map_err(|m| refused(&format!("--threads {m}")))?;
            match &mut scene.stepper {
                Stepper::Fem(Fem { threads: own, .. }) => *own = Some(threads),
                Stepper::Gnn(_) => return Err(refused("--threads is for the FEM backend")),
            }
        }
        if let Some(frames) = self.frames {
            let frames = Count::new(frames).map_err(|m| refused(&format!("--frames {m}")))?;
            match &mut scene.loading {
                Loading::Squeeze(squeeze) => squeeze.frames = frames,
                Loading::Press(press) if press.depths.is_some() => {
                    return Err(refused("--frames does not go with a press at given `depths`"));
                }
                Loading::Press(press) => press.frames = Some(frames),
            }
        }
        if self.no_pictures {
            scene.record.pictures = false;
        }
        Ok(loaded)
    }
}

fn refused(message: &str) -> Error {
    Error::Scene(format!("error: {message}"))
}

/// Simulates the grasps of the scene.
pub fn run(args: &RunArgs) -> Result<ExitCode> {
    let loaded = args.load()?;
    // engine call: simulate `loaded.scene` on the grasps `args.grasp` (all if empty), write to `args.out`, report in
    // `args.format`, and return OK or NOT_HELD.
    Err(Error::Solver(format!(
        "{}: the scene is fine, but no engine is linked to this command yet",
        loaded.path.display()
    )))
}
