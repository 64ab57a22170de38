//! The incremental potential: its state, its terms, and their contributions to gradient and Hessian.

pub mod block;
pub mod cross;
pub mod drive;
pub mod edge;
pub mod inversion_barrier;
pub mod pad_inertia;
pub mod point_load;
pub mod rigid_inertia;
pub mod state;
pub mod stencil;
pub mod term;
pub mod time_step;
pub mod viscosity;
