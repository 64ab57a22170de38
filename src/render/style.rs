//! What a picture shows and how it is labelled.

use crate::record::PadFrame;

/// Width of a picture, pixels.
pub const WIDTH: u32 = 1400;
/// Height of a picture, pixels.
pub const HEIGHT: u32 = 800;

/// The quantity that colours the pads.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Scalar {
    /// Nodal von Mises stress, shown in kPa.
    #[default]
    Stress,
    /// Length of the node displacement, shown in mm.
    Displacement,
    /// Length of the nodal contact force, shown in mN.
    ContactForce,
}

impl Scalar {
    /// Label with the unit of [`Scalar::values`].
    pub fn label(self) -> &'static str {
        match self {
            Scalar::Stress => "von Mises stress (kPa)",
            Scalar::Displacement => "displacement (mm)",
            Scalar::ContactForce => "contact force per node (mN)",
        }
    }

    /// Value per node: kPa, mm or mN.
    pub fn values(self, pad: &PadFrame) -> Vec<f64> {
        match self {
            Scalar::Stress => pad.von_mises_node.iter().map(|v| v * 1e-3).collect(),
            Scalar::Displacement => pad.displacement.iter().map(|u| u.length() * 1e3).collect(),
            Scalar::ContactForce => pad.contact_force.iter().map(|f| f.length() * 1e3).collect(),
        }
    }
}

/// How to draw a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Style {
    /// Quantity that colours the pads.
    pub scalar: Scalar,
    /// First line, e.g. `lemon, grasp 003`; force and travel are added below it.
    pub title: String,
    /// Ends of the colour bar, in the unit of [`Scalar::label`]; `None` spans 0 to the largest value of this frame.
    pub range: Option<(f64, f64)>,
    /// Arrows of the in-plane displacement on the sensing faces, as a tactile sensor's markers show it.
    pub markers: bool,
    /// Cut the 3-D view open through the middle of the pads, to show the stress inside the gel.
    pub cut: bool,
}

impl Default for Style {
    fn default() -> Self {
        Style { scalar: Scalar::Stress, title: "grasp".into(), range: None, markers: true, cut: true }
    }
}
