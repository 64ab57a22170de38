//! Text format `.tet` of Isaac Gym: `v x y z [tag]`, `t a b c d` (0-based), `#` comments.

use std::path::Path;

use super::text::{self, VertexReference};
use crate::mesh::{MAX_COUNT, TetMesh};
use base::error::{Error, Result};

/// Parses the text of a `.tet` file; `path` is for messages. The tag column is ignored.
///
/// # Errors
/// Fails for a wrong keyword, column count, number or index, each with line and column, and for more than [`MAX_COUNT`]
/// items.
pub(crate) fn parse(path: &Path, source: &str) -> Result<(TetMesh, Vec<String>)> {
    let mut mesh = TetMesh::default();
    let mut refs: Vec<[VertexReference; 4]> = Vec::new();
    for line in text::lines(source, Some('#')) {
        let keyword = line.first();
        match keyword.text {
            "v" => {
                text::columns(path, &line, &[4, 5], "a `v x y z [tag]` line")?;
                mesh.nodes.push(text::position(path, &line.words[1..4])?);
                if let Some(tag) = line.words.get(4) {
                    text::number(path, *tag, "tag")?;
                }
            }
            "t" => {
                text::columns(path, &line, &[5], "a `t a b c d` line")?;
                let mut four = [VertexReference { index: 0, line: line.number, column: 0 }; 4];
                for (r, word) in four.iter_mut().zip(&line.words[1..]) {
                    r.index = text::integer(path, *word, "node index")?;
                    r.column = word.column;
                }
                refs.push(four);
            }
            other => {
                let message = format!("a line starts with {}; allowed: `v`, `t`, `#`", text::quote(other));
                return Err(text::word_error(path, keyword, message));
            }
        }
        if mesh.nodes.len().max(refs.len()) > MAX_COUNT {
            return Err(text::word_error(
                path,
                keyword,
                format!("more than the {MAX_COUNT} nodes or tetrahedra allowed"),
            ));
        }
    }
    for (e, four) in refs.into_iter().enumerate() {
        mesh.tets.push(text::resolve(path, four, e, mesh.nodes.len(), 0)?);
    }
    if mesh.nodes.is_empty() || mesh.tets.is_empty() {
        return Err(Error::file(
            path,
            format!(
                "the mesh is empty: {} nodes (`v` lines) and {} tetrahedra (`t` lines); at least 4 and 1 are needed",
                mesh.nodes.len(),
                mesh.tets.len()
            ),
        ));
    }
    Ok((mesh, Vec::new()))
}
