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

/// Soft pad. Pad frame: origin at the centre of the sensing face, +z out of the gel, back face bonded to the finger.
/// When mounted, pad x lies along the hand's approach (hand z) and pad y along the finger width (hand y).
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
    /// Returns the relative error of the displacement for which the mesh is chosen; None if the scene specifies the
    /// mesh.
    pub fn accuracy(&self) -> Option<f64> {
        let wanted = match self {
            Pads::GelSightMini(g) => g.accuracy,
            Pads::Box(b) => b.accuracy,
            Pads::Disc(d) => d.accuracy,
            Pads::File(_) => None,
        };
        wanted.map(Fraction::get)
    }

    /// Returns the ratio of the cell widths at the rim and at the centre.
    pub fn focus(&self) -> f64 {
        match self {
            Pads::GelSightMini(GelSightMini { focus, .. })
            | Pads::Box(BoxPad { focus, .. })
            | Pads::Disc(DiscPad { focus, .. }) => focus.get(),
            Pads::File(_) => defaults::PAD_FOCUS.get(),
        }
    }

    /// Returns the same pads with a finer mesh; None for pads from a file.
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

    /// Returns the same pads with this spacing and focus instead of an accuracy; None keeps the present value.
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
    /// Shape of the sensing face: flat, as most simulators assume, or domed, as on the real sensor.
    pub shape: GelShape,
    /// Smallest node spacing of the sensing face, m. If neither it nor `accuracy` is given:
    /// [`defaults::GELSIGHT_SPACING`].
    pub spacing: Option<Length>,
    /// Target relative error of the displacement (L2 norm over the volume), an alternative to `spacing`: spacing and
    /// focus are then chosen from the object and the load.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<Fraction>,
    /// Ratio of the thicknesses of successive element layers, from the sensing face to the back; 1 is uniform.
    pub grading: Ratio,
    /// Ratio of the cell widths at the rim and at the centre of the sensing face; 1 is uniform.
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
    /// Returns the mesh spacing that applies without `accuracy`.
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
    /// Dome with a radius of curvature of about 115 mm along the short side and 188 mm along the long side.
    Domed,
}

/// Cuboid of gel. Give one of `cells`, `spacing` and `accuracy`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename = "Box", deny_unknown_fields)]
pub struct BoxPad {
    /// Edge lengths along pad x, y and z (z is the thickness), m.
    pub size: Size,
    /// Numbers of cells along x, y, z.
    #[serde(default)]
    pub cells: Option<Cells>,
    /// Smallest node spacing, m. If none of the three is given: [`defaults::PAD_SPACING`].
    #[serde(default)]
    pub spacing: Option<Length>,
    /// Target relative error of the displacement (L2 norm over the volume), an alternative to `spacing`: spacing and
    /// focus are then chosen from the object and the load.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<Fraction>,
    /// Ratio of the thicknesses of successive element layers, from the sensing face to the back; 1 is uniform.
    #[serde(default = "defaults::pad_grading")]
    pub grading: Ratio,
    /// Ratio of the cell widths at the rim and at the centre of the sensing face; 1 is uniform.
    #[serde(default = "defaults::pad_focus")]
    pub focus: Ratio,
}

impl BoxPad {
    /// Returns the mesh spacing that applies without `cells` and `accuracy`.
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
    /// Node spacing, m. If neither it nor `accuracy` is given: [`defaults::DISC_SPACING`].
    #[serde(default)]
    pub spacing: Option<Length>,
    /// Target relative error of the displacement (L2 norm over the volume), an alternative to `spacing`: spacing and
    /// focus are then chosen from the object and the load.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<Fraction>,
    /// Ratio of the thicknesses of successive element layers, from the sensing face to the back; 1 is uniform.
    #[serde(default = "defaults::pad_grading")]
    pub grading: Ratio,
    /// Ratio of the cell widths at the rim and at the centre of the sensing face; 1 is uniform.
    #[serde(default = "defaults::pad_focus")]
    pub focus: Ratio,
}

impl DiscPad {
    /// Returns the mesh spacing that applies without `accuracy`.
    pub fn mesh_spacing(&self) -> Length {
        self.spacing.unwrap_or(defaults::DISC_SPACING)
    }
}

/// Pad from a tetrahedral mesh file; `File("pad.tet")` uses all defaults.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename = "File", remote = "Self", deny_unknown_fields)]
pub struct FilePad {
    /// Path of the mesh file.
    pub path: PathBuf,
    /// Name or tag of the physical volume of a Gmsh file that is the gel; None takes all volumes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
    /// Outward normal of the sensing face, in the axes of the file; any nonzero length.
    #[serde(default = "defaults::pad_outward")]
    pub outward: Vec3,
    /// Direction of pad x, in the axes of the file; None takes the x axis of the file (its y axis if `outward` is along
    /// x).
    #[serde(default)]
    pub across: Option<Vec3>,
    /// Conversion factor from the unit of the file to metres.
    #[serde(default = "defaults::pad_scale")]
    pub scale: Positive,
    /// Selection of the nodes that are bonded to the finger; by default those on the back plane.
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
