//! What an agent may ask to see.

use super::leaf::Count;
use serde::{Deserialize, Serialize};

/// An observation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Observe {
    /// Contact force on the pads as an image, N.
    TaxelForce(Grid),
    /// Displacement of the sensing face as an image, m.
    TaxelDisplacement(Grid),
    /// Force and torque on each pad.
    Wrench,
    /// Travel of each finger since first contact, m.
    Travel,
    /// Pose of the object in the hand.
    ObjectPose,
    /// Force that closes the fingers, N.
    Force,
}

impl Observe {
    /// What an agent sees unless said otherwise.
    pub const USUAL: [Observe; 4] =
        [Observe::TaxelForce(Grid::USUAL), Observe::Wrench, Observe::Travel, Observe::Force];
}

/// Taxels along the pad's x (rows) and y (columns).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Grid {
    /// Along x of the pad, which is the hand's approach.
    pub rows: Count<1, 512>,
    /// Along y.
    pub cols: Count<1, 512>,
}

impl Grid {
    /// Unless said otherwise.
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
