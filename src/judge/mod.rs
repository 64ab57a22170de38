//! Check of the promises of a scene: an audit of recorded frames, and the verdict.

pub mod audit;
pub mod verdict;

pub use audit::{Auditor, Findings};
pub use verdict::{Measured, Verdict, evaluate, evaluate_all};
