//! Output of a run.

use super::observation::Observe;
use serde::{Deserialize, Serialize};

/// Output of a run; by default everything except the gap and tactile observations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename = "Record", default, deny_unknown_fields)]
pub struct Record {
    /// Fields of each frame.
    pub fields: Vec<Field>,
    /// Tactile observations recorded in the arrays of runs and data sets.
    pub tactile: Vec<Observe>,
    /// Flag: PNG pictures are written.
    pub pictures: bool,
    /// Format of the file with the arrays of all frames; None writes no such file.
    pub arrays: Option<Arrays>,
    /// Flag: ParaView files (VTU) are written.
    pub vtu: bool,
}

impl Default for Record {
    fn default() -> Self {
        Self {
            fields: Field::DEFAULT.to_vec(),
            tactile: Vec::new(),
            pictures: true,
            arrays: Some(Arrays::Npz),
            vtu: true,
        }
    }
}

/// Recorded field.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Field {
    /// Displacement of every pad node, m.
    Displacement,
    /// Von Mises stress, Pa.
    Stress,
    /// Contact force on every pad node, N.
    ContactForce,
    /// Signed distance of every pad node to the object, m.
    Gap,
    /// Pose of the rigid object.
    ObjectPose,
}

impl Field {
    /// All fields.
    pub const ALL: [Field; 5] =
        [Field::Displacement, Field::Stress, Field::ContactForce, Field::Gap, Field::ObjectPose];

    /// Fields recorded by default. The gap is left out, because it costs a distance query for every node.
    pub const DEFAULT: [Field; 4] = [Field::Displacement, Field::Stress, Field::ContactForce, Field::ObjectPose];
}

/// Format of the arrays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Arrays {
    /// NumPy `.npz` archive.
    Npz,
}
