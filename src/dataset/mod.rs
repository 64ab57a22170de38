//! Data sets: many grasps of many objects, simulated in parallel, never lost, read back one grasp at a time.
//!
//! ```text
//! DIR/manifest.json                                   scene, versions, counts, failures, hashes     (manifest.rs)
//! DIR/splits.json                                     training and test poses                       (split.rs)
//! DIR/sensitivity.csv                                 how well posed grasps are, if asked for       (sensitivity.rs)
//! DIR/tactile_sensor.tet                              one pad                                       (compatible.rs)
//! DIR/dgn_dataset/OBJ/OBJ_processed.stl, OBJ_grasps.h5   object and hand poses; OBJ_sensor.tet where its pads are not those above
//! DIR/dgs_output/OBJ_<density>_tactus_<E>_<nu>_<load>.h5  all frames of all grasps of one object    (arrays.rs, file.rs, places.rs)
//! DIR/.progress/OBJ/<grasp>.json                      grasps finished so far; gone at the end       (progress.rs)
//! ```
//!
//! The layout of `dgs_output` is that of DefGraspSim's tactile grasps, which public loaders read; its arrays
//! `_1_stacked_*` belong to that layout, all others to tactus. The file of an object is laid out once, at its full size,
//! under a temporary name. A grasp that ends writes its rows to their place and then its record, whole or not at all. A
//! run that is killed at any moment therefore continues from where it was and ends with the same bytes. The required disk
//! space is known beforehand.

pub mod arrays;
pub mod campaign;
pub mod compatible;
pub mod file;
pub mod inspect;
pub mod manifest;
pub mod places;
mod plan;
pub mod progress;
mod queue;
pub mod reader;
pub mod recorder;
pub mod rows;
pub mod sampling;
pub mod sensitivity;
pub mod set;
pub mod so_far;
pub mod split;

pub use campaign::Campaign;
pub use manifest::Manifest;
pub use plan::Selection;
pub use reader::{ObjectFile, StoredGrasp};
pub use recorder::Watcher;
pub use set::DataSet;
pub use split::Splits;
