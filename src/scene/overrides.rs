//! Values that replace those of a scene for one run, set on the command line or in Python.

use super::dialect::recheck;
use super::leaf::{Count, Positive};
use super::schema::Scene;
use super::stepper::{Condensed, Fem, Gnn, SHIPPED_MODELS, Solver, StepperChoice};
use base::error::{Error, Result};
use clap::ValueEnum;
use std::path::PathBuf;

/// Backend that advances the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Backend {
    /// Finite elements.
    Fem,
    /// Finite elements with pads condensed onto the nodes that can come into contact: fast, with an additional error.
    Condensed,
    /// Trained network.
    Gnn,
}

/// Values that replace those of the scene; None and false keep the values of the scene.
#[derive(Debug, Clone, Default)]
pub struct Overrides {
    /// Backend that advances the scene.
    pub backend: Option<Backend>,
    /// Folder of a trained network, or name of a bundled one. Only for a network.
    pub model: Option<PathBuf>,
    /// Largest accepted relative error of the displacement that a network predicts; grasps above it are computed by
    /// finite elements. Only for a network.
    pub error_at_most: Option<f64>,
    /// Flag: the network also predicts grasps outside the range of its training, where its error is unknown. Only for a
    /// network.
    pub extrapolate: bool,
    /// Final force of a squeeze, the sum over the fingers, N.
    pub force: Option<f64>,
    /// Number of recorded frames.
    pub frames: Option<u64>,
    /// Number of threads, 1 to 1024; only for finite elements, ignored for a network.
    pub threads: Option<u64>,
    /// Limit of the wall time of a grasp, s; above it, the grasp ends as a fault. Only for finite elements.
    pub max_time: Option<f64>,
    /// Flag: the run writes no pictures.
    pub no_pictures: bool,
}

impl Overrides {
    /// Replaces the given values in `scene`, and validates the scene again.
    ///
    /// # Errors
    /// Fails if a value is out of range, does not apply to the backend or the loading, or is inconsistent with the rest
    /// of the scene; `scene` may then be changed in part.
    pub fn apply(&self, scene: &mut Scene) -> Result<()> {
        self.apply_backend(&mut scene.stepper)?;
        self.apply_error_limit(&mut scene.stepper)?;
        if let Some(threads) = self.threads {
            let threads = Count::new(threads).map_err(|m| argument_error(&format!("--threads {m}")))?;
            if let StepperChoice::Fem(Fem { threads: own, .. }) = &mut scene.stepper {
                *own = Some(threads);
            }
        }
        if let Some(seconds) = self.max_time {
            limit_time(&mut scene.stepper, seconds)?;
        }
        if let Some(force) = self.force {
            scene.loading.set_force(force).map_err(|m| argument_error(&m))?;
        }
        if let Some(frames) = self.frames {
            scene.loading.set_frames(frames).map_err(|m| argument_error(&m))?;
        }
        scene.record.pictures &= !self.no_pictures;
        recheck(scene)
    }

    /// Applies backend and model.
    fn apply_backend(&self, stepper: &mut StepperChoice) -> Result<()> {
        match (self.backend, &mut *stepper) {
            (Some(Backend::Fem | Backend::Condensed), stepper) => {
                let mut fem = if let StepperChoice::Fem(fem) = stepper { *fem } else { Fem::default() };
                fem.solver = match (self.backend, fem.solver) {
                    (Some(Backend::Fem), _) => Solver::Full,
                    (_, Solver::Full) => Solver::Condensed(Condensed::default()),
                    (_, given) => given,
                };
                *stepper = StepperChoice::Fem(fem);
            }
            (Some(Backend::Gnn), StepperChoice::Fem(_)) => *stepper = StepperChoice::Gnn(Gnn::new(SHIPPED_MODELS[0])),
            _ => {}
        }
        match (&self.model, stepper) {
            (None, _) => Ok(()),
            (Some(model), StepperChoice::Gnn(gnn)) => {
                gnn.model.clone_from(model);
                Ok(())
            }
            (Some(_), StepperChoice::Fem(_)) => {
                Err(argument_error("--model is allowed only for a network; add --backend gnn"))
            }
        }
    }

    /// Applies the accepted error and the extrapolation of a network.
    fn apply_error_limit(&self, stepper: &mut StepperChoice) -> Result<()> {
        match stepper {
            StepperChoice::Gnn(gnn) => {
                let most = self.error_at_most.map(Positive::new).transpose();
                let most = most.map_err(|m| argument_error(&format!("--error-at-most {m}")))?;
                gnn.error_at_most = most.or(gnn.error_at_most);
                gnn.extrapolate |= self.extrapolate;
                Ok(())
            }
            StepperChoice::Fem(_) if self.error_at_most.is_some() || self.extrapolate => Err(argument_error(
                "--error-at-most and --extrapolate are allowed only for a network; add --backend gnn",
            )),
            StepperChoice::Fem(_) => Ok(()),
        }
    }
}

/// Sets the limit of the wall time of each grasp in the settings `stepper` of the backend to `seconds`; above it, a
/// grasp ends as a fault.
///
/// # Errors
/// Fails if the time is not a finite number above zero, or the backend is a network.
pub fn limit_time(stepper: &mut StepperChoice, seconds: f64) -> Result<()> {
    let seconds = Positive::new(seconds).map_err(|m| argument_error(&format!("--max-time {m}")))?;
    match stepper {
        StepperChoice::Fem(fem) => fem.max_time = Some(seconds),
        StepperChoice::Gnn(_) => {
            return Err(argument_error(
                "--max-time is allowed only for finite elements: a network takes the same time for every grasp",
            ));
        }
    }
    Ok(())
}

fn argument_error(message: &str) -> Error {
    Error::Argument(message.into())
}
