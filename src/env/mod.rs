//! Environments for reinforcement learning, many at once: one scene with a [`task`](crate::scene::Task), N worlds.
//!
//! ```text
//! scene.ron -> EnvShared (models, grasps, sensors) -> N x Env (world, episode)  -> BatchEnv::step -> StepView
//!              shared.rs                              environment.rs, in parallel  batch.rs          view.rs
//!
//! a step of an Env:  action -> force, wrist, new grasp   (action.rs)
//!                    weight and pushes -> load           (load.rs)
//!                    one step of the world's schedule    (crate::world::environment)
//!                    frame -> slip, margin -> reward     (slip.rs, reward/)
//!                          -> arrays                     (crate::observe)
//! ```
//!
//! An interruption ([`crate::interrupt`]) leaves a batch without episodes, never with steps that count for some and not for others.
//! A forked process has lost the threads of its parent and starts its own (pool.rs).
//!
//! Differences between episodes are drawn by (seed, environment, episode) alone (draw.rs): neither the number of threads nor that
//! of environments changes a bit of any of them.
//!
//! The load on the object is weight and pushes. The FEM backend feels it: friction holds the object or does not. The network knows
//! friction only as it was in training. There the pads share the load out like the pressure, and the object is lost when the limit
//! surface of the grip is passed (slip.rs).

pub mod action;
pub mod batch;
pub mod config;
pub mod draw;
mod environment;
mod identity;
pub mod load;
mod picture;
mod pool;
pub mod reward;
pub mod shared;
pub mod slip;
pub mod snapshot;
pub mod view;

pub use crate::observe::ArraySpec;
pub use batch::BatchEnv;
pub use config::{Autoreset, BatchConfig};
pub use reward::StepInfo;
pub use snapshot::Snapshot;
pub use view::{StepError, StepView};
