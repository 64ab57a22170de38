//! Benchmarks: speed against error of all finite-element settings and networks on the same grasps, in one run.
//!
//! ```text
//! Scene -> sweep.rs (configurations), refinement_study.rs (reference and its error), density.rs (coarser, finer pads)
//!       -> comparison.rs (round robin: time; error against the reference, record::error_norm)
//!       -> report.rs (medians, Pareto front, speed-up at equal error) -> table.rs, chart.rs, JSON, CSV
//! Scene -> refinement_study.rs -> values.rs (numbers of a frame) -> certify.rs (table of certified references)
//! Scene -> sizes.rs (cost against size of the pad)
//! Task  -> rollout.rs (steps a second against environments and threads)
//! ```

pub mod certify;
pub mod chart;
pub mod clock;
pub mod comparison;
pub mod density;
mod entry;
pub mod fit;
mod pareto_front;
mod quantity;
pub mod refinement_study;
pub mod report;
pub mod rollout;
mod settings;
pub mod sizes;
pub mod snapshots;
pub mod sweep;
pub mod table;
pub mod values;

pub use certify::certify;
pub use comparison::compare;
pub use report::BenchReport;
pub use rollout::rollouts;
pub use sizes::cost_by_size;
