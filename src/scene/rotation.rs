//! Rotations: `(w, x, y, z)` or `RpyDeg((roll, pitch, yaw))`.

use super::leaf::Finite;
use super::vector::{Tuple, TupleVisitor};
use base::number::format_number;
use glam::{DQuat, EulerRot};
use serde::de::{Deserialize, Deserializer, Error as _, SeqAccess, Visitor};
use serde::{Serialize, Serializer};
use std::marker::PhantomData;

/// Rotation, stored as a unit quaternion; written `(w, x, y, z)` (normalised when read) or `RpyDeg((roll, pitch, yaw))`
/// in degrees: roll about x, then pitch about y, then yaw about z, about fixed axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rotation(DQuat);

impl Rotation {
    /// Identity rotation.
    pub const IDENTITY: Self = Self(DQuat::IDENTITY);
    /// Returns the rotation as a glam quaternion of length 1.
    pub fn quat(self) -> DQuat {
        self.0
    }
    /// Returns the rotation of the quaternion (w, x, y, z), of any length except (nearly) zero.
    ///
    /// # Errors
    /// Fails if a number is not finite or the length is nearly zero.
    pub fn from_wxyz([w, x, y, z]: [f64; 4]) -> Result<Self, String> {
        let longest = w.abs().max(x.abs()).max(y.abs()).max(z.abs());
        if !longest.is_finite() {
            return Err("a quaternion must be finite".into());
        }
        if longest < 1e-9 {
            return Err(
                "a quaternion of length zero is not a rotation\nthe identity is (1, 0, 0, 0): the order is (w, x, y, z)"
                    .into(),
            );
        }
        // scaled by the largest component first, so that large numbers do not overflow when squared
        let q = DQuat::from_xyzw(x / longest, y / longest, z / longest, w / longest);
        // a unit quaternion is not normalised again, so that a written rotation is read back bit by bit
        let unit = DQuat::from_xyzw(x, y, z, w);
        Ok(Self(if (unit.length() - 1.0).abs() < 1e-15 { unit } else { q.normalize() }))
    }
    /// Returns the rotation by roll, pitch, yaw about fixed x, y, z, degrees.
    pub fn from_rpy_deg([r, p, y]: [f64; 3]) -> Self {
        Self(DQuat::from_euler(EulerRot::ZYX, y.to_radians(), p.to_radians(), r.to_radians()))
    }
}

impl Default for Rotation {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Serialize for Rotation {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        (self.0.w, self.0.x, self.0.y, self.0.z).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Rotation {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(RotationVisitor)
    }
}

/// Visitor of the elements inside the parentheses: RON drops the name before them. The name `RpyDeg` is checked in the
/// source text (`lint.rs`).
struct RotationVisitor;

impl<'de> Visitor<'de> for RotationVisitor {
    type Value = Rotation;
    fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str("a rotation (w, x, y, z) or RpyDeg((roll, pitch, yaw))")
    }
    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
        let Some(first) = seq.next_element::<NumberOrTriple>()? else {
            return Err(A::Error::invalid_length(0, &self));
        };
        let w = match first {
            NumberOrTriple::Triple(angles) => {
                return match seq.next_element::<f64>()? {
                    None => Ok(Rotation::from_rpy_deg(angles)),
                    Some(_) => Err(A::Error::custom("expected only three angles in RpyDeg((roll, pitch, yaw))")),
                };
            }
            NumberOrTriple::Number(w) => w,
        };
        let mut wxyz = [w, 0.0, 0.0, 0.0];
        for i in 1..4 {
            match seq.next_element::<Finite>()? {
                Some(value) => wxyz[i] = value.get(),
                None => return Err(A::Error::invalid_length(i, &self)),
            }
        }
        if seq.next_element::<f64>()?.is_some() {
            return Err(A::Error::custom("expected four numbers (w, x, y, z), found more"));
        }
        Rotation::from_wxyz(wxyz).map_err(A::Error::custom)
    }
}

enum NumberOrTriple {
    Number(f64),
    Triple([f64; 3]),
}

impl<'de> Deserialize<'de> for NumberOrTriple {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(NumberOrTripleVisitor)
    }
}

struct NumberOrTripleVisitor;

impl<'de> Visitor<'de> for NumberOrTripleVisitor {
    type Value = NumberOrTriple;
    fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str("a number or three angles")
    }
    fn visit_f64<E: serde::de::Error>(self, v: f64) -> Result<Self::Value, E> {
        if !v.is_finite() {
            return Err(E::custom(format!("must be a finite number, found {}", format_number(v))));
        }
        Ok(NumberOrTriple::Number(v))
    }
    fn visit_u64<E: serde::de::Error>(self, v: u64) -> Result<Self::Value, E> {
        Ok(NumberOrTriple::Number(v as f64))
    }
    fn visit_i64<E: serde::de::Error>(self, v: i64) -> Result<Self::Value, E> {
        Ok(NumberOrTriple::Number(v as f64))
    }
    fn visit_seq<A: SeqAccess<'de>>(self, seq: A) -> Result<Self::Value, A::Error> {
        let Tuple(angles) = TupleVisitor::<Finite, 3>(PhantomData).visit_seq(seq)?;
        Ok(NumberOrTriple::Triple(angles.map(Finite::get)))
    }
}
