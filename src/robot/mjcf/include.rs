//! The tag `<include>`: the elements of another file in its place.

use crate::robot::xml::{DEPTH, XmlElement, XmlReader};
use std::path::Path;

/// Replaces each `<include>` in `element`, which stands in `depth` others, by what the file has in its outermost element. As in MuJoCo, paths
/// start at `folder`, that of the main file, and where nothing is there at that of the file with the `<include>`.
///
/// # Errors
/// Fails if a file cannot be read, is included in a circle, or elements stand in too many others.
pub(super) fn expand(
    element: &mut XmlElement,
    folder: &Path,
    depth: usize,
    reader: &mut XmlReader,
) -> Result<(), String> {
    if depth == DEPTH {
        return Err(element.error(format_args!("stands in more than {DEPTH} elements")));
    }
    for mut child in std::mem::take(&mut element.children) {
        if child.tag != "include" {
            expand(&mut child, folder, depth + 1, reader)?;
            element.children.push(child);
            continue;
        }
        let file = child.needed("file")?;
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
