//! Element `<include>`: replaced by the elements of another file.

use crate::robot::xml::{MAX_DEPTH, XmlElement, XmlReader};
use std::path::Path;

/// Replaces each `<include>` in `element`, at nesting depth `depth`, by the children of the root element of the file.
/// As in MuJoCo, paths are relative to `folder`, that of the main file, or if no such file exists to that of the
/// including file.
///
/// # Errors
/// Fails if a file cannot be read, is included recursively, or elements are nested too deeply.
pub(super) fn expand(
    element: &mut XmlElement,
    folder: &Path,
    depth: usize,
    reader: &mut XmlReader,
) -> Result<(), String> {
    if depth == MAX_DEPTH {
        return Err(element.error(format_args!("is nested in more than {MAX_DEPTH} elements")));
    }
    for mut child in std::mem::take(&mut element.children) {
        if child.tag != "include" {
            expand(&mut child, folder, depth + 1, reader)?;
            element.children.push(child);
            continue;
        }
        let file = child.required_text("file")?;
        let beside = child.folder().join(file);
        let path = Some(folder.join(file)).filter(|path| path.exists() || !beside.exists()).unwrap_or(beside);
        let included = reader.file(&path, Some(&child), |mut root, reader| {
            expand(&mut root, folder, depth, reader)?;
            Ok(root.children)
        })?;
        element.children.extend(included);
    }
    Ok(())
}
