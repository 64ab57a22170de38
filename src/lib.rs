//! tactus: a parallel gripper with two soft visual-tactile pads squeezes a rigid object.
//!
//! ```text
//! scene.ron -> scene::load -> Model::build -> spawn -> World + Schedule -> run_grasps -> record
//!                             (shared, Arc)            one per grasp: Environment
//!
//!              Control -> Sense -> Advance -> Accept -> Measure -> Record     (world/schedule.rs)
//!                                  FEM | network                              (backend/)
//! ```
//!
//! Start at [`world::components`] (data of a world), [`world::schedule`] (stages of a step) and [`model`] (data that no
//! grasp changes). `docs/architecture.md` describes the folders, from the lowest layer up.
#![warn(missing_docs)]

pub mod backend;
pub mod bench;
pub mod cli;
pub mod dataset;
pub mod distance;
pub mod env;
pub mod error;
pub mod files;
pub mod fit;
pub mod geometry;
pub mod grasp;
pub mod gripper;
pub mod history;
pub mod interrupt;
pub mod judge;
pub mod kernel;
pub mod limits;
pub mod linear;
pub mod mech;
pub mod model;
pub mod net;
pub mod number;
pub mod observe;
pub mod part;
pub mod random;
pub mod record;
pub mod render;
pub mod report;
pub mod robot;
pub mod run;
pub mod scales;
pub mod scene;
pub mod simulate;
pub mod stats;
pub mod table;
pub mod view;
pub mod world;
