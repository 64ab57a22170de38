//! Several objects in one scene file, each with its name; all other fields are shared unless an object has its own. For
//! data sets.

use super::grasps::Grasps;
use super::gripper::Gripper;
use super::leaf::Fraction;
use super::loading::Loading;
use super::object::Object;
use super::vector::Vec3;
use serde::de::{Deserializer, Error as _};
use serde::{Deserialize, Serialize};

/// Object of a scene file with several objects.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// Name of the object; the names of its files contain it.
    pub name: Name,
    /// Rigid object.
    pub object: Object,
    /// Grasps of the object; None takes the grasps of the scene.
    #[serde(default)]
    pub grasps: Option<Grasps>,
    /// Gripper for the object; None takes the gripper of the scene.
    #[serde(default)]
    pub gripper: Option<Gripper>,
    /// Loading of the object's grasps; None takes the loading of the scene.
    #[serde(default)]
    pub loading: Option<Loading>,
    /// Gravity for the object, m/s2; None takes the gravity of the scene.
    #[serde(default)]
    pub gravity: Option<Vec3>,
}

/// Name of letters, digits and `-`. An underscore is not allowed, because other programs take the part of a file name
/// before the first `_` as the object.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Name(String);

impl Name {
    /// Returns the name if it is allowed.
    ///
    /// # Errors
    /// Fails if the name is not allowed, with the message that a scene file would get.
    pub fn new(name: &str) -> Result<Self, String> {
        let fits = |c: char| c.is_ascii_alphanumeric() || c == '-';
        if (1..=64).contains(&name.len()) && name.chars().all(fits) && !name.starts_with('-') {
            return Ok(Self(name.into()));
        }
        Err(format!(
            "{name:?} is not a valid name of an object\nallowed: 1 to 64 letters, digits and `-` (no `_`, no space)"
        ))
    }

    /// Returns an allowed name similar to `text`: every character that is not allowed becomes `-`.
    pub fn near(text: &str) -> Self {
        let fit = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
        let name: String = text.chars().map(fit).take(64).collect();
        let name = name.trim_start_matches('-');
        Self(if name.is_empty() { "object".into() } else { name.into() })
    }

    /// Returns the text.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl<'de> Deserialize<'de> for Name {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::new(&String::deserialize(deserializer)?).map_err(D::Error::custom)
    }
}

/// Division of the grasps of each object into training and test sets.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Split {
    /// Fraction of the grasps of each object that is held out for the test set.
    pub test: Fraction,
    /// Seed of the division; the same seed gives the same division.
    pub seed: u64,
}

impl Default for Split {
    fn default() -> Self {
        Self { test: super::defaults::SPLIT_TEST, seed: 0 }
    }
}
