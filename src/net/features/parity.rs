//! Parities of features under the mirrors of a pad.

use Parity::{Even, X, XY, Y};

/// Sign change of a feature under the mirrors x -> -x and y -> -y.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parity {
    /// No sign change.
    Even,
    /// Sign change under x -> -x.
    X,
    /// Sign change under y -> -y.
    Y,
    /// Sign change under each mirror, none under both.
    XY,
}

impl Parity {
    /// Returns the sign under the mirrors `x` and `y`.
    pub fn sign(self, (x, y): (bool, bool)) -> f32 {
        let flips = match self {
            Parity::Even => false,
            Parity::X => x,
            Parity::Y => y,
            Parity::XY => x != y,
        };
        if flips { -1.0 } else { 1.0 }
    }
}

/// Parities of a vector: (x, y, z).
pub const VECTOR: [Parity; 3] = [X, Y, Even];
/// Parities of a rotation vector (an axial vector): a mirror reverses the components that lie in its plane.
pub const ROTATION: [Parity; 3] = [Y, X, XY];
