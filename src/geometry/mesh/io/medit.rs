//! ASCII Medit `.mesh` format: sections `Vertices` and `Tetrahedra`, indices 1-based, each row ends in a tag.

use std::path::Path;

use super::convert::convert;
use super::text::{self, VertexReference, Word};
use crate::mesh::TetMesh;
use base::error::{Error, Result};

/// Parses a Medit file; `path` is for messages. Unused sections (mmg alone writes a dozen: `RequiredEdges`,
/// `NormalAtVertices` ...) consist of numbers after a count; they are skipped up to the next section name.
///
/// # Errors
/// Fails for binary content, a version or dimension other than 3D ASCII, a declared count that exceeds the cap or
/// differs from the content, and a bad number or index. The error states line and column.
pub(crate) fn parse(path: &Path, bytes: Vec<u8>) -> Result<(TetMesh, Vec<String>)> {
    if bytes.contains(&0) {
        return Err(Error::file(path, format!("binary Medit is not supported; write ASCII, or {}", convert(path))));
    }
    let source = text::decode(path, bytes)?;
    let mut words = text::lines(&source, Some('#')).flat_map(|l| l.words).peekable();
    let mut mesh = TetMesh::default();
    let mut notices = Vec::new();
    let mut refs: Vec<[VertexReference; 4]> = Vec::new();

    let head = words.next().ok_or_else(|| text::end_error(path, "`MeshVersionFormatted`"))?;
    if head.text != "MeshVersionFormatted" {
        let message = format!("a Medit file starts with `MeshVersionFormatted`, found {}", text::quote(head.text));
        return Err(text::word_error(path, head, message));
    }
    let mut passed_over = Vec::new();
    text::integer(path, next(path, &mut words, "the format version")?, "the format version")?;
    // Some writers omit `End`; the end of the file between sections is accepted instead.
    while let Some(section) = words.next() {
        match section.text {
            "End" => break,
            "Dimension" => {
                let word = next(path, &mut words, "the dimension")?;
                if text::integer(path, word, "the dimension")? != 3 {
                    return Err(text::word_error(
                        path,
                        word,
                        format!("dimension {}; allowed: 3", text::quote(word.text)),
                    ));
                }
            }
            "Vertices" => {
                let n = next(path, &mut words, "the number of vertices")?;
                for _ in 0..text::count(path, n, "the number of vertices")? {
                    let mut row = [Word { line: 0, column: 0, text: "" }; 4];
                    for word in &mut row {
                        *word = next(path, &mut words, "a vertex `x y z tag`")?;
                    }
                    mesh.nodes.push(text::position(path, &row[..3])?);
                    text::number(path, row[3], "tag")?;
                }
            }
            kind @ ("Tetrahedra" | "TetrahedraP2") => {
                let second_order = kind == "TetrahedraP2";
                let n = next(path, &mut words, "the number of tetrahedra")?;
                for e in 0..text::count(path, n, "the number of tetrahedra")? {
                    let mut four = [VertexReference { index: 0, line: 0, column: 0 }; 4];
                    for r in &mut four {
                        *r = one_based(path, next(path, &mut words, "a tetrahedron `a b c d tag`")?, e)?;
                    }
                    for _ in 0..if second_order { 6 } else { 0 } {
                        next(path, &mut words, "a mid-edge node of a tetrahedron")?;
                    }
                    text::number(path, next(path, &mut words, "a tetrahedron's tag")?, "tag")?;
                    refs.push(four);
                }
                if second_order {
                    notices.push(format!(
                        "{}: only the 4 corners of tetrahedra of 10 nodes are read; quadratic elements get new \
                         mid-edge nodes",
                        path.display()
                    ));
                }
            }
            name if name.starts_with(|c: char| c.is_ascii_uppercase()) => {
                let count = words.peek().map_or("0", |w| w.text);
                if count != "0" {
                    passed_over.push(format!("{count} {}", text::quote(name)));
                }
                let number = |w: &Word<'_>| !w.text.starts_with(|c: char| c.is_ascii_uppercase());
                while words.next_if(number).is_some() {}
            }
            other => {
                let message = format!(
                    "expected the name of a section, found {}; the one before declares fewer rows than it has",
                    text::quote(other)
                );
                return Err(text::word_error(path, section, message));
            }
        }
    }
    for (e, four) in refs.into_iter().enumerate() {
        mesh.tets.push(text::resolve(path, four, e, mesh.nodes.len(), 1)?);
    }
    let passed_over = passed_over.join(", ");
    if mesh.nodes.is_empty() || mesh.tets.is_empty() {
        let (n, t) = (mesh.nodes.len(), mesh.tets.len());
        let also = if passed_over.is_empty() { String::new() } else { format!("; it also has {passed_over}") };
        let message = format!("the mesh is empty: {n} Vertices and {t} Tetrahedra; both are needed{also}");
        return Err(Error::file(path, message));
    }
    if !passed_over.is_empty() {
        notices.push(format!("{}: ignored {passed_over}; only tetrahedra are used", path.display()));
    }
    Ok((mesh, notices))
}

fn next<'a>(path: &Path, words: &mut impl Iterator<Item = Word<'a>>, expected: &str) -> Result<Word<'a>> {
    words.next().ok_or_else(|| text::end_error(path, expected))
}

/// Reads a 1-based node index.
fn one_based(path: &Path, word: Word<'_>, element: usize) -> Result<VertexReference> {
    match text::integer(path, word, "node index")?.checked_sub(1) {
        Some(index) => Ok(VertexReference { index, line: word.line, column: word.column }),
        None => {
            let message = format!("tetrahedron {element} refers to node 0; Medit counts nodes from 1");
            Err(text::word_error(path, word, message))
        }
    }
}
