//! Files that a run writes, and how.

use geometry::Pose;
use record::render::Scalar;
use std::time::Duration;

/// Files that a run writes, and how.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordingOptions {
    /// True to write `frames/*.vtu` and `run.pvd`.
    pub vtu: bool,
    /// True to write `frames.csv`.
    pub csv: bool,
    /// True to write `arrays.npz`.
    pub arrays: bool,
    /// True if frames contain motion in time.
    pub moving: bool,
    /// True if frames contain the error bound of a prediction.
    pub predicted: bool,
    /// Scalar that colours `pads.png` of the last frame; None for no picture.
    pub picture: Option<Scalar>,
    /// Time between two writes of `arrays.npz`, or ten times the duration of a write if that is longer: a killed run
    /// loses at most the frames of this time.
    pub flush_after: Duration,
    /// True to replace an earlier run in the same directory instead of failing.
    pub overwrite: bool,
    /// Name of the object in the picture's title.
    pub object_name: String,
    /// Pose of each pad in the hand at zero travel: `x_hand = rotation * x_pad + position`; empty if not known.
    pub pads: Vec<Pose>,
    /// Numbers of the grasps in the order of `run.json`; those that are not listed follow by number.
    pub order: Vec<usize>,
}

impl Default for RecordingOptions {
    fn default() -> Self {
        RecordingOptions {
            vtu: true,
            csv: true,
            arrays: true,
            moving: false,
            predicted: false,
            picture: Some(Scalar::Stress),
            flush_after: Duration::from_secs(5),
            overwrite: false,
            object_name: "object".into(),
            pads: Vec::new(),
            order: Vec::new(),
        }
    }
}
