//! Soft pad: a tetrahedral mesh in the pad frame with its bonded back face.
//!
//! [`generate`] makes box, disc and GelSight Mini pads; [`place`] imports a mesh from a file, and [`bonding`] selects
//! the bonded nodes.

pub mod bonding;
pub mod dome;
pub mod generate;
pub mod place;
pub mod remesh;
pub mod resolution;
mod validity;

pub use bonding::Bonding;
pub use generate::{GELSIGHT_MINI, GelProfile, box_pad, disc_pad, gelsight_mini};
pub use place::{PadPlacement, from_mesh, read_pad, read_pad_group};
pub use remesh::{PadShape, remesh};
pub use resolution::{Density, Resolution};

use glam::DVec3;

use crate::mesh::TetMesh;
use crate::mesh::surface::{self, BoundaryFace};

/// Lower bound of the z component of the outward unit normals of the sensing face.
pub const SENSING_SLOPE: f64 = 0.5;

/// Undeformed pad in the pad frame: origin at the centre of the sensing face, +z out of the gel towards the object,
/// back face bonded to the finger.
#[derive(Debug, Clone)]
pub struct PadMesh {
    /// Reference (undeformed) mesh in the pad frame, m.
    pub mesh: TetMesh,
    /// Flag per node: true if it is bonded to the finger.
    pub bonded: Vec<bool>,
}

impl PadMesh {
    /// Returns the depth of the deepest node below the sensing face, m.
    pub fn thickness(&self) -> f64 {
        self.mesh.nodes.iter().map(|x| -x.z).fold(0.0, f64::max)
    }
}

/// Returns the faces of the pad that can be in contact: all boundary faces except those with three bonded nodes.
pub fn free_surface(pad: &PadMesh) -> Vec<BoundaryFace> {
    free_faces(&pad.mesh, &pad.bonded)
}

/// Returns the faces that point towards the object: those of [`free_surface`] whose outward unit normal has z >
/// [`SENSING_SLOPE`].
pub fn sensing_faces(pad: &PadMesh) -> Vec<BoundaryFace> {
    free_surface(pad).into_iter().filter(|f| looks_along(&pad.mesh, f, DVec3::Z)).collect()
}

fn free_faces(mesh: &TetMesh, bonded: &[bool]) -> Vec<BoundaryFace> {
    let glued = |f: &BoundaryFace| f.nodes.iter().all(|i| bonded.get(*i as usize).copied().unwrap_or(false));
    surface::boundary(mesh).into_iter().filter(|f| !glued(f)).collect()
}

fn looks_along(mesh: &TetMesh, face: &BoundaryFace, axis: DVec3) -> bool {
    let [a, b, c] = face.nodes.map(|i| mesh.nodes[i as usize]);
    (b - a).cross(c - a).normalize_or_zero().dot(axis) > SENSING_SLOPE
}
