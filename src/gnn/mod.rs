//! The graph network: trained on data sets, then a stepper like any other.
//!
//! ```text
//! Model + grasp -> touch.rs (first contact) -> features.rs (on graph.rs, volume.rs) -> network/ -> predict.rs -> answer.rs -> stepper.rs
//! a load         -> grip/ (rigid equilibrium on compliance.rs) -> settle.rs -> loads.rs (balance.rs) -> network/
//! data set      -> sample.rs: the same, and what FEM found             -> train/   -> card.rs (models/NAME), range.rs
//! ```

pub mod answer;
pub mod balance;
pub mod card;
pub mod compliance;
pub mod deviator;
pub mod dump;
pub mod edges;
pub mod eval;
pub mod features;
mod gemm;
pub mod graph;
pub mod grip;
pub mod infer;
pub mod kept;
pub mod ladder;
pub mod loads;
pub mod network;
pub mod normalise;
pub mod numbers;
pub mod ops;
pub mod parameters;
pub mod predict;
pub mod range;
pub mod real;
pub mod sample;
pub mod settle;
pub mod shipped;
pub mod spec;
pub mod stepper;
pub mod tape;
pub mod touch;
pub mod train;
pub mod volume;

pub use shipped::SHIPPED;
