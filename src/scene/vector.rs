//! Vectors, written `(x, y, z)` or `[x, y, z]`.

use super::leaf::{Count, Finite, Length};
use glam::DVec3;
use serde::de::{Deserialize, DeserializeOwned, Deserializer, Error as _, SeqAccess, Visitor};
use serde::{Serialize, Serializer};
use std::marker::PhantomData;

/// Fixed number of leaves, written `(a, b, c)` or `[a, b, c]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tuple<T, const N: usize>(pub [T; N]);

/// Vector of finite numbers, in the unit of its field.
pub type Vec3 = Tuple<Finite, 3>;
/// Pair of finite numbers, in the unit of its field.
pub type Vec2 = Tuple<Finite, 2>;
/// Direction: three numbers, not all zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Direction(Vec3);

/// Three lengths above zero, m.
pub type Size = Tuple<Length, 3>;
/// Numbers of cells along x, y, z.
pub type Cells = Tuple<Count<1, 400>, 3>;

impl Vec3 {
    /// Returns the tuple as a glam vector.
    pub fn dvec3(self) -> DVec3 {
        DVec3::from_array(self.0.map(Finite::get))
    }
    /// Returns the tuple of a glam vector.
    ///
    /// # Errors
    /// Fails if a component is not finite.
    pub(super) fn of(v: DVec3) -> Result<Self, String> {
        Ok(Tuple([Finite::new(v.x)?, Finite::new(v.y)?, Finite::new(v.z)?]))
    }
    pub(crate) const fn new_unchecked3(x: f64, y: f64, z: f64) -> Self {
        Tuple([Finite::new_unchecked(x), Finite::new_unchecked(y), Finite::new_unchecked(z)])
    }
}

impl Direction {
    /// Returns the unit vector.
    pub fn unit(self) -> DVec3 {
        self.0.dvec3().normalize()
    }
    pub(crate) const fn new_unchecked3(x: f64, y: f64, z: f64) -> Self {
        Self(Vec3::new_unchecked3(x, y, z))
    }
}

impl Serialize for Direction {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Direction {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let vector = Vec3::deserialize(deserializer)?;
        match vector.dvec3().try_normalize() {
            Some(_) => Ok(Self(vector)),
            None => Err(D::Error::custom("a direction of length zero\n(0, 0, 1) is along +z")),
        }
    }
}

impl Vec2 {
    /// Returns the tuple as two numbers.
    pub fn pair(self) -> [f64; 2] {
        self.0.map(Finite::get)
    }
}

impl Size {
    /// Returns the tuple as a glam vector, m.
    pub fn size(self) -> DVec3 {
        DVec3::from_array(self.0.map(Length::get))
    }
    pub(crate) const fn new_unchecked_size(x: f64, y: f64, z: f64) -> Self {
        Tuple([Length::new_unchecked(x), Length::new_unchecked(y), Length::new_unchecked(z)])
    }
}

impl Cells {
    /// Returns the tuple as three counts.
    pub fn counts(self) -> [usize; 3] {
        self.0.map(Count::get)
    }
}

impl<T: Serialize, const N: usize> Serialize for Tuple<T, N> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeTuple;
        let mut tuple = serializer.serialize_tuple(N)?;
        for value in &self.0 {
            tuple.serialize_element(value)?;
        }
        tuple.end()
    }
}

impl<'de, T: DeserializeOwned + Copy, const N: usize> Deserialize<'de> for Tuple<T, N> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        // `deserialize_any` accepts both brackets: `deserialize_tuple` accepts only `(`, `deserialize_seq` only `[`
        deserializer.deserialize_any(TupleVisitor(PhantomData))
    }
}

pub(super) struct TupleVisitor<T, const N: usize>(pub(super) PhantomData<T>);

impl<'de, T: DeserializeOwned + Copy, const N: usize> Visitor<'de> for TupleVisitor<T, N> {
    type Value = Tuple<T, N>;
    fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{N} numbers {}", if N == 2 { "(a, b)" } else { "(x, y, z)" })
    }
    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
        let mut values = Vec::with_capacity(N);
        while values.len() < N {
            match seq.next_element()? {
                Some(value) => values.push(value),
                None => return Err(A::Error::invalid_length(values.len(), &self)),
            }
        }
        if seq.next_element::<f64>()?.is_some() {
            return Err(A::Error::custom(format!("expected {N} numbers, found more")));
        }
        values.try_into().map(Tuple).map_err(|_| A::Error::custom(format!("expected {N} numbers")))
    }
}
