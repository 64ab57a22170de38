//! Observations that an agent may ask for.

use super::defaults;
use super::leaf::{Count, Length};
use serde::{Deserialize, Serialize};

/// Observation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Observe {
    /// Contact force on the pads as an image, N.
    TaxelForce(Grid),
    /// Displacement of the sensing face as an image, m.
    TaxelDisplacement(Grid),
    /// Normal traction on the sensing face as an image, Pa: the pressure along the closing direction.
    Pressure(Grid),
    /// Tangential traction on the sensing face as an image, Pa.
    Shear(Grid),
    /// Height of the deformed sensing face as an image, m.
    HeightMap(Grid),
    /// Depth of the object in the undeformed sensing face as an image, m, as if it were a rigid mould.
    DepthMap(Grid),
    /// Dots printed on the sensing face: position and displacement, m, and place in the camera's image, pixels.
    Markers(Markers),
    /// Centre of pressure of each pad, m.
    CenterOfPressure,
    /// Area of each pad that touches the object, m2.
    ContactArea,
    /// Part of the contact force that is carried by points that slide, as an image.
    Slip(Grid),
    /// Force and torque on each pad.
    Wrench,
    /// Travel of each finger since first contact, m.
    Travel,
    /// Pose of the object in the hand.
    ObjectPose,
    /// Force that closes the fingers, N.
    Force,
    /// Error of a network's prediction, by its own account.
    PredictionError,
}

impl Observe {
    /// Returns true for what a tactile sensor sees, which runs and data sets record if they are asked to.
    pub fn is_tactile(&self) -> bool {
        use Observe::{Force, ObjectPose, PredictionError, Travel, Wrench};
        !matches!(self, Wrench | Travel | ObjectPose | Force | PredictionError)
    }

    /// Observations of an agent by default.
    pub const USUAL: [Observe; 4] =
        [Observe::TaxelForce(Grid::USUAL), Observe::Wrench, Observe::Travel, Observe::Force];
}

/// Taxels along the pad's x (rows) and y (columns).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Grid {
    /// Number along x of the pad, which is the hand's approach.
    pub rows: Count<1, 512>,
    /// Number along y of the pad.
    pub cols: Count<1, 512>,
}

impl Grid {
    /// Default grid.
    pub const USUAL: Grid = Grid { rows: Count::preset(8), cols: Count::preset(8) };

    /// Number of taxels.
    pub fn taxels(&self) -> usize {
        self.rows.get() * self.cols.get()
    }
}

impl Default for Grid {
    fn default() -> Self {
        Self::USUAL
    }
}

/// Dots printed on the sensing face in rows and columns, each amid its part of the face.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Markers {
    /// Number along x of the pad, which is the hand's approach.
    pub rows: Count<1, 512>,
    /// Number along y of the pad.
    pub cols: Count<1, 512>,
    /// Size of a pixel of the camera on the sensing face, m; by default that of a GelSight Mini.
    pub pixel: Length,
}

impl Markers {
    /// Grid with a marker amid each cell.
    pub fn grid(&self) -> Grid {
        Grid { rows: self.rows, cols: self.cols }
    }
}

impl Default for Markers {
    fn default() -> Self {
        Self { rows: defaults::MARKER_ROWS, cols: defaults::MARKER_COLS, pixel: defaults::MARKER_PIXEL }
    }
}
