//! Vector products for derivatives of rotations.

use glam::{DMat3, DVec3};

/// Matrix of `v -> c x v`.
pub fn cross_matrix(c: DVec3) -> DMat3 {
    DMat3::from_cols(DVec3::new(0.0, c.z, -c.y), DVec3::new(-c.z, 0.0, c.x), DVec3::new(c.y, -c.x, 0.0))
}

/// Outer product `a b'`.
pub fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// Second derivative in `w` of `f . (w x (w x r)) / 2`.
pub fn rotation_hessian(f: DVec3, r: DVec3) -> DMat3 {
    (outer(f, r) + outer(r, f)) * 0.5 - DMat3::IDENTITY * f.dot(r)
}
