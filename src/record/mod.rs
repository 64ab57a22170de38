//! Files of a run.
//!
//! ```text
//! DIR/run.json                          the run: scene, grasps, expectations, timings   (report.rs)   rewritten after every grasp
//! DIR/meshes.npz                        a pad and the object: no frame changes them      (meshes.rs)   written once
//! DIR/grasp_000/frames.csv              a row of numbers per frame, header with units   (csv.rs)      appended per frame
//! DIR/grasp_000/run.pvd                 open this in ParaView                           (pvd.rs)      rewritten per frame
//! DIR/grasp_000/frames/frame_0000.vtu   both pads                                       (vtu.rs)      written per frame
//! DIR/grasp_000/frames/object_0000.vtu  the object's surface                                        written where it has moved
//! DIR/grasp_000/arrays.npz              every array of the grasp                        (arrays.rs)   rewritten every few frames, read back by read.rs
//! DIR/grasp_000/pads.png                the last frame                                  (crate::render)
//! ```
//!
//! Everything except `frames.csv` is written beside its place and renamed, so a run that is killed leaves complete files. Files hold no
//! time stamps: the same run writes the same bytes, apart from the wall times in `run.json`. Numbers are finite or refused ([`check`]).

pub mod arrays;
pub mod check;
pub mod csv;
pub mod error_bound;
pub mod frame;
pub mod meshes;
pub mod names;
pub mod pvd;
pub mod read;
pub mod report;
pub mod sensitivity;
pub mod tactile;
pub mod vtu;

pub use error_bound::ErrorBound;
pub use frame::{ElementNodes, Frame, Moving, PadFrame, PadTopology, Wrench, pad_name};
pub use report::{ExpectationReport, GraspSummary, PadReport, RunReport, Status};
pub use tactile::TactileArray;
