//! Evaluation of the expectations of a scene: an audit of recorded frames, and verdicts.

pub mod audit;
pub mod verdict;

pub use audit::{Auditor, Findings};
pub use verdict::{GraspMeasurements, Verdict, evaluate, evaluate_all};
