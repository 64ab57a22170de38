//! Wavefront `.obj`: the positions and faces of all groups, as one triangle mesh.
//!
//! [tobj](tobj::load_obj_buf) reads the file, in f64. Before that, every line is checked here, because tobj says neither
//! line nor column of what it refuses, panics on some files (a normal or texture index out of range), and divides positions by a
//! weight that belongs to curves. It is handed only what was checked: positions and vertex indices, without comments,
//! weights, colours, groups and materials, which makes one model of all groups.

use std::fmt::Write;
use std::path::Path;

use super::text::{self, Line, Word};
use crate::error::{Error, Result};
use crate::mesh::{MAX_COUNT, TriMesh};
use glam::DVec3;

/// Keywords that carry no geometry used here.
const IGNORED: [&str; 12] = ["vt", "vn", "vp", "g", "o", "s", "usemtl", "mtllib", "l", "p", "cstype", "deg"];

/// Parses the text of an `.obj` file; `path` is for messages. Vertices keep the order of the file; polygons are split as
/// fans from their first corner.
///
/// Errors: unknown keyword, bad column count, number or index, each with line and column; more than the cap; no faces.
pub(crate) fn parse(path: &Path, source: &str) -> Result<(TriMesh, Vec<String>)> {
    let checked = check(path, source)?;
    // tobj numbers vertices by first use: one point per vertex before the faces keeps the order of the file.
    let points: String = (1..=checked.vertices).fold(String::new(), |mut s, i| {
        // Writing to a String cannot fail.
        let _ = writeln!(s, "f {i}");
        s
    });
    let text = [checked.positions, points, checked.faces].concat();
    let options = tobj::LoadOptions { triangulate: true, ..Default::default() };
    let failed = |e: tobj::LoadError| Error::file(path, format!("the OBJ file cannot be read: {e}"));
    let no_materials = |_: &Path| Ok(Default::default());
    let (models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &options, no_materials).map_err(failed)?;
    let mut mesh = TriMesh::default();
    if let [model] = models.as_slice() {
        mesh.vertices.extend(model.mesh.positions.chunks_exact(3).map(DVec3::from_slice));
        // A point comes back as a triangle of one vertex.
        let faces = model.mesh.indices.chunks_exact(3).skip(checked.vertices);
        mesh.triangles.extend(faces.map(|t| [t[0], t[1], t[2]]));
    }
    let mut notices = Vec::new();
    if checked.polygons > 0 {
        notices.push(format!("{}: split {} polygons into triangles as fans", path.display(), checked.polygons));
    }
    Ok((mesh, notices))
}

/// A file found good.
#[derive(Debug, Default)]
struct Checked {
    /// Its `v x y z` lines.
    positions: String,
    /// Its `f i j k ...` lines, 1-based.
    faces: String,
    vertices: usize,
    triangles: usize,
    /// Faces of more than three corners.
    polygons: usize,
}

/// Refuses what is wrong, with its place, and keeps the geometry.
fn check(path: &Path, source: &str) -> Result<Checked> {
    let mut checked = Checked::default();
    for line in text::lines(source, Some('#')) {
        let keyword = line.first();
        match keyword.text {
            "v" => {
                // x y z, a weight or a colour may follow.
                text::columns(path, &line, &[4, 5, 7, 8], "a `v x y z` line")?;
                text::position(path, &line.words[1..4])?;
                checked.vertices += 1;
                keep(&mut checked.positions, line.words[..4].iter().map(|w| w.text));
            }
            "f" => face(path, &line, &mut checked)?,
            other if IGNORED.contains(&other) => {}
            other => {
                let message =
                    format!("unknown keyword `{}`; allowed: v, f, {}", other.escape_debug(), IGNORED.join(", "));
                return Err(text::at(path, keyword, message));
            }
        }
        if checked.vertices.max(checked.triangles) > MAX_COUNT {
            return Err(text::at(path, keyword, format!("more than the {MAX_COUNT} vertices or triangles allowed")));
        }
    }
    if checked.triangles == 0 {
        let n = checked.vertices;
        return Err(Error::file(path, format!("the mesh is empty: {n} vertices (`v` lines) and no faces (`f` lines)")));
    }
    Ok(checked)
}

/// Writes one line of words.
fn keep<'a>(text: &mut String, words: impl Iterator<Item = &'a str>) {
    for word in words {
        text.push_str(word);
        text.push(' ');
    }
    text.push('\n');
}

/// Checks the corners of one face.
fn face(path: &Path, line: &Line<'_>, checked: &mut Checked) -> Result<()> {
    let corners = &line.words[1..];
    if corners.len() < 3 {
        let message = format!("a face of {} vertices; at least 3 are needed", corners.len());
        return Err(text::at(path, line.first(), message));
    }
    checked.faces.push('f');
    for word in corners {
        let index = reference(path, *word, checked.vertices, checked.triangles)?;
        // Writing to a String cannot fail.
        let _ = write!(checked.faces, " {index}");
    }
    checked.faces.push('\n');
    checked.polygons += usize::from(corners.len() > 3);
    checked.triangles += corners.len() - 2;
    Ok(())
}

/// The vertex of `i`, `i/t`, `i//n` or `i/t/n`, 1-based; in the file it may be negative, counting back from the latest.
fn reference(path: &Path, word: Word<'_>, count: usize, triangle: usize) -> Result<u64> {
    let head = word.text.split('/').next().unwrap_or("");
    let index: i64 = head.parse().map_err(|_| {
        text::at(path, word, format!("face index `{}` is not a whole number", word.text.escape_debug()))
    })?;
    if index == 0 || index.unsigned_abs() > count as u64 {
        let message = format!(
            "triangle {triangle} refers to vertex {index}, but {count} vertices stand above; allowed: 1..={count} or \
             -{count}..=-1"
        );
        return Err(text::at(path, word, message));
    }
    Ok(if index > 0 { index as u64 } else { count as u64 - index.unsigned_abs() + 1 })
}
