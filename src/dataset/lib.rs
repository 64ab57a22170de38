//! Data sets: many grasps of many objects, simulated in parallel, resumed after an interruption, and read one grasp at
//! a time.
//!
//! ```text
//! DIR/manifest.json                                   scene, versions, counts, failures, hashes     (manifest.rs)
//! DIR/splits.json                                     training and test poses                       (split.rs)
//! DIR/sensitivity.csv                                 sensitivity of grasps, if requested           (sensitivity.rs)
//! DIR/tactile_sensor.tet                              one pad                                       (compatible.rs)
//! DIR/dgn_dataset/OBJ/OBJ_processed.stl, OBJ_grasps.h5   object and hand poses; OBJ_sensor.tet if its pads differ
//! DIR/dgs_output/OBJ_<density>_tactus_<E>_<nu>_<load>.h5  frames of all grasps (arrays.rs, file.rs, places.rs)
//! DIR/.progress/OBJ/<grasp>.json                      finished grasps; removed at the end           (progress.rs)
//! ```
//!
//! The layout of `dgs_output` is that of DefGraspSim's tactile grasps, which public loaders read; the arrays
//! `_1_stacked_*` belong to that layout, all others to tactus. The file of an object is created at its full size under
//! a temporary name. At the end of a grasp its rows are written in place, followed by its record, which is written
//! atomically. A run that is killed at any moment is therefore resumed without loss of finished grasps and produces the
//! same bytes. The required disk space is known in advance.

pub mod arrays;
pub mod campaign;
pub mod compatible;
pub mod file;
pub mod inspect;
pub mod manifest;
mod plan;
pub mod progress;
mod queue;
pub mod reader;
pub mod recorder;
pub mod row_positions;
pub mod rows;
pub mod sampling;
pub mod sensitivity;
pub mod set;
pub mod split;
pub mod unfinished;

pub use campaign::Campaign;
pub use manifest::Manifest;
pub use plan::Selection;
pub use reader::{ObjectFile, StoredGrasp};
pub use recorder::DatasetObserver;
pub use set::DataSet;
pub use split::Splits;
