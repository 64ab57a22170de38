//! Content and labels of a picture.

use crate::PadFrame;
use glam::DVec3;

/// Width of a picture, pixels.
pub const WIDTH: u32 = 1400;
/// Height of a picture, pixels.
pub const HEIGHT: u32 = 800;

/// Quantity that colours pads.
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
    /// Returns the label, with the unit of [`Scalar::values`].
    pub fn label(self) -> &'static str {
        match self {
            Scalar::Stress => "von Mises stress (kPa)",
            Scalar::Displacement => "displacement (mm)",
            Scalar::ContactForce => "contact force per node (mN)",
        }
    }

    /// Returns the value per node: kPa, mm or mN.
    pub fn values(self, pad: &PadFrame) -> Vec<f64> {
        match self.field(pad) {
            NodalValues::Numbers(numbers) => numbers,
            NodalValues::Vectors(vectors) => vectors.into_iter().map(DVec3::length).collect(),
        }
    }

    /// Returns the nodal values to be interpolated, in the same unit.
    pub(super) fn field(self, pad: &PadFrame) -> NodalValues {
        let scaled = |vectors: &[DVec3]| NodalValues::Vectors(vectors.iter().map(|v| *v * 1e3).collect());
        match self {
            Scalar::Stress => NodalValues::Numbers(pad.von_mises_node.iter().map(|v| v * 1e-3).collect()),
            Scalar::Displacement => scaled(&pad.displacement),
            Scalar::ContactForce => scaled(&pad.contact_force),
        }
    }

    /// Returns true if the quantity is interpolated with the shape functions of the elements. Nodal forces are
    /// integrals, not point values: corner and mid-edge nodes carry different fractions, so quadratic interpolation
    /// would oscillate.
    pub(super) fn is_field(self) -> bool {
        self != Scalar::ContactForce
    }
}

/// Nodal values.
pub(super) enum NodalValues {
    /// Numbers, one per node.
    Numbers(Vec<f64>),
    /// Vectors, one per node; their length is drawn.
    Vectors(Vec<DVec3>),
}

impl NodalValues {
    /// Returns the interpolated value at a point, given nodes and shape function values.
    pub fn at(&self, (nodes, phi): (&[u32], &[f64])) -> f64 {
        let pairs = || nodes.iter().zip(phi).map(|(n, w)| (*n as usize, *w));
        match self {
            NodalValues::Numbers(numbers) => pairs().map(|(n, w)| w * numbers[n]).sum(),
            NodalValues::Vectors(vectors) => pairs().map(|(n, w)| w * vectors[n]).sum::<DVec3>().length(),
        }
    }
}

/// Style of a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Style {
    /// Quantity that colours the pads of the 3-D view.
    pub scalar: Scalar,
    /// Quantity that colours the sensing faces. The default is the displacement, which a tactile sensor measures and
    /// which is continuous between elements, unlike stress.
    pub face: Scalar,
    /// Title, e.g. `lemon, grasp 003`; force and travel are printed below it.
    pub title: String,
    /// Colour range of the 3-D view, in the unit of [`Scalar::label`]; `None` spans 0 to the largest value of this
    /// frame.
    pub range: Option<(f64, f64)>,
    /// Colour range of the sensing faces, as in `range`.
    pub face_range: Option<(f64, f64)>,
    /// Flag: draw arrows of the in-plane displacement on the sensing faces, like the markers of a tactile sensor.
    pub markers: bool,
    /// In-plane displacement of the longest arrow, m; `None` uses the largest of this frame.
    pub longest: Option<f64>,
    /// Flag: cut the 3-D view through the middle of the pads, to show the stress inside the gel.
    pub cut: bool,
}

impl Default for Style {
    fn default() -> Self {
        Style {
            scalar: Scalar::Stress,
            face: Scalar::Displacement,
            title: "grasp".into(),
            range: None,
            face_range: None,
            markers: true,
            longest: None,
            cut: true,
        }
    }
}
