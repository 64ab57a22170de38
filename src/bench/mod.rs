//! Speed against error: every setting of the finite elements and every network on the same grasps, in one run.
//!
//! ```text
//! Scene -> sweep.rs (configurations, reference) -> contest.rs (round robin: time; probe.rs: fields at common points;
//!          density.rs (pads coarser, finer)                     error.rs: against the reference)
//!       -> report.rs (medians, Pareto front, speed-up at equal error) -> table.rs, chart.rs, JSON, CSV
//! Scene -> sizes.rs (cost against size of the pad)
//! Task  -> rollout.rs (steps a second against environments and threads)
//! ```

pub mod canvas;
pub mod chart;
pub mod clock;
pub mod contest;
pub mod density;
pub mod error;
mod front;
pub mod probe;
pub mod report;
pub mod rollout;
pub mod sizes;
pub mod spread;
pub mod sweep;
pub mod table;

pub use contest::contest;
pub use report::Report;
pub use rollout::rollouts;
pub use sizes::cost_by_size;
