//! Pictures of a grasp as PNG, rendered in software without a window or a GPU; the bytes are the same on every machine.
//!
//! `pads.rs` defines the layout; `surface.rs` evaluates surface points with the shape functions of the elements;
//! `face.rs` draws a sensing face, `view.rs` the 3-D section view; `raster.rs` is the z-buffer.

pub mod canvas;
mod colorbar;
pub mod colormap;
mod curves;
mod draw;
mod face;
mod normals;
mod pads;
mod pose;
mod raster;
mod section;
mod sheet;
mod style;
mod surface;
mod text;
mod view;

pub use curves::render_curves;
pub use pads::{encode, longest_arrow, render_pads, save};
pub use pose::pad_pose;
pub use style::{HEIGHT, Scalar, Style, WIDTH};
pub use tiny_skia::Pixmap;
