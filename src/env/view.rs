//! Results of a step, borrowed from the batch, so that arrays cannot be used after the next step has overwritten them.

use super::reward::StepInfo;
use model::sensors::ArraySpec;

/// Array of all environments: (environments, shape of the specification).
#[derive(Debug, Clone)]
pub(crate) struct EnvArray {
    pub spec: ArraySpec,
    pub now: Vec<f32>,
    pub last: Vec<f32>,
}

/// Outputs of all environments.
#[derive(Debug, Clone, Default)]
pub(crate) struct Outputs {
    pub arrays: Vec<EnvArray>,
    pub reward: Vec<f32>,
    pub terminated: Vec<bool>,
    pub truncated: Vec<bool>,
    pub ended: Vec<bool>,
    pub faults: Vec<Option<String>>,
    pub info: Vec<StepInfo>,
}

/// Results of a reset or step.
#[derive(Debug, Clone, Copy)]
pub struct StepView<'a>(pub(crate) &'a Outputs);

impl<'a> StepView<'a> {
    /// Returns the observation `name` as (environments, shape), row-major; None if the task has no such observation.
    pub fn obs(&self, name: &str) -> Option<&'a [f32]> {
        self.0.arrays.iter().find(|a| a.spec.name == name).map(|a| a.now.as_slice())
    }

    /// Returns the last observation of the episodes that ended in this step, where [`StepView::ended`] is true;
    /// elsewhere zero.
    pub fn final_obs(&self, name: &str) -> Option<&'a [f32]> {
        self.0.arrays.iter().find(|a| a.spec.name == name).map(|a| a.last.as_slice())
    }

    /// Returns the reward of each environment.
    pub fn reward(&self) -> &'a [f32] {
        &self.0.reward
    }

    /// Returns, per environment, true if the episode was terminated: the object was dropped or slipped too far, the
    /// solver failed, or there was no feasible start.
    pub fn terminated(&self) -> &'a [bool] {
        &self.0.terminated
    }

    /// Returns, per environment, true if the episode was truncated.
    pub fn truncated(&self) -> &'a [bool] {
        &self.0.truncated
    }

    /// Returns, per environment, true if the episode ended in this step.
    pub fn ended(&self) -> &'a [bool] {
        &self.0.ended
    }

    /// Returns the reason for which environment `env` has no state for this step: no equilibrium, or no feasible start.
    /// A dropped object is not a fault. The environment keeps the last accepted state.
    pub fn fault(&self, env: usize) -> Option<&'a str> {
        self.0.faults[env].as_deref()
    }

    /// Returns the step information from which each reward was computed.
    pub fn info(&self) -> &'a [StepInfo] {
        &self.0.info
    }
}

/// Error of a reset, step or restore. The state is unchanged, except after an interruption.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{message}")]
pub struct StepError {
    /// Environment that caused the error; None if the call itself is invalid.
    pub env: Option<usize>,
    /// Message that states what is wrong and what is allowed.
    pub message: String,
}

impl StepError {
    pub(crate) fn of(env: usize, message: impl std::fmt::Display) -> Self {
        Self { env: Some(env), message: format!("environment {env}: {message}") }
    }

    pub(crate) fn interrupted() -> Self {
        Self::call("interrupted; the environments have no episode now: reset them, or restore a snapshot")
    }

    pub(crate) fn call(message: impl Into<String>) -> Self {
        Self { env: None, message: message.into() }
    }
}
