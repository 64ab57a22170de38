//! View of the results of a step: borrowed from the batch, so that no one keeps arrays that the next step overwrites.

use super::reward::StepInfo;
use crate::observe::ArraySpec;

/// Array of all environments: (environments, shape of the spec).
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
    /// Returns the observations `name`: (environments, shape), row-major; None if the task has no such array.
    pub fn obs(&self, name: &str) -> Option<&'a [f32]> {
        self.0.arrays.iter().find(|a| a.spec.name == name).map(|a| a.now.as_slice())
    }

    /// Returns the last observations of the episodes that this step ended, where [`StepView::ended`] is true; elsewhere zero.
    pub fn final_obs(&self, name: &str) -> Option<&'a [f32]> {
        self.0.arrays.iter().find(|a| a.spec.name == name).map(|a| a.last.as_slice())
    }

    /// Returns the reward of each environment.
    pub fn reward(&self) -> &'a [f32] {
        &self.0.reward
    }

    /// Returns, per environment, true if the object is lost or the solver gave up.
    pub fn terminated(&self) -> &'a [bool] {
        &self.0.terminated
    }

    /// Returns, per environment, true if the episode was cut off.
    pub fn truncated(&self) -> &'a [bool] {
        &self.0.truncated
    }

    /// Returns, per environment, true if the episode ended in this step.
    pub fn ended(&self) -> &'a [bool] {
        &self.0.ended
    }

    /// Returns the reason why environment `env` has no state for this step: no equilibrium, or no feasible start. An object that
    /// leaves the hand is no fault. The last accepted state stands, and the episode is terminated.
    pub fn fault(&self, env: usize) -> Option<&'a str> {
        self.0.faults[env].as_deref()
    }

    /// Returns the information on the step from which each reward was computed.
    pub fn info(&self) -> &'a [StepInfo] {
        &self.0.info
    }
}

/// Error of a call that no environment can carry out. Nothing has changed then, except after an interruption.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{message}")]
pub struct StepError {
    /// Environment at fault; None if the call is at fault.
    pub env: Option<usize>,
    /// Message that says what is wrong and what is allowed.
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
