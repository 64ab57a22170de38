//! Settings of a comparison.

/// Settings of a comparison.
#[derive(Debug, Clone, Copy)]
pub struct ComparisonSettings {
    /// Number of grasps, evenly spread over those of the scene; all if there are fewer.
    pub grasps: usize,
    /// Number of threads of each grasp; grasps run one at a time.
    pub threads: usize,
    /// Number of repetitions of each grasp by each configuration; times are medians.
    pub repeats: usize,
    /// Number of levels of the mesh refinement sequence from which the error of the reference is estimated.
    pub levels: usize,
}
