//! Tetrahedral elements: shape functions, quadrature, and the elastic kernel with mean dilatation.
//!
//! Both elements are sub-parametric (straight edges in the reference configuration), so that four barycentric gradients
//! and the volume describe an element; all terms of higher order follow from constant tables over the barycentric
//! coordinates.

mod kernel;
mod shape;
mod stiffness;

pub use kernel::Kernel;
pub use shape::{EDGES, ShapeFunctions, TET4, TET10, TET10_CENTER, TET10_NODES, tet10_values};
pub use stiffness::Stiffness;

use glam::{DMat3, DVec3};

/// Reference geometry of one tetrahedron.
#[derive(Debug, Clone, Copy)]
pub struct RestTet {
    /// Gradients of the barycentric coordinates, 1/m.
    pub gradient: [DVec3; 4],
    /// Volume, m3; positive.
    pub volume: f64,
}

impl RestTet {
    /// Computes the geometry from the reference positions of the four corners, m; the volume must be positive.
    pub fn new(x: [DVec3; 4]) -> Self {
        let d = DMat3::from_cols(x[1] - x[0], x[2] - x[0], x[3] - x[0]);
        let inverse = d.inverse().transpose();
        let [a, b, c] = [inverse.x_axis, inverse.y_axis, inverse.z_axis];
        Self { gradient: [-(a + b + c), a, b, c], volume: d.determinant() / 6.0 }
    }
}
