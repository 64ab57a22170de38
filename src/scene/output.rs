//! Output of a run.

use serde::{Deserialize, Serialize};

/// Output of a run; by default everything except the gaps.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename = "Record", default, deny_unknown_fields)]
pub struct Record {
    /// Fields of each frame.
    pub fields: Vec<Field>,
    /// Switch for PNG pictures.
    pub pictures: bool,
    /// Format of the file with the arrays of all frames; None writes none.
    pub arrays: Option<Arrays>,
    /// Switch for ParaView files.
    pub vtu: bool,
}

impl Default for Record {
    fn default() -> Self {
        Self { fields: Field::USUAL.to_vec(), pictures: true, arrays: Some(Arrays::Npz), vtu: true }
    }
}

/// Recorded field.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Field {
    /// Displacement of every soft node, m.
    Displacement,
    /// Von Mises stress, Pa.
    Stress,
    /// Contact force on every surface node, N.
    ContactForce,
    /// Signed distance of every soft node to the object, m.
    Gap,
    /// Pose of the rigid object.
    ObjectPose,
}

impl Field {
    /// All fields.
    pub const ALL: [Field; 5] =
        [Field::Displacement, Field::Stress, Field::ContactForce, Field::Gap, Field::ObjectPose];

    /// Fields recorded by default, without the gap: the distance of every node to the object costs a query each.
    pub const USUAL: [Field; 4] = [Field::Displacement, Field::Stress, Field::ContactForce, Field::ObjectPose];
}

/// Format of the arrays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Arrays {
    /// NumPy's zip of arrays.
    Npz,
}
