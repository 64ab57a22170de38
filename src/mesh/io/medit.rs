//! The ASCII Medit `.mesh` format: sections `Vertices` and `Tetrahedra`, indices 1-based, each row ends in a tag.

use std::path::Path;

use super::text::{self, Reference, Word};
use crate::error::{Error, Result};
use crate::mesh::TetMesh;

/// Words per row of the sections that may be skipped, tag included.
const SKIPPED: [(&str, usize); 9] = [
    ("Edges", 3),
    ("Triangles", 4),
    ("Quadrilaterals", 5),
    ("Hexahedra", 9),
    ("Prisms", 7),
    ("Corners", 1),
    ("Ridges", 1),
    ("RequiredVertices", 1),
    ("RequiredTriangles", 1),
];

/// Parses the text of a Medit file; `path` is for messages.
///
/// Errors: version or dimension other than 3D ASCII, unknown section, declared count above the cap or not met, bad
/// number or index, each with line and column.
pub(crate) fn parse(path: &Path, source: &str) -> Result<(TetMesh, Vec<String>)> {
    let mut words = text::lines(source, Some('#')).flat_map(|l| l.words);
    let mut next = |expected: &str| words.next().ok_or_else(|| text::ended(path, expected));
    let mut mesh = TetMesh::default();
    let mut notices = Vec::new();
    let mut refs: Vec<[Reference; 4]> = Vec::new();

    let head = next("`MeshVersionFormatted`")?;
    if head.text != "MeshVersionFormatted" {
        let message = "a Medit file starts with `MeshVersionFormatted`; binary Medit (.meshb) is not read: write ASCII";
        return Err(text::at(path, head, message));
    }
    text::integer(path, next("the format version")?, "the format version")?;
    // Some writers leave out `End`: the end of the file in place of a section closes it too.
    while let Ok(section) = next("a section") {
        match section.text {
            "End" => break,
            "Dimension" => {
                let word = next("the dimension")?;
                if text::integer(path, word, "the dimension")? != 3 {
                    return Err(text::at(path, word, format!("dimension {}; allowed: 3", word.text)));
                }
            }
            "Vertices" => {
                let n = text::count(path, next("the number of vertices")?, "the number of vertices")?;
                for _ in 0..n {
                    let mut row = [Word { line: 0, column: 0, text: "" }; 4];
                    for word in &mut row {
                        *word = next("a vertex `x y z tag`")?;
                    }
                    mesh.nodes.push(text::position(path, &row[..3])?);
                    text::number(path, row[3], "tag")?;
                }
            }
            "Tetrahedra" => {
                let n = text::count(path, next("the number of tetrahedra")?, "the number of tetrahedra")?;
                for e in 0..n {
                    let mut four = [Reference { index: 0, line: 0, column: 0 }; 4];
                    for r in &mut four {
                        *r = one_based(path, next("a tetrahedron `a b c d tag`")?, e)?;
                    }
                    text::number(path, next("a tetrahedron's tag")?, "tag")?;
                    refs.push(four);
                }
            }
            other => {
                let Some((name, width)) = SKIPPED.iter().find(|(name, _)| *name == other) else {
                    let message =
                        format!("section `{}` is not known; allowed: Vertices, Tetrahedra", other.escape_debug());
                    return Err(text::at(path, section, message));
                };
                let n = text::count(path, next("a section's count")?, "a section's count")?;
                for _ in 0..n * width {
                    next("a row of a skipped section")?;
                }
                if n > 0 {
                    notices.push(format!("{}: ignored {n} {name}; only tetrahedra are used", path.display()));
                }
            }
        }
    }
    for (e, four) in refs.into_iter().enumerate() {
        mesh.tets.push(text::resolve(path, four, e, mesh.nodes.len(), 1)?);
    }
    if mesh.nodes.is_empty() || mesh.tets.is_empty() {
        let (n, t) = (mesh.nodes.len(), mesh.tets.len());
        return Err(Error::file(path, format!("the mesh is empty: {n} Vertices and {t} Tetrahedra; both are needed")));
    }
    Ok((mesh, notices))
}

/// A 1-based node index.
fn one_based(path: &Path, word: Word<'_>, element: usize) -> Result<Reference> {
    match text::integer(path, word, "node index")?.checked_sub(1) {
        Some(index) => Ok(Reference { index, line: word.line, column: word.column }),
        None => {
            let message = format!("tetrahedron {element} refers to node 0; Medit counts nodes from 1");
            Err(text::at(path, word, message))
        }
    }
}
