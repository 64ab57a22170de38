//! RON dialect of scene files; serialisation and deserialisation of complete scenes.

use super::check;
use super::objects::Name;
use super::schema::{Scene, ScenePart};
use base::error::{Error, Result};
use ron::extensions::Extensions;
use serde::Deserialize;

/// Returns the RON dialect of scene files, for reading and writing: `Some` is implicit, and newtype variants such as
/// `Sphere(radius: 1)` need no double parentheses.
pub fn options() -> ron::Options {
    ron::Options::default()
        .with_default_extension(Extensions::IMPLICIT_SOME)
        .with_default_extension(Extensions::UNWRAP_VARIANT_NEWTYPES)
}

/// Returns the scene as RON text with all defaults written out; it loads as the same scene.
///
/// # Errors
/// Fails if the scene cannot be serialised.
pub fn to_ron(scene: &Scene) -> Result<String> {
    let pretty = ron::ser::PrettyConfig::new().indentor("    ").compact_arrays(true);
    options()
        .to_string_pretty(scene, pretty)
        .map(|text| format!("{text}\n"))
        .map_err(|e| Error::Scene(format!("error: the scene cannot be written as RON: {e}")))
}

/// Reads a scene written by [`to_ron`]; its paths are not resolved.
///
/// # Errors
/// Fails if the text is not a complete scene.
pub fn from_ron(text: &str) -> Result<Scene> {
    complete(options().from_str(text).map_err(|e| Error::Scene(format!("error: not a scene: {e}")))?)
}

/// Reads the scene of a `run.json`; its paths are not resolved.
///
/// # Errors
/// Fails if the value is not a complete scene.
pub fn from_json(value: &serde_json::Value) -> Result<Scene> {
    complete(ScenePart::deserialize(value).map_err(|e| Error::Scene(format!("error: not a scene: {e}")))?)
}

fn complete(part: ScenePart) -> Result<Scene> {
    let mut scenes = part
        .complete(&Name::near("scene"))
        .map_err(|field| Error::Scene(format!("error: incomplete scene: missing field `{field}`")))?;
    scenes.iter().try_for_each(|named| recheck(&named.scene))?;
    Ok(scenes.swap_remove(0).scene)
}

/// Checks a complete scene again after a change.
///
/// # Errors
/// Fails if a field is inconsistent with the others.
pub fn recheck(scene: &Scene) -> Result<()> {
    check::check(scene).map_err(|p| Error::Scene(format!("error: {}: {}", p.path, p.message)))
}
