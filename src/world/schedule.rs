//! Schedule of a step: the sets of its systems in their order, and the resources that pass between them.
//!
//! ```text
//! Control  -> Sense            -> Advance        -> Accept   -> Measure                 -> Record
//! pose,       first contact,      FEM or network:   do the      contact, stress, energy,   frame,
//! load level  columns -> solver   state -> columns  pads meet   balance, wrench            next phase
//! ```
//!
//! A run of the schedule is one step of the published procedure, whose state is explicit ([`Phase`]): place the object
//! in the hand, close to first contact, then one recorded load level per step.

use bevy_ecs::prelude::*;
use bevy_ecs::schedule::ScheduleLabel;
use geometry::{Pose, Wrench};
use mech::path::continuation::MethodCounts;
use model::Model;
use record::{ErrorBound, Frame};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Sets of a step, run in this order.
#[derive(SystemSet, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum StepSet {
    /// Commands of the gripper: pose at the start, then the load of the next frame.
    Control,
    /// State at the start of the step: first contact; the solver reads its state from the columns.
    Sense,
    /// The stepper brings the state to the new load.
    Advance,
    /// Check that the model is valid in the state just reached.
    Accept,
    /// Results: contact forces, stress, energy, balance.
    Measure,
    /// The frame, and the phase of the next step.
    Record,
}

impl StepSet {
    /// All sets in their order.
    pub const ALL: [StepSet; 6] =
        [StepSet::Control, StepSet::Sense, StepSet::Advance, StepSet::Accept, StepSet::Measure, StepSet::Record];
}

/// Phase of a grasp in the procedure. It is constant during a step; `advance_phase` advances it at the end.
#[derive(Resource, Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Phase {
    /// The object is placed at its pose in the open hand.
    Place,
    /// The fingers close until their pads touch the object.
    Close,
    /// The load rises; the step computes this frame.
    Ramp {
        /// Number of the frame, from 0.
        frame: usize,
    },
    /// All frames are recorded.
    Done,
    /// The object left the grasp; the state is the last accepted one.
    Dropped {
        /// Reason, and load at which the object left.
        reason: String,
    },
    /// The stepper failed; the state is the last accepted one.
    Fault {
        /// Reason, and load at which the stepper failed.
        reason: String,
    },
    /// The grasp cannot start.
    Infeasible {
        /// Reason, and remedy.
        reason: String,
    },
}

impl Phase {
    /// Returns true when no further step changes anything.
    pub fn is_final(&self) -> bool {
        matches!(self, Phase::Done | Phase::Dropped { .. } | Phase::Fault { .. } | Phase::Infeasible { .. })
    }
}

/// Reason why a grasp ends before it reaches its load.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EarlyTermination {
    /// Flag: the object has left the grasp, as in reality; otherwise no solution was found, or the grasp could not
    /// start.
    pub dropped: bool,
    /// Reason, and load at which the grasp ends.
    pub reason: String,
}

impl EarlyTermination {
    /// Creates the stop of a solver that failed.
    pub fn fault(reason: impl Into<String>) -> Self {
        Self { dropped: false, reason: reason.into() }
    }
}

impl From<EarlyTermination> for Phase {
    fn from(EarlyTermination { dropped, reason }: EarlyTermination) -> Self {
        if dropped { Phase::Dropped { reason } } else { Phase::Fault { reason } }
    }
}

/// Phase of the next step, if a system of this step requested one. The first request applies.
#[derive(Resource, Debug, Default)]
pub struct NextPhase(Option<Phase>);

impl NextPhase {
    /// Requests `phase`, unless another one was requested before.
    pub fn request(&mut self, phase: Phase) {
        self.0.get_or_insert(phase);
    }

    /// Removes the requested phase and returns it.
    pub fn take(&mut self) -> Option<Phase> {
        self.0.take()
    }
}

/// Model, which is constant and shared with all other worlds of the scene.
#[derive(Resource, Debug, Clone)]
pub struct SharedModel(pub Arc<Model>);

/// Pose of the hand in the object frame.
#[derive(Resource, Debug, Clone, Copy)]
pub struct GraspPose(pub Pose);

/// Load given externally, step by step; without it the levels of the scene apply, one after the other.
#[derive(Resource, Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ForceCommand {
    /// Force per finger, N.
    pub force: f64,
}

/// Load of this step, for the stepper. Written by `set_load`.
#[derive(Resource, Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub struct StepLoad {
    /// Load per finger, N or m after first contact; in a dynamic scene the time, s.
    pub level: f64,
    /// Fraction of the push on the object that acts; zero without a push.
    pub push: f64,
}

/// Report of the stepper on the level that it has just reached.
#[derive(Resource, Debug, Clone, Copy, Serialize, Deserialize)]
pub struct StepReport {
    /// Flag: the level was reached in this step.
    pub reached: bool,
    /// Newton iterations (network passes) of this step.
    pub iterations: u32,
    /// Norm of the out-of-balance forces, N.
    pub residual: f64,
    /// Value of the potential, J.
    pub energy: f64,
    /// Smallest det F, see [`mech::body::Body::min_det_f`]; `+inf` if not measured.
    pub min_det_f: f64,
    /// Smallest gap between pads and object, m; `+inf` if not measured.
    pub min_gap: f64,
    /// Error bound that a network predicts for its own result; None for a computed state.
    pub error: Option<ErrorBound>,
}

impl Default for StepReport {
    fn default() -> Self {
        let [min_det_f, min_gap] = [f64::INFINITY; 2];
        Self { reached: false, iterations: 0, residual: 0.0, energy: 0.0, min_det_f, min_gap, error: None }
    }
}

/// Balance of the forces of a frame.
#[derive(Resource, Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub struct BalanceReport {
    /// Flag: the object is held fixed by a support outside the scene; then only the forces along the closing direction
    /// must balance, summed over the fingers.
    pub object_fixed: bool,
    /// Weight and push on the object: force and torque about its centre of mass, hand frame.
    pub load: Wrench,
    /// Sum over the fingers of the closing force, N.
    pub applied: f64,
    /// Unbalanced force over `applied`.
    pub force: f64,
    /// Unbalanced torque on a free object over `applied` times the object's bounding radius; 0 for a fixed object.
    pub torque: f64,
}

/// Time that the stepper has spent since the start of the grasp.
#[derive(Resource, Debug, Clone, Default)]
pub struct Timings {
    /// Wall time by stage, s.
    pub stages: BTreeMap<&'static str, f64>,
    /// Newton iterations, those of rejected increments included.
    pub iterations: u64,
    /// Counts of how often each method of the continuation was used.
    pub methods: MethodCounts,
}

/// Reason why this grasp fell back from the network to finite elements.
#[derive(Resource, Debug, Clone)]
pub struct FallbackReason(pub String);

/// The last recorded frame.
#[derive(Resource, Debug, Default)]
pub struct RecordedFrame(pub Option<Frame>);

/// Label of the only schedule of a world.
#[derive(ScheduleLabel, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct StepLabel;

/// Run condition: the step computes a frame.
pub fn computes_frame(phase: Res<Phase>) -> bool {
    matches!(*phase, Phase::Ramp { .. })
}

/// Run condition: the stepper reached the level of this step.
pub fn reached(report: Res<StepReport>) -> bool {
    report.reached
}
