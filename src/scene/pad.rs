//! Soft pads, generated or read from a file.

use super::bonding::BondingRule;
use super::defaults;
use super::either::{PathOrFields, path_or_fields};
use super::leaf::{Count, Fraction, Length, Positive, Ratio};
use super::stepper::FinerMesh;
use super::vector::{Cells, Size, Tuple, Vec3};
use crate::robot::SoftPad;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::path::PathBuf;

/// Soft pad in the pad frame: origin at the centre of the sensing face, +z out of the gel, back face bonded to the
/// finger. On the finger, pad x lies along the hand's approach (z) and pad y along the finger width (y).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Pads {
    /// Gel of a GelSight Mini, 25.25 x 20.75 x 4.0 mm.
    GelSightMini(GelSightMini),
    /// Box.
    Box(BoxPad),
    /// Round disc.
    Disc(DiscPad),
    /// Tetrahedral mesh from a file.
    File(FilePad),
}

impl Default for Pads {
    fn default() -> Self {
        Pads::GelSightMini(GelSightMini::default())
    }
}

impl Pads {
    /// Returns the relative error of the displacement for which the mesh is chosen; None if the scene states the mesh.
    pub fn accuracy(&self) -> Option<f64> {
        let wanted = match self {
            Pads::GelSightMini(g) => g.accuracy,
            Pads::Box(b) => b.accuracy,
            Pads::Disc(d) => d.accuracy,
            Pads::File(_) => None,
        };
        wanted.map(Fraction::get)
    }

    /// Returns the width of the cells at the rim over those at the centre.
    pub fn focus(&self) -> f64 {
        match self {
            Pads::GelSightMini(GelSightMini { focus, .. })
            | Pads::Box(BoxPad { focus, .. })
            | Pads::Disc(DiscPad { focus, .. }) => focus.get(),
            Pads::File(_) => defaults::PAD_FOCUS.get(),
        }
    }

    /// Returns the same pads with a finer mesh; None for those of a file.
    pub fn finer(&self, mesh: &FinerMesh) -> Option<Self> {
        let mut pads = self.clone();
        let divided = |spacing: Length| Length::new(spacing.get() / mesh.finer.get()).ok();
        match &mut pads {
            Pads::GelSightMini(g) => (g.spacing, g.focus) = (divided(g.mesh_spacing()), mesh.focus),
            Pads::Disc(d) => (d.spacing, d.focus) = (divided(d.mesh_spacing()), mesh.focus),
            Pads::Box(b) => {
                let more = |cells: usize| Count::new((cells as f64 * mesh.finer.get()).round().max(1.0) as u64).ok();
                let cells = b.cells.map(|cells| cells.counts().map(more));
                b.cells = cells.and_then(|[x, y, z]| Some(Tuple([x?, y?, z?])));
                (b.spacing, b.focus) = (divided(b.mesh_spacing()), mesh.focus);
            }
            Pads::File(_) => return None,
        }
        Some(pads)
    }

    /// Returns the same pads with this mesh instead of an accuracy; None keeps the present value.
    pub fn with_mesh(&self, spacing: Option<Length>, focus: Option<Ratio>) -> Self {
        let mut pads = self.clone();
        match &mut pads {
            Pads::GelSightMini(GelSightMini { accuracy, spacing: own, focus: old, .. })
            | Pads::Box(BoxPad { accuracy, spacing: own, focus: old, .. })
            | Pads::Disc(DiscPad { accuracy, spacing: own, focus: old, .. }) => {
                (*accuracy, *own, *old) = (None, spacing.or(*own), focus.unwrap_or(*old));
            }
            Pads::File(_) => {}
        }
        pads
    }
}

/// Gel of a GelSight Mini. Give `spacing` or `accuracy`, not both.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GelSightMini {
    /// Shape of the sensing face: flat, as simulators model it, or domed, like the real one.
    pub shape: GelShape,
    /// Smallest distance between nodes of the sensing face, m. If neither it nor `accuracy` is given: [`defaults::GELSIGHT_SPACING`].
    pub spacing: Option<Length>,
    /// Relative error of the displacement (L2 over the volume), an alternative to a spacing: spacing and focus are chosen for it from the
    /// object and the load, see [`crate::model::accuracy`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<Fraction>,
    /// Thickness of each layer over that of the layer before it, away from the sensing face; 1 is uniform.
    pub grading: Ratio,
    /// Width of the cells at the rim over those at the centre; 1 is uniform.
    pub focus: Ratio,
}

impl Default for GelSightMini {
    fn default() -> Self {
        Self {
            shape: GelShape::default(),
            spacing: None,
            accuracy: None,
            grading: defaults::PAD_GRADING,
            focus: defaults::PAD_FOCUS,
        }
    }
}

impl GelSightMini {
    /// Returns the spacing of the mesh if no accuracy asks for another.
    pub fn mesh_spacing(&self) -> Length {
        self.spacing.unwrap_or(defaults::GELSIGHT_SPACING)
    }
}

/// Shape of the sensing face of the GelSight Mini.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum GelShape {
    /// Plane.
    #[default]
    Flat,
    /// Dome with a radius of about 115 mm along the short side and 188 mm along the long one.
    Domed,
}

/// Box of gel. Give one of `cells`, `spacing` and `accuracy`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename = "Box", deny_unknown_fields)]
pub struct BoxPad {
    /// Edge lengths: x and y of the face, and z, the thickness, m.
    pub size: Size,
    /// Numbers of cells along x, y, z.
    #[serde(default)]
    pub cells: Option<Cells>,
    /// Smallest distance between nodes, m. If none of the three is given: [`defaults::PAD_SPACING`].
    #[serde(default)]
    pub spacing: Option<Length>,
    /// Relative error of the displacement (L2 over the volume), an alternative to a spacing: spacing and focus are chosen for it from the
    /// object and the load, see [`crate::model::accuracy`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<Fraction>,
    /// Thickness of each layer over that of the layer before it, away from the sensing face; 1 is uniform.
    #[serde(default = "defaults::pad_grading")]
    pub grading: Ratio,
    /// Width of the cells at the rim over those at the centre; 1 is uniform.
    #[serde(default = "defaults::pad_focus")]
    pub focus: Ratio,
}

impl BoxPad {
    /// Returns the spacing of the mesh if neither cells are given nor an accuracy asks for another.
    pub fn mesh_spacing(&self) -> Length {
        self.spacing.unwrap_or(defaults::PAD_SPACING)
    }
}

/// Round disc of gel. Give `spacing` or `accuracy`, not both.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename = "Disc", deny_unknown_fields)]
pub struct DiscPad {
    /// Radius, m.
    pub radius: Length,
    /// Thickness, m.
    pub thickness: Length,
    /// Distance between nodes, m. If neither it nor `accuracy` is given: [`defaults::DISC_SPACING`].
    #[serde(default)]
    pub spacing: Option<Length>,
    /// Relative error of the displacement (L2 over the volume), an alternative to a spacing: spacing and focus are chosen for it from the
    /// object and the load, see [`crate::model::accuracy`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<Fraction>,
    /// Thickness of each layer over that of the layer before it, away from the sensing face; 1 is uniform.
    #[serde(default = "defaults::pad_grading")]
    pub grading: Ratio,
    /// Width of the cells at the rim over those at the centre; 1 is uniform.
    #[serde(default = "defaults::pad_focus")]
    pub focus: Ratio,
}

impl DiscPad {
    /// Returns the spacing of the mesh if no accuracy asks for another.
    pub fn mesh_spacing(&self) -> Length {
        self.spacing.unwrap_or(defaults::DISC_SPACING)
    }
}

/// Pad from a tetrahedral mesh file; `File("pad.tet")` takes all defaults.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename = "File", remote = "Self", deny_unknown_fields)]
pub struct FilePad {
    /// Path of the mesh file.
    pub path: PathBuf,
    /// Name or tag of the physical volume of a gmsh file that is the gel; None takes all volumes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
    /// Direction out of the gel towards the object, in the file's axes; any length except zero.
    #[serde(default = "defaults::pad_outward")]
    pub outward: Vec3,
    /// Direction that becomes x of the pad, in the file's axes; None takes the file's x (its y if `outward` is along x).
    #[serde(default)]
    pub across: Option<Vec3>,
    /// Factor from the file's unit to metres.
    #[serde(default = "defaults::pad_scale")]
    pub scale: Positive,
    /// Rule for the nodes that are bonded to the finger; by default those on the back plane.
    #[serde(default)]
    pub bonded: BondingRule,
}

impl FilePad {
    /// Returns the pad of a robot.
    pub(super) fn of_robot(pad: &SoftPad) -> Result<Self, String> {
        Ok(Self {
            path: pad.mesh.clone(),
            group: None,
            outward: Vec3::of(pad.outward)?,
            across: Some(Vec3::of(pad.across)?),
            scale: Positive::new(pad.scale)?,
            bonded: BondingRule::Nodes(pad.bonded.clone()),
        })
    }
}

impl<'de> PathOrFields<'de> for FilePad {
    fn from_path(path: PathBuf) -> Self {
        let bonded = BondingRule::default();
        Self { path, group: None, outward: defaults::PAD_OUTWARD, across: None, scale: defaults::PAD_SCALE, bonded }
    }
    fn from_fields<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::deserialize(deserializer)
    }
}

impl<'de> Deserialize<'de> for FilePad {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        path_or_fields(deserializer)
    }
}

impl Serialize for FilePad {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        Self::serialize(self, serializer)
    }
}
