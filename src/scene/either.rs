//! Short form of values with one main path: `File("a.h5")` stands for `File(path: "a.h5")`.

use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, MapAccess, Visitor};
use std::marker::PhantomData;
use std::path::PathBuf;

/// Value that can be read from one path or from its fields.
pub(super) trait PathOrFields<'de>: Sized {
    /// Creates the value with this path and all defaults.
    fn from_path(path: PathBuf) -> Self;
    /// Reads the value from its fields with the derived deserialiser.
    fn from_fields<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error>;
}

/// Reads either form.
pub(super) fn path_or_fields<'de, D: Deserializer<'de>, T: PathOrFields<'de>>(deserializer: D) -> Result<T, D::Error> {
    deserializer.deserialize_any(Either(PhantomData::<T>))
}

struct Either<T>(PhantomData<T>);

impl<'de, T: PathOrFields<'de>> Visitor<'de> for Either<T> {
    type Value = T;
    fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str("a path in quotes, or fields with `path: \"...\"`")
    }
    fn visit_str<E: serde::de::Error>(self, v: &str) -> Result<T, E> {
        Ok(T::from_path(PathBuf::from(v)))
    }
    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
        T::from_fields(MapAccessDeserializer::new(map))
    }
}
