//! tactus: a parallel gripper with two soft visual-tactile pads squeezes a rigid object.
//!
//! ```text
//! scene.ron -> scene::load -> Model::build -> spawn -> World + Schedule -> run_grasps -> record
//!                             (shared, Arc)            one per grasp: Environment
//!
//!              Control -> Sense -> Advance -> Measure -> Record        (schedule.rs)
//!                                  FEM | network (fem/, gnn/)          (stepper.rs)
//! ```
//!
//! Start at [`components`] (what a world holds), [`schedule`] (what a step does) and [`model`] (what never changes).
#![warn(missing_docs)]

pub mod audit;
pub mod bench;
pub mod cli;
pub mod components;
pub mod contact;
pub mod dataset;
pub mod distance;
pub mod element;
pub mod env;
pub mod environment;
pub mod error;
pub mod fem;
pub mod fit;
pub mod gnn;
pub mod grasp;
pub mod gripper;
pub mod interrupt;
pub mod limits;
pub mod material;
pub mod mesh;
pub mod model;
pub mod pad;
pub mod random;
pub mod record;
pub mod regular_file;
pub mod render;
pub mod report;
pub mod runner;
pub mod scales;
pub mod scene;
pub mod schedule;
pub mod shape;
pub mod spawn;
pub mod stepper;
pub mod systems;
