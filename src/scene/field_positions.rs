//! Positions of the fields of a scene in its files, shown by error messages.

use super::diagnose::Diagnosis;
use super::objects::Name;
use super::outline::Outline;
use base::error::Error;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Index of the source file that gives each field.
pub(super) type Origins = BTreeMap<&'static str, usize>;

/// Positions of the fields in the files of a scene.
#[derive(Debug)]
pub(super) struct FieldPositions {
    pub(super) sources: Vec<SceneText>,
    pub(super) origins: Origins,
    /// Names of the objects in the list `objects`, each with true if it has its own grasps; empty if the scene has one
    /// object.
    pub(super) listed: Vec<(Name, bool)>,
}

impl FieldPositions {
    pub(super) fn place(&self, error: Error, name: Option<&Name>) -> Error {
        let Error::Field { field, source } = error else { return error };
        let index = name.and_then(|name| self.listed.iter().position(|(own, _)| own == name));
        let text = source.to_string();
        self.error_at(&self.path_in_file(field, index), text.strip_prefix("error: ").unwrap_or(&text))
    }

    /// Returns the path of a field as written in the file: an object and its grasps may be an entry of the list of
    /// objects.
    pub(super) fn path_in_file(&self, field: &str, index: Option<usize>) -> String {
        let listed = index.and_then(|i| Some((i, self.listed.get(i)?.1)));
        match listed {
            _ if self.origins.contains_key("universe") && !field.starts_with("universe") => "universe".into(),
            Some((i, own)) if field.starts_with("object.") || (own && field.starts_with("grasps")) => {
                format!("objects[{i}].{field}")
            }
            _ => field.to_string(),
        }
    }

    /// Returns an error at a field, in the file that gives the field.
    pub(super) fn error_at(&self, field: &str, message: &str) -> Error {
        let first = field.split(['.', '[']).next().unwrap_or("");
        self.sources[self.origins.get(first).copied().unwrap_or(0)].error_at(field, message)
    }

    /// Returns the number of bytes of all files without the list of objects.
    pub(super) fn shared(&self) -> usize {
        let listed = self.origins.get("objects").map_or(0, |at| self.sources[*at].length("objects"));
        self.sources.iter().map(|s| s.text.len()).sum::<usize>() - listed
    }
}

/// A file of a scene.
#[derive(Debug)]
pub(super) struct SceneText {
    pub(super) path: PathBuf,
    pub(super) text: String,
}

impl SceneText {
    pub(super) fn error(&self, diagnosis: &Diagnosis) -> Error {
        Error::Scene(diagnosis.render(&self.path, &self.text))
    }

    /// Returns the length of the value of a field of this file, bytes.
    pub(super) fn length(&self, field: &str) -> usize {
        Outline::of(&self.text).find(field).map_or(0, |e| e.value.len())
    }

    /// Returns an error at a field of this file; the message names the field.
    pub(super) fn error_at(&self, field: &str, message: &str) -> Error {
        let span = Outline::of(&self.text).find(field).map_or(0..0, |e| e.value.clone());
        self.error(&Diagnosis::new(&format!("{field}: {message}"), span))
    }
}
