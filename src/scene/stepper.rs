//! Backend that computes the recorded frames of a scene.

use super::defaults;
use super::leaf::{Count, Length, Positive, Ratio};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Names of the models shipped with tactus. Only a plain name denotes a shipped model; `./NAME` is always a folder.
pub const SHIPPED_MODELS: [&str; 1] = ["universe"];

/// Choice of the backend.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename = "Stepper")]
pub enum StepperChoice {
    /// Finite element method: the reference.
    Fem(Fem),
    /// Trained graph neural network.
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
    /// Flag: mean dilatation (constant within each element), which avoids volumetric locking near nu = 0.5.
    pub mean_dilatation: bool,
    /// Unknowns of the solver: all nodes, or the nodes that can come into contact.
    pub solver: Solver,
    /// Finer mesh on which the pads are simulated; None is the mesh of `gripper.pads`. A data set then stores the
    /// solution of the finer mesh at the nodes of the mesh of `gripper.pads`, so that a network on the coarse mesh
    /// learns the finer solution. A run records the finer mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<FinerMesh>,
    /// Convergence tolerances of an increment.
    pub tolerance: Tolerance,
    /// Tolerance of the path error: relative error of the displacement due to the finite size of the load increments,
    /// because friction makes the solution path-dependent. It determines the number of increments, independent of the
    /// number of frames.
    pub path: Positive,
    /// Largest number of Newton iterations before an increment is halved.
    pub max_iterations: Count<1, 10000>,
    /// Largest number of Newton iterations of a grasp, or of a step of an agent; above it, the grasp ends as a fault,
    /// on every machine alike. None is a limit from `max_iterations` and the number of frames that only stops a grasp
    /// that does not converge; for a step of an agent it is ten times `max_iterations`, because all environments of a
    /// batch wait for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effort: Option<Count<1, 1000000>>,
    /// Limit of the wall time of a grasp, s; above it, the grasp ends as a fault. Which grasps it affects depends on
    /// the machine. None is no limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_time: Option<Positive>,
    /// Number of threads; None takes all threads of the machine.
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

/// Finer mesh of the pads. A pad from a file is meshed anew by a structured grid in its shape.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FinerMesh {
    /// Ratio of the mesh spacing of the pads to that of the finer mesh.
    pub finer: Positive,
    /// Ratio of the cell widths at the rim and at the centre of the finer mesh; 1 is uniform, as for pads from a file.
    #[serde(default = "defaults::pad_focus")]
    pub focus: Ratio,
}

/// Shape functions of a tetrahedron.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Element {
    /// Linear shape functions, 4 nodes: cheap, but subject to locking.
    Linear,
    /// Quadratic shape functions, 10 nodes: nodes at the edge midpoints are added.
    #[default]
    Quadratic,
}

/// Unknowns of the solver.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub enum Solver {
    /// All nodes: the reference.
    #[default]
    Full,
    /// The nodes that can come into contact; all others are eliminated (static condensation): fast, with an additional
    /// error. Not for dynamic scenes.
    Condensed(Condensed),
}

/// Pads condensed onto the nodes that can come into contact.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Condensed {
    /// Tolerance of the condensation: change of the displacement by one more correction with the full pad model, over
    /// the displacement.
    pub error: Positive,
}

impl Default for Condensed {
    fn default() -> Self {
        Self { error: defaults::CONDENSED_ERROR }
    }
}

/// Convergence tolerances of an increment; both must be met.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Tolerance {
    /// Residual force over the force of the loading.
    pub force: Positive,
    /// Largest displacement of any node in the last Newton step, m; by default
    /// [`DISPLACEMENT_TOLERANCE`](base::scales::DISPLACEMENT_TOLERANCE) of the contact offset.
    pub displacement: Option<Length>,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self { force: defaults::FORCE_TOLERANCE, displacement: None }
    }
}

impl StepperChoice {
    /// Returns the model of the network; None for finite elements.
    pub fn model(&self) -> Option<&Path> {
        match self {
            StepperChoice::Gnn(gnn) => Some(&gnn.model),
            StepperChoice::Fem(_) => None,
        }
    }

    /// Returns true if the scene allows a network to answer outside the range of its training.
    pub fn extrapolates(&self) -> bool {
        matches!(self, StepperChoice::Gnn(gnn) if gnn.extrapolate)
    }
}

/// Network backend.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gnn {
    /// Folder of the trained model, or the name of the shipped model: `universe`.
    pub model: PathBuf,
    /// Largest accepted relative error of the displacement. A grasp is computed by condensed finite elements instead if
    /// the 90 % error bound predicted by the network is larger, or if the network was not trained for the scene. None
    /// accepts every prediction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error_at_most: Option<Positive>,
    /// Flag: the network also answers outside the range of its training, where its error is unknown, instead of a
    /// refusal.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub extrapolate: bool,
}

impl Gnn {
    /// Creates the backend with a model; scenes outside the range of its training are refused.
    pub fn new(model: impl Into<PathBuf>) -> Self {
        Self { model: model.into(), error_at_most: None, extrapolate: false }
    }
}
