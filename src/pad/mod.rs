//! A soft pad: a tetrahedral mesh in the pad frame with its bonded back face.

use crate::mesh::TetMesh;

/// A pad at rest in the pad frame: origin at the centre of the sensing face, +z out of the gel towards the
/// object, back face bonded to the finger.
#[derive(Debug, Clone)]
pub struct Pad {
    /// Rest mesh in the pad frame, m.
    pub mesh: TetMesh,
    /// Per node: true if glued to the finger.
    pub bonded: Vec<bool>,
}
