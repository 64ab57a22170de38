//! Element `<fem>` of a link: soft body in the URDF dialect of Isaac Gym.

use super::package;
use super::tolerance::Deviation;
use super::urdf::origin;
use super::xml::XmlElement;
use glam::DAffine3;
use std::path::{Path, PathBuf};

/// Soft body of a link.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FemTag {
    /// Transform from mesh axes to link axes, m.
    pub pose: DAffine3,
    /// Density, kg/m3; None if not given.
    pub density: Option<f64>,
    /// Young's modulus, Pa.
    pub young: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Distance from the supporting body within which nodes are bonded, m.
    pub attach: f64,
    /// Path of the mesh.
    pub mesh: PathBuf,
    /// Scale factor from mesh units to metres.
    pub scale: f64,
}

/// Reads the soft body of a link of the URDF at `path`, if any; snaps its orientation to right angles within
/// `deviation`.
pub(super) fn read(path: &Path, link: &XmlElement, deviation: &mut Deviation) -> Result<Option<FemTag>, String> {
    let Some(fem) = link.child("fem") else { return Ok(None) };
    let number = |name: &str| fem.child(name).map_or(Ok(None), |child| child.number("value"));
    let owner = link.text("name").unwrap_or_default();
    let missing = |what: &str| fem.error(format_args!("of link {owner:?} has no <{what}=\"...\">"));
    let needed = |name: &str| number(name)?.ok_or_else(|| missing(&format!("{name} value")));
    let mesh = fem.child("tetmesh").ok_or_else(|| missing("tetmesh filename"))?;
    let mut pose = origin(fem)?;
    pose.matrix3 = deviation.snap_rotation(pose.matrix3);
    Ok(Some(FemTag {
        pose,
        density: number("density")?,
        young: needed("youngs")?,
        poisson: needed("poissons")?,
        attach: needed("attachDistance")?,
        mesh: package::file(path, mesh)?,
        scale: number("scale")?.unwrap_or(1.0),
    }))
}
