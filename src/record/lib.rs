//! Files of a run.
//!
//! ```text
//! DIR/run.json                  scene, grasps, expectations, timings      (report.rs)      rewritten after every grasp
//! DIR/meshes.npz                constant meshes of pads and object        (meshes.rs)      written once
//! DIR/grasp_000/frames.csv      a row of numbers per frame, with units    (csv.rs)         appended per frame
//! DIR/grasp_000/run.pvd         open this in ParaView                     (pvd.rs)         rewritten per frame
//! DIR/grasp_000/frames/frame_0000.vtu   both pads                         (vtu.rs)         written per frame
//! DIR/grasp_000/frames/object_0000.vtu  the object's surface              (vtu.rs)         written if it has moved
//! DIR/grasp_000/arrays.npz      all arrays of the grasp (see read.rs)     (arrays.rs)      rewritten every few frames
//! DIR/grasp_000/pads.png        the last frame                            (crate::render)
//! ```
//!
//! Everything except `frames.csv` is written to a temporary file and renamed, so a killed run leaves complete files.
//! Files hold no time stamps: the same run writes the same bytes, apart from the wall times in `run.json`. Non-finite
//! numbers are refused ([`check`]).

pub mod arrays;
pub mod check;
pub mod csv;
pub mod error_bound;
pub mod error_norm;
pub mod field_transfer;
pub mod frame;
pub mod meshes;
pub mod names;
pub mod pvd;
pub mod read;
pub mod render;
pub mod report;
pub mod sensitivity;
mod status;
pub mod tactile;
pub mod vtu;

pub use error_bound::ErrorBound;
pub use field_transfer::FieldTransfer;
pub use frame::{DynamicState, ElementNodes, Frame, PadFrame, PadTopology, pad_name};
pub use report::{ExpectationReport, GraspSummary, PadReport, RunReport};
pub use status::Status;
pub use tactile::TactileArray;
