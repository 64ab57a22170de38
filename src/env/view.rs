//! What a step gives: borrowed from the batch, so that nobody keeps arrays that the next step writes.

use super::reward::StepInfo;
use super::spec::ArraySpec;

/// An array of all environments: (environments, shape of the spec).
#[derive(Debug, Clone)]
pub(crate) struct EnvArray {
    pub spec: ArraySpec,
    pub now: Vec<f32>,
    pub last: Vec<f32>,
}

/// What all environments gave.
#[derive(Debug, Clone, Default)]
pub(crate) struct Outputs {
    pub arrays: Vec<EnvArray>,
    pub reward: Vec<f32>,
    pub terminated: Vec<bool>,
    pub truncated: Vec<bool>,
    pub ended: Vec<bool>,
    pub faults: Vec<Option<String>>,
    pub facts: Vec<StepInfo>,
}

/// Results of a reset or step.
#[derive(Debug, Clone, Copy)]
pub struct StepView<'a>(pub(crate) &'a Outputs);

impl<'a> StepView<'a> {
    /// Observations by name: (environments, shape), row-major; None if the task has no such array.
    pub fn obs(&self, name: &str) -> Option<&'a [f32]> {
        self.0.arrays.iter().find(|a| a.spec.name == name).map(|a| a.now.as_slice())
    }

    /// Last observations of the episodes that this step ended, where [`StepView::ended`] says so; elsewhere zero.
    pub fn final_obs(&self, name: &str) -> Option<&'a [f32]> {
        self.0.arrays.iter().find(|a| a.spec.name == name).map(|a| a.last.as_slice())
    }

    /// Reward per environment.
    pub fn reward(&self) -> &'a [f32] {
        &self.0.reward
    }

    /// The object is lost, or the solver gave up.
    pub fn terminated(&self) -> &'a [bool] {
        &self.0.terminated
    }

    /// The episode was cut off.
    pub fn truncated(&self) -> &'a [bool] {
        &self.0.truncated
    }

    /// The episode ended in this step.
    pub fn ended(&self) -> &'a [bool] {
        &self.0.ended
    }

    /// Why environment `env` has no state for this step: no equilibrium, or no feasible start; an object that leaves the hand is no
    /// fault. The last accepted state
    /// stands, the episode is terminated.
    pub fn fault(&self, env: usize) -> Option<&'a str> {
        self.0.faults[env].as_deref()
    }

    /// What the rewards were made of.
    pub fn facts(&self) -> &'a [StepInfo] {
        &self.0.facts
    }
}

/// What no environment can do; nothing has changed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{message}")]
pub struct StepError {
    /// The environment at fault; None if it is the call.
    pub env: Option<usize>,
    /// What is wrong and what is allowed.
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
