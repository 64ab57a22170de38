//! What advances the scene from one recorded frame to the next.

use super::defaults;
use super::leaf::{Count, Length, Positive};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Names of the models that ship with tactus: `./NAME` is a folder, a name never is.
pub const SHIPPED_MODELS: [&str; 2] = ["gelsight_mini", "gelsight_mini_fine"];

/// The backend.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename = "Stepper")]
pub enum StepperChoice {
    /// Finite elements: the reference.
    Fem(Fem),
    /// A trained network.
    Gnn(Gnn),
}

impl Default for StepperChoice {
    fn default() -> Self {
        StepperChoice::Fem(Fem::default())
    }
}

/// The finite element backend.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Fem {
    /// Shape functions of a tetrahedron.
    pub element: Element,
    /// Treat the dilatation of an element as constant, which avoids volumetric locking near nu = 0.5.
    pub mean_dilatation: bool,
    /// What is solved for: all nodes, or those that can touch.
    pub solver: Solver,
    /// When an increment counts as solved.
    pub tolerance: Tolerance,
    /// Error that the increments of the load may make where friction lets the answer depend on them, over the displacement: as many are
    /// taken as that asks for, whatever the number of frames.
    pub path: Positive,
    /// Newton iterations before an increment is halved.
    pub max_iterations: Count<1, 10000>,
    /// Wall time that a grasp may take, s; one that takes longer ends as a fault. What ends then depends on the machine. None is no limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_time: Option<Positive>,
    /// Threads; None is as many as the machine has.
    pub threads: Option<Count<1, 1024>>,
}

impl Default for Fem {
    fn default() -> Self {
        Self {
            element: Element::default(),
            mean_dilatation: defaults::MEAN_DILATATION,
            solver: Solver::default(),
            tolerance: Tolerance::default(),
            path: defaults::PATH,
            max_iterations: defaults::MAX_ITERATIONS,
            max_time: None,
            threads: None,
        }
    }
}

/// Shape functions of a tetrahedron.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Element {
    /// 4 nodes: cheap, and locks.
    Linear,
    /// 10 nodes: edge midpoints are inserted.
    #[default]
    Quadratic,
}

/// What is solved for.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub enum Solver {
    /// All nodes at once: the reference.
    #[default]
    Full,
    /// The nodes that can touch, the others eliminated: fast, with an error. Not in time.
    Condensed(Condensed),
}

/// Pads condensed onto where they can touch.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Condensed {
    /// Error accepted: by how much one more correction of the whole pad would change its displacement, over the displacement.
    pub error: Positive,
}

impl Default for Condensed {
    fn default() -> Self {
        Self { error: defaults::CONDENSED_ERROR }
    }
}

/// When an increment counts as solved: both must hold.
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

/// The network backend.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gnn {
    /// Folder of the trained model, or the name of one that ships: `gelsight_mini`, `gelsight_mini_fine`.
    pub model: PathBuf,
}
