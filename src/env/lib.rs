//! Batched environments for reinforcement learning: one scene with a [`task`](scene::Task), N worlds.
//!
//! ```text
//! scene.ron -> EnvShared (models, grasps, sensors) -> N x Env (world, episode)  -> BatchEnv::step -> StepView
//!              shared.rs                              environment.rs, in parallel  batch.rs          view.rs
//!
//! a step of an Env:  action -> force, wrist, new grasp   (action.rs)
//!                    weight and pushes -> load           (load.rs)
//!                    one step of the world's schedule    (world::environment)
//!                    frame -> slip, margin -> reward     (slip.rs, reward/)
//!                          -> arrays                     (model::sensors)
//! ```
//!
//! An interruption ([`base::interrupt`]) discards the episodes of the whole batch, so that no environment is a step
//! ahead of another. A forked process does not inherit the threads of its parent and starts its own (pool.rs).
//!
//! Episode parameters depend on (seed, environment, episode) alone (draw.rs): results do not depend, bit for bit, on
//! the number of threads or environments.
//!
//! The load on the object is its weight and pushes. The FEM backend solves the contact with this load, so that friction
//! may fail to hold the object. The network represents friction only as in its training data: there the load is
//! distributed over the pads like the pressure, and the object is dropped when the load exceeds the limit surface of
//! the grip (slip.rs).

pub mod action;
pub mod batch;
pub mod config;
pub mod draw;
mod environment;
mod identity;
pub mod load;
mod object_kind;
mod picture;
mod pool;
pub mod reward;
pub mod shared;
pub mod slip;
pub mod snapshot;
pub mod view;

pub use batch::BatchEnv;
pub use config::{Autoreset, BatchConfig};
pub use model::sensors::ArraySpec;
pub use reward::StepInfo;
pub use snapshot::Snapshot;
pub use view::{StepError, StepView};
