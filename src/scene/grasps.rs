//! Grasps: poses of the hand relative to the object.

use super::convention::Convention;
use super::defaults;
use super::either::{PathOrFields, path_or_fields};
use super::leaf::{Count, NonNegative, Positive};
use super::rotation::Rotation;
use super::vector::Vec3;
use serde::de::{Deserializer, Error as _, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Serialize, Serializer};
use std::path::PathBuf;

/// Grasps of a scene. A pose is the pose of the hand in the object frame: `x_object = R(rotation) x_hand + position`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub enum Grasps {
    /// One grasp: hand axes parallel to the object axes, the object's origin midway between the pads.
    #[default]
    Identity,
    /// Poses given in the scene.
    List(Vec<ListedPose>),
    /// Poses from an HDF5 file such as `*_grasps.h5`: positions and quaternions, or 4 x 4 matrices.
    File(GraspFile),
    /// Grasps sampled from the object's surface.
    Antipodal(Antipodal),
}

/// Pose of the hand in the object frame. Give `position` or `centre`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[serde(rename = "Pose")]
pub struct ListedPose {
    /// Origin of the hand in the object frame, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position: Option<Vec3>,
    /// Point midway between the pads in the object frame, m, about which `rotation` rotates the hand:
    /// `position = centre - R(rotation) c`, with `c` the point midway between the pads in the hand frame, `(0, y, z)`
    /// of the gripper's `placement`. `(0, 0, 0)` places the origin of the object midway between the pads.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub centre: Option<Vec3>,
    /// Rotation from the hand frame to the object frame.
    #[serde(default)]
    pub rotation: Rotation,
}

/// Number of grasps.
pub type GraspCount = Count<1, 1000000>;

/// Parameters of grasps sampled from the object's surface.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Antipodal {
    /// Number of grasps.
    pub count: GraspCount,
    /// Seed of the sampling; the same seed gives the same grasps.
    #[serde(default)]
    pub seed: u64,
    /// Largest angle between the closing axis and the surface normals at the two contacts, degrees; limited to the
    /// angle of the friction cone.
    #[serde(default = "defaults::tilt")]
    pub tilt_deg: Positive,
    /// Largest offset of the pads' centre from the midpoint of the two contacts, along the length and along the width
    /// of the pads, over half of these; uniform. Zero centres the pads on the contacts, 1 is the rim of the pads.
    #[serde(default = "defaults::grasp_offset")]
    pub offset: NonNegative,
}

/// Grasps from a file; `File("x_grasps.h5")` takes all grasps of a file in the format of DefGraspSim.
///
/// The dataset has, for each grasp, a row [px, py, pz, qw, qx, qy, qz] (shape (N, 7)) or a matrix [R p; 0 1] (shape (N,
/// 4, 4)): the pose of the file's hand frame in the object frame, m.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename = "File", remote = "Self", deny_unknown_fields)]
pub struct GraspFile {
    /// Path of the HDF5 file.
    pub path: PathBuf,
    /// Name of the dataset in the file; None is `poses`.
    #[serde(default)]
    pub dataset: Option<String>,
    /// Convention of the poses; the default is that of DefGraspSim.
    #[serde(default)]
    pub convention: Convention,
    /// Selection of grasps by row, counted from 0; None selects all.
    #[serde(default)]
    pub select: Option<Select>,
}

impl GraspFile {
    /// Selects all grasps of a file in the format of DefGraspSim.
    pub fn new(path: PathBuf) -> Self {
        Self { path, dataset: None, convention: Convention::default(), select: None }
    }
}

impl<'de> PathOrFields<'de> for GraspFile {
    fn from_path(path: PathBuf) -> Self {
        Self::new(path)
    }
    fn from_fields<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::deserialize(deserializer)
    }
}

impl<'de> Deserialize<'de> for GraspFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        path_or_fields(deserializer)
    }
}

impl Serialize for GraspFile {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Self::serialize(self, serializer)
    }
}

/// Selection of grasps by row, counted from 0: `[0, 3, 7]` or `0..10` (10 not included).
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Select {
    /// Rows in this order.
    Rows(Vec<usize>),
    /// Rows from start up to, not including, end.
    Range(usize, usize),
}

impl Select {
    /// Returns the selected rows.
    pub fn rows(&self) -> Vec<usize> {
        match self {
            Select::Rows(rows) => rows.clone(),
            Select::Range(start, end) => (*start..*end).collect(),
        }
    }
}

/// Row index in a selection. The limit is far above the number of rows of any file, and low enough that a range cannot
/// exhaust memory.
type Row = Count<0, 10000000>;

#[derive(Serialize)]
struct Bounds {
    start: usize,
    end: usize,
}

impl Serialize for Select {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Select::Rows(rows) => rows.serialize(serializer),
            Select::Range(start, end) => Bounds { start: *start, end: *end }.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Select {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(SelectVisitor)
    }
}

struct SelectVisitor;

impl<'de> Visitor<'de> for SelectVisitor {
    type Value = Select;
    fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str("rows [0, 3, 7] or a range 0..10 (10 not included)")
    }
    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Select, A::Error> {
        let mut rows = Vec::new();
        while let Some(row) = seq.next_element::<Row>()? {
            rows.push(row.get());
        }
        if rows.is_empty() {
            return Err(A::Error::custom("selects no grasp\nleave `select` out to take all"));
        }
        Ok(Select::Rows(rows))
    }
    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Select, A::Error> {
        let (mut start, mut end) = (None, None);
        while let Some(key) = map.next_key::<String>()? {
            let slot = match key.as_str() {
                "start" => &mut start,
                "end" => &mut end,
                _ => return Err(A::Error::unknown_field(&key, &["start", "end"])),
            };
            *slot = Some(map.next_value::<Row>()?.get());
        }
        match (start.unwrap_or(0), end) {
            (start, Some(end)) if start < end => Ok(Select::Range(start, end)),
            (start, Some(end)) => Err(A::Error::custom(format!("range {start}..{end} selects no grasp"))),
            (start, None) => {
                Err(A::Error::custom(format!("range {start}.. has no end\nwrite {start}..{}", start + 10)))
            }
        }
    }
}
