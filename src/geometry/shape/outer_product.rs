//! Outer product of a vector with itself.

use glam::{DMat3, DVec3};

/// Computes `n n^T`, the projection onto the unit vector `n`.
pub fn outer(n: DVec3) -> DMat3 {
    DMat3::from_cols(n * n.x, n * n.y, n * n.z)
}
