//! Backend that advances the scene from one recorded frame to the next.

use super::defaults;
use super::leaf::{Count, Length, Positive, Ratio};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Names of the models that ship with tactus; `./NAME` is always a folder, a plain name never is.
pub const SHIPPED_MODELS: [&str; 1] = ["universe"];

/// Choice of the backend.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename = "Stepper")]
pub enum StepperChoice {
    /// Finite elements: the reference.
    Fem(Fem),
    /// Trained network.
    Gnn(Gnn),
}

impl Default for StepperChoice {
    fn default() -> Self {
        StepperChoice::Fem(Fem::default())
    }
}

/// Finite element backend.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Fem {
    /// Shape functions of a tetrahedron.
    pub element: Element,
    /// Constant dilatation within each element, which avoids volumetric locking near nu = 0.5.
    pub mean_dilatation: bool,
    /// Unknowns of the solver: all nodes, or those that can touch.
    pub solver: Solver,
    /// Finer mesh on which the pads are simulated; None is that of the pads. A data set then has the results of the finer mesh at the nodes
    /// of the pads, so that a network on these learns what the finer mesh knows. A run shows the finer mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<FinerMesh>,
    /// Tolerances of a solved increment.
    pub tolerance: Tolerance,
    /// Error that the increments of the load may cause where friction lets the answer depend on them, over the displacement: it sets the
    /// number of increments, whatever the number of frames.
    pub path: Positive,
    /// Largest number of Newton iterations before an increment is halved.
    pub max_iterations: Count<1, 10000>,
    /// Largest number of Newton iterations of a whole grasp, or of a step of an agent; a longer one ends as a fault, on every machine
    /// alike. None follows from `max_iterations` and the number of frames, and ends what would not end by itself; that of a step of an agent
    /// is ten times `max_iterations`, because all environments of a batch wait for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effort: Option<Count<1, 1000000>>,
    /// Wall time that a grasp may take, s; a longer one ends as a fault. Which grasps end then depends on the machine. None is no limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_time: Option<Positive>,
    /// Number of threads; None takes as many as the machine has.
    pub threads: Option<Count<1, 1024>>,
}

impl Default for Fem {
    fn default() -> Self {
        Self {
            element: Element::default(),
            mean_dilatation: defaults::MEAN_DILATATION,
            solver: Solver::default(),
            mesh: None,
            tolerance: Tolerance::default(),
            path: defaults::PATH,
            max_iterations: defaults::MAX_ITERATIONS,
            effort: None,
            max_time: None,
            threads: None,
        }
    }
}

/// Finer mesh of generated pads.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FinerMesh {
    /// Spacing of the pads over that of the finer mesh.
    pub finer: Positive,
    /// Width of its cells at the rim over those at the centre; 1 is uniform.
    #[serde(default = "defaults::pad_focus")]
    pub focus: Ratio,
}

/// Shape functions of a tetrahedron.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Element {
    /// Linear shape functions with 4 nodes: cheap, but they lock.
    Linear,
    /// Quadratic shape functions with 10 nodes: edge midpoints are inserted.
    #[default]
    Quadratic,
}

/// Unknowns of the solver.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub enum Solver {
    /// All nodes at once: the reference.
    #[default]
    Full,
    /// Nodes that can touch, with the others eliminated: fast, with an error. Not for dynamic scenes.
    Condensed(Condensed),
}

/// Pads condensed onto the nodes that can touch.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Condensed {
    /// Accepted error: change of the displacement by one more correction of the whole pad, over the displacement.
    pub error: Positive,
}

impl Default for Condensed {
    fn default() -> Self {
        Self { error: defaults::CONDENSED_ERROR }
    }
}

/// Tolerances of a solved increment; both must be met.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Tolerance {
    /// Residual force over the force of the loading.
    pub force: Positive,
    /// Largest Newton step of any node, m; by default [`DISPLACEMENT_TOLERANCE`](crate::scales::DISPLACEMENT_TOLERANCE) of the contact offset.
    pub displacement: Option<Length>,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self { force: defaults::FORCE_TOLERANCE, displacement: None }
    }
}

impl StepperChoice {
    /// Returns the model of a network.
    pub fn model(&self) -> Option<&Path> {
        match self {
            StepperChoice::Gnn(gnn) => Some(&gnn.model),
            StepperChoice::Fem(_) => None,
        }
    }

    /// Returns true if the scene asks a network to answer outside the range of its training.
    pub fn extrapolates(&self) -> bool {
        matches!(self, StepperChoice::Gnn(gnn) if gnn.extrapolate)
    }
}

/// Network backend.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gnn {
    /// Folder of the trained model, or the name of the one that ships: `universe`.
    pub model: PathBuf,
    /// Largest error of the displacement that is accepted. Where nine of ten such predictions are not that good, and where the network was
    /// not trained for the scene, condensed finite elements compute the grasp. None takes every prediction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error_at_most: Option<Positive>,
    /// Answers outside the range of the training, where the error is unknown, in place of a refusal.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub extrapolate: bool,
}

impl Gnn {
    /// Creates the backend with a model; scenes outside its range are refused.
    pub fn new(model: impl Into<PathBuf>) -> Self {
        Self { model: model.into(), error_at_most: None, extrapolate: false }
    }
}
