//! Wavefront `.obj`: the `v` and `f` lines of all groups, merged into one triangle mesh.
//!
//! Read here rather than through a crate: the geometry is needed in f64, with the line of every refusal, and nothing
//! but positions and faces matters. Polygons are split as fans from their first corner.

use std::path::Path;

use super::text::{self, Line, Word};
use crate::error::{Error, Result};
use crate::mesh::{MAX_COUNT, TriMesh};

/// Keywords that carry no geometry used here.
const IGNORED: [&str; 12] = ["vt", "vn", "vp", "g", "o", "s", "usemtl", "mtllib", "l", "p", "cstype", "deg"];

/// Parses the text of an `.obj` file; `path` is for messages.
///
/// Errors: unknown keyword, bad column count, number or index, each with line and column; more than the cap; no faces.
pub(crate) fn parse(path: &Path, source: &str) -> Result<(TriMesh, Vec<String>)> {
    let mut mesh = TriMesh::default();
    let mut polygons = 0_usize;
    for line in text::lines(source, Some('#')) {
        let keyword = line.first();
        match keyword.text {
            "v" => {
                // x y z, a weight or a colour may follow.
                text::columns(path, &line, &[4, 5, 7, 8], "a `v x y z` line")?;
                mesh.vertices.push(text::position(path, &line.words[1..4])?);
            }
            "f" => {
                if line.words.len() < 4 {
                    let n = line.words.len() - 1;
                    return Err(text::at(path, keyword, format!("a face of {n} vertices; at least 3 are needed")));
                }
                polygons += usize::from(line.words.len() > 4);
                face(path, &line, &mut mesh)?;
            }
            other if IGNORED.contains(&other) => {}
            other => {
                let message =
                    format!("unknown keyword `{}`; allowed: v, f, {}", other.escape_debug(), IGNORED.join(", "));
                return Err(text::at(path, keyword, message));
            }
        }
        if mesh.vertices.len().max(mesh.triangles.len()) > MAX_COUNT {
            return Err(text::at(path, keyword, format!("more than the {MAX_COUNT} vertices or triangles allowed")));
        }
    }
    if mesh.triangles.is_empty() {
        let n = mesh.vertices.len();
        return Err(Error::file(path, format!("the mesh is empty: {n} vertices (`v` lines) and no faces (`f` lines)")));
    }
    let mut notices = Vec::new();
    if polygons > 0 {
        notices.push(format!("{}: split {polygons} polygons into triangles as fans", path.display()));
    }
    Ok((mesh, notices))
}

/// Adds the fan of one face.
fn face(path: &Path, line: &Line<'_>, mesh: &mut TriMesh) -> Result<()> {
    let mut first = 0;
    let mut previous = 0;
    for (k, word) in line.words[1..].iter().enumerate() {
        let vertex = reference(path, *word, mesh.vertices.len(), mesh.triangles.len())?;
        match k {
            0 => first = vertex,
            1 => {}
            _ => mesh.triangles.push([first, previous, vertex]),
        }
        previous = vertex;
    }
    Ok(())
}

/// The vertex of `i`, `i/t`, `i//n` or `i/t/n`; 1-based, or negative counting back from the latest vertex.
fn reference(path: &Path, word: Word<'_>, count: usize, triangle: usize) -> Result<u32> {
    let head = word.text.split('/').next().unwrap_or("");
    let index: i64 = head.parse().map_err(|_| {
        text::at(path, word, format!("face index `{}` is not a whole number", word.text.escape_debug()))
    })?;
    let zero_based = match index {
        1.. => Some(index - 1),
        0 => None,
        _ => index.checked_add(count as i64).filter(|i| *i >= 0),
    };
    match zero_based {
        Some(i) if i < count as i64 => Ok(i as u32),
        _ => {
            let message = format!(
                "triangle {triangle} refers to vertex {index}, but {count} vertices stand above; allowed: 1..={count} or \
                 -{count}..=-1"
            );
            Err(text::at(path, word, message))
        }
    }
}
