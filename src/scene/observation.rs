//! Observations of an agent.

use super::defaults;
use super::leaf::{Count, Length};
use serde::{Deserialize, Serialize};

/// Observation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Observe {
    /// Image of the contact force on each pad, N.
    TaxelForce(Grid),
    /// Image of the displacement of the sensing face, m.
    TaxelDisplacement(Grid),
    /// Image of the normal traction on the sensing face, Pa: the pressure along the closing direction.
    Pressure(Grid),
    /// Image of the tangential traction on the sensing face, Pa.
    Shear(Grid),
    /// Image of the height of the deformed sensing face, m.
    HeightMap(Grid),
    /// Image of the depth of the object below the undeformed sensing face, m, without mechanics: as if the gel took the
    /// shape of the object.
    DepthMap(Grid),
    /// Markers printed on the sensing face: position and displacement, m, and position in the camera image, pixels.
    Markers(Markers),
    /// Centre of pressure of each pad, m.
    CenterOfPressure,
    /// Contact area of each pad, m2.
    ContactArea,
    /// Image of the fraction of the contact force that is carried by sliding points.
    Slip(Grid),
    /// Contact force and torque on each pad.
    Wrench,
    /// Travel of each finger since first contact, m.
    Travel,
    /// Pose of the object in the hand.
    ObjectPose,
    /// Closing force, the sum over the fingers, N.
    Force,
    /// Error bound of a network's prediction, estimated by the network.
    PredictionError,
}

impl Observe {
    /// Returns the name of the observation array.
    pub fn name(&self) -> &'static str {
        match self {
            Observe::TaxelForce(_) => "taxel_force",
            Observe::TaxelDisplacement(_) => "taxel_displacement",
            Observe::Pressure(_) => "pressure",
            Observe::Shear(_) => "shear",
            Observe::HeightMap(_) => "height_map",
            Observe::DepthMap(_) => "depth_map",
            Observe::Markers(_) => "markers",
            Observe::CenterOfPressure => "center_of_pressure",
            Observe::ContactArea => "contact_area",
            Observe::Slip(_) => "slip",
            Observe::Wrench => "wrench",
            Observe::Travel => "travel",
            Observe::ObjectPose => "object_pose",
            Observe::Force => "force",
            Observe::PredictionError => "prediction_error",
        }
    }

    /// Returns true if a tactile sensor measures the observation; runs and data sets can record only such observations.
    pub fn is_tactile(&self) -> bool {
        use Observe::{Force, ObjectPose, PredictionError, Travel, Wrench};
        !matches!(self, Wrench | Travel | ObjectPose | Force | PredictionError)
    }

    /// Default observations of an agent.
    pub const DEFAULT: [Observe; 4] =
        [Observe::TaxelForce(Grid::DEFAULT), Observe::Wrench, Observe::Travel, Observe::Force];
}

/// Grid of taxels along pad x (rows) and pad y (columns).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Grid {
    /// Number along pad x, the approach of the hand.
    pub rows: Count<1, 512>,
    /// Number along pad y, the finger width.
    pub cols: Count<1, 512>,
}

impl Grid {
    /// Default grid.
    pub const DEFAULT: Grid = Grid { rows: Count::new_unchecked(8), cols: Count::new_unchecked(8) };

    /// Returns the number of taxels.
    pub fn taxels(&self) -> usize {
        self.rows.get() * self.cols.get()
    }
}

impl Default for Grid {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Markers printed on the sensing face in rows and columns, each at the centre of a cell of a regular grid over the
/// face.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Markers {
    /// Number along pad x, the approach of the hand.
    pub rows: Count<1, 512>,
    /// Number along pad y, the finger width.
    pub cols: Count<1, 512>,
    /// Size of a camera pixel projected onto the sensing face, m; by default that of a GelSight Mini.
    pub pixel: Length,
}

impl Markers {
    /// Returns the grid with a marker at the centre of each cell.
    pub fn grid(&self) -> Grid {
        Grid { rows: self.rows, cols: self.cols }
    }
}

impl Default for Markers {
    fn default() -> Self {
        Self { rows: defaults::MARKER_ROWS, cols: defaults::MARKER_COLS, pixel: defaults::MARKER_PIXEL }
    }
}
