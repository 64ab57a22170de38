//! Files `.node` and `.ele` of TetGen, which belong together: points, and tetrahedra of 4 or 10 nodes. `#` comments;
//! node indices start at the number of the first point, 0 or 1.

use std::path::Path;

use super::file::read_text;
use super::text::{self, Line, VertexReference};
use crate::mesh::TetMesh;
use base::error::{Error, Result};

/// Reads the file at `path` and the one in the same folder with the other extension.
///
/// # Errors
/// Fails if one of the two is missing or is not such a file (counts that differ from the content, bad number or index),
/// with line and column.
pub(crate) fn read(path: &Path) -> Result<(TetMesh, Vec<String>)> {
    let (nodes, elements) = (path.with_extension("node"), path.with_extension("ele"));
    for part in [&nodes, &elements] {
        if part != path && !part.exists() {
            let missing = part.display();
            return Err(Error::file(path, format!("{missing} is missing; TetGen's .node and .ele belong together")));
        }
    }
    let (mut mesh, mut notices) = (TetMesh::default(), Vec::new());
    let first = points(&nodes, &read_text(&nodes)?, &mut mesh)?;
    let width = tetrahedra(&elements, &read_text(&elements)?, first, &mut mesh)?;
    if mesh.tets.is_empty() {
        return Err(Error::file(path, format!("the mesh is empty: {} nodes and 0 tetrahedra", mesh.nodes.len())));
    }
    if width == 10 {
        notices.push(format!(
            "{}: only the 4 corners of {} tetrahedra of 10 nodes are read; quadratic elements get new mid-edge nodes",
            elements.display(),
            mesh.tets.len()
        ));
    }
    Ok((mesh, notices))
}

/// Reads the points; returns the number of the first.
fn points(path: &Path, source: &str, mesh: &mut TetMesh) -> Result<u64> {
    let mut lines = text::lines(source, Some('#'));
    let mut next = |expected: &str| lines.next().ok_or_else(|| text::end_error(path, expected));
    let head = next("`points dimension attributes markers`")?;
    text::columns(path, &head, &[1, 2, 3, 4], "the line `points dimension attributes markers`")?;
    let mut first = 0;
    for k in 0..text::count(path, head.first(), "the number of points")? as u64 {
        let line = next("a point `number x y z`")?;
        let number = at_least(path, &line, 4, "a point `number x y z`")?;
        if k == 0 {
            first = number;
        }
        if number != first.saturating_add(k) || first > 1 {
            let message = format!("point {number} out of order; points are numbered in order from 0 or 1");
            return Err(text::word_error(path, line.first(), message));
        }
        mesh.nodes.push(text::position(path, &line.words[1..4])?);
    }
    Ok(first)
}

/// Reads the tetrahedra; returns the number of nodes that each has.
fn tetrahedra(path: &Path, source: &str, first: u64, mesh: &mut TetMesh) -> Result<usize> {
    let mut lines = text::lines(source, Some('#'));
    let mut next = |expected: &str| lines.next().ok_or_else(|| text::end_error(path, expected));
    let head = next("`tetrahedra nodes attributes`")?;
    text::columns(path, &head, &[1, 2, 3], "the line `tetrahedra nodes attributes`")?;
    let width = match head.words.get(1) {
        None => 4,
        Some(word) => match text::count(path, *word, "nodes per tetrahedron")? {
            n @ (4 | 10) => n,
            n => return Err(text::word_error(path, *word, format!("{n} nodes per tetrahedron; allowed: 4 or 10"))),
        },
    };
    for e in 0..text::count(path, head.first(), "the number of tetrahedra")? {
        let line = next("a tetrahedron")?;
        at_least(path, &line, 1 + width, "a tetrahedron")?;
        let mut four = [VertexReference { index: 0, line: line.number, column: 0 }; 4];
        for (r, word) in four.iter_mut().zip(&line.words[1..5]) {
            r.column = word.column;
            r.index = text::integer(path, *word, "node number")?.checked_sub(first).ok_or_else(|| {
                text::word_error(
                    path,
                    *word,
                    format!("tetrahedron {e} refers to node 0; the points are numbered from 1"),
                )
            })?;
        }
        mesh.tets.push(text::resolve(path, four, e, mesh.nodes.len(), first)?);
    }
    Ok(width)
}

/// Returns the first number of a line of at least `columns` words.
fn at_least(path: &Path, line: &Line<'_>, columns: usize, what: &str) -> Result<u64> {
    if line.words.len() < columns {
        let message = format!("{what} has {} columns; at least {columns} are needed", line.words.len());
        return Err(text::word_error(path, line.last(), message));
    }
    text::integer(path, line.first(), "the number of a point or tetrahedron")
}
