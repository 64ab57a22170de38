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
//! grasp changes). `docs/architecture.md` describes the crates, from the lowest layer up.
//!
//! A data set on disk is read one grasp at a time:
//!
//! ```no_run
//! # fn main() -> tactus::base::error::Result<()> {
//! let set = tactus::dataset::DataSet::open("out/paper")?;
//! set.damaged.iter().for_each(|refused| eprintln!("{refused}"));
//! for object in &set.objects {
//!     for grasp in object.reached() {
//!         let grasp = object.grasp(grasp)?;
//!         println!("{} {:?}", object.name, grasp.travel.last());
//!     }
//! }
//! # Ok(())
//! # }
//! ```

pub use ::bench;
pub use backend;
pub use base;
pub use cli;
pub use dataset;
pub use env;
pub use geometry;
pub use mech;
pub use model;
pub use net;
pub use record;
pub use report;
pub use scene;
pub use world;
