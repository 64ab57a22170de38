//! Wavefront `.obj`: the positions and faces of all groups, as one triangle mesh.
//!
//! [tobj](tobj::load_obj_buf) reads the file, in f64. Before that, every line is checked here, because tobj reports
//! neither line nor column of an error, panics on some files (a normal or texture index out of range), and divides
//! positions by a weight that belongs to curves. It receives only checked content: positions and vertex indices,
//! without comments, weights, colours, groups and materials, so that all groups form one model. It always splits
//! polygons into fans, so polygons are split by [`polygon::triangulate`].

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use super::text::{self, Line, Word};
use crate::mesh::{MAX_COUNT, TriMesh, polygon};
use base::error::{Error, Result};
use base::number::format_count;
use glam::DVec3;

/// Keywords of names, colours, normals and materials, which are skipped without a notice.
const SILENT: [&str; 10] = ["vt", "vn", "vp", "g", "o", "s", "usemtl", "mtllib", "l", "p"];

/// Other keywords of the format that do not describe flat faces: display, grouping, curves and free-form surfaces.
const PASSED: [&str; 29] = [
    "cstype",
    "deg",
    "bmat",
    "step",
    "curv",
    "curv2",
    "surf",
    "parm",
    "trim",
    "hole",
    "scrv",
    "sp",
    "end",
    "con",
    "mg",
    "bevel",
    "c_interp",
    "d_interp",
    "lod",
    "maplib",
    "usemap",
    "shadow_obj",
    "trace_obj",
    "ctech",
    "stech",
    "res",
    "cdc",
    "cdp",
    "bzp",
];

/// Parses the text of an `.obj` file; `path` is for messages. Vertices keep the order of the file; polygons are split
/// by [`polygon::triangulate`].
///
/// # Errors
/// Fails for an unknown keyword and a bad column count, number or index, each with line and column; for more items than
/// the cap; and for a file without faces.
pub(crate) fn parse(path: &Path, source: &str) -> Result<(TriMesh, Vec<String>)> {
    let mut checked = Checked {
        path,
        positions: String::new(),
        faces: String::new(),
        vertices: 0,
        corners: 0,
        face_lines: Vec::new(),
        passed: BTreeMap::new(),
    };
    for line in joined(source) {
        checked.line(&line)?;
    }
    if checked.face_lines.is_empty() {
        let n = checked.vertices;
        return Err(Error::file(
            path,
            format!("the mesh is empty: {} (`v` lines) and no faces (`f` lines)", format_count(n, "vertex")),
        ));
    }
    let (mesh, split) = checked.read()?;
    let notices = checked.notices(&split);
    Ok((mesh, notices))
}

/// Returns the lines of the file; a line that ends in `\` continues with the next.
fn joined(source: &str) -> impl Iterator<Item = Line<'_>> {
    let mut lines = text::lines(source, Some('#'));
    std::iter::from_fn(move || {
        let mut line = lines.next()?;
        while let Some(last) = line.words.last_mut()
            && let Some(word) = last.text.strip_suffix('\\')
        {
            last.text = word;
            if word.is_empty() {
                line.words.pop();
            }
            let Some(rest) = lines.next() else { break };
            line.words.extend(rest.words);
        }
        Some(line)
    })
}

/// Checked content of a file.
struct Checked<'a> {
    path: &'a Path,
    /// Lines `v x y z` of the file.
    positions: String,
    /// Lines `f i j k ...` of the file, 1-based.
    faces: String,
    vertices: usize,
    /// Number of corners of all faces.
    corners: usize,
    /// Line of each face.
    face_lines: Vec<usize>,
    /// Number of skipped lines of each keyword.
    passed: BTreeMap<&'static str, usize>,
}

/// Result of the triangulation of the polygons.
#[derive(Default)]
struct Split {
    /// Number of faces with more than three corners.
    polygons: usize,
    /// Lines of faces whose outline crosses itself.
    crossed: Vec<usize>,
}

impl Checked<'_> {
    fn line(&mut self, line: &Line<'_>) -> Result<()> {
        let keyword = line.first();
        match keyword.text {
            "" => {}
            "v" => {
                // x y z, a weight or a colour may follow.
                text::columns(self.path, line, &[4, 5, 7, 8], "a `v x y z` line")?;
                text::position(self.path, &line.words[1..4])?;
                let [x, y, z] = [1, 2, 3].map(|i| line.words[i].text);
                // Writing to a String cannot fail.
                let _ = writeln!(self.positions, "v {x} {y} {z}");
                self.vertices += 1;
            }
            // `fo` denotes a face in the first version of the format.
            "f" | "fo" => self.face(line)?,
            other if SILENT.contains(&other) => {}
            other => match PASSED.iter().find(|k| **k == other) {
                Some(known) => *self.passed.entry(known).or_default() += 1,
                None => {
                    let message = format!(
                        "unknown keyword `{}`; allowed: v, f, {}; ignored: {}",
                        other.chars().take(40).collect::<String>().escape_debug(),
                        SILENT.join(", "),
                        PASSED.join(", ")
                    );
                    return Err(text::word_error(self.path, keyword, message));
                }
            },
        }
        // A face of n corners is n - 2 triangles.
        if self.vertices.max(self.corners.saturating_sub(2 * self.face_lines.len())) > MAX_COUNT {
            let message = format!("more than the {MAX_COUNT} vertices or triangles allowed");
            return Err(text::word_error(self.path, keyword, message));
        }
        Ok(())
    }

    fn face(&mut self, line: &Line<'_>) -> Result<()> {
        let words = &line.words[1..];
        if words.len() < 3 {
            let message = format!("a face of {}; at least 3 are needed", format_count(words.len(), "vertex"));
            return Err(text::word_error(self.path, line.first(), message));
        }
        self.faces.push('f');
        for word in words {
            let vertex = self.reference(*word)?;
            let _ = write!(self.faces, " {}", vertex + 1);
        }
        self.faces.push('\n');
        self.corners += words.len();
        self.face_lines.push(line.number);
        Ok(())
    }

    /// Reads the mesh from the checked content.
    fn read(&self) -> Result<(TriMesh, Split)> {
        // tobj numbers vertices by first use: one point per vertex before the faces preserves the order of the file.
        let points: String = (1..=self.vertices).fold(String::new(), |mut s, i| {
            let _ = writeln!(s, "f {i}");
            s
        });
        let text = [self.positions.as_str(), &points, &self.faces].concat();
        let failed = |e: tobj::LoadError| Error::file(self.path, format!("the OBJ file cannot be read: {e}"));
        let no_materials = |_: &Path| Ok(Default::default());
        let (models, _) =
            tobj::load_obj_buf(&mut text.as_bytes(), &tobj::LoadOptions::default(), no_materials).map_err(failed)?;
        let (mut mesh, mut split) = (TriMesh::default(), Split::default());
        let [model] = models.as_slice() else { return Ok((mesh, split)) };
        mesh.vertices.extend(model.mesh.positions.chunks_exact(3).map(DVec3::from_slice));
        let mut rest = model.mesh.indices.get(self.vertices..).unwrap_or_default();
        let arities = model.mesh.face_arities.iter().skip(self.vertices);
        for (arity, line) in arities.zip(&self.face_lines) {
            let Some((corners, after)) = rest.split_at_checked(*arity as usize) else { break };
            rest = after;
            let points: Vec<_> = corners.iter().map(|v| mesh.vertices[*v as usize]).collect();
            split.polygons += usize::from(corners.len() > 3);
            let triangles = polygon::triangulate(&points).unwrap_or_else(|| {
                split.crossed.push(*line);
                (1..corners.len() - 1).map(|i| [0, i, i + 1]).collect()
            });
            mesh.triangles.extend(triangles.into_iter().map(|t| t.map(|i| corners[i])));
        }
        Ok((mesh, split))
    }

    /// Returns the vertex of `i`, `i/t`, `i//n` or `i/t/n`, 0-based; the file counts from one, or backwards from the
    /// latest if negative.
    fn reference(&self, word: Word<'_>) -> Result<u32> {
        let (count, triangle) = (self.vertices, self.corners.saturating_sub(2 * self.face_lines.len()));
        let head = word.text.split('/').next().unwrap_or("");
        let index: i64 = head.parse().map_err(|_| {
            text::word_error(
                self.path,
                word,
                format!("face index `{}` is not a whole number", word.text.escape_debug()),
            )
        })?;
        if index == 0 || index.unsigned_abs() > count as u64 {
            let message = format!(
                "triangle {triangle} refers to vertex {index}, but {count} vertices are defined above; allowed: \
                 1..={count} or -{count}..=-1"
            );
            return Err(text::word_error(self.path, word, message));
        }
        let back = index.unsigned_abs() as usize;
        Ok((if index > 0 { back - 1 } else { count - back }) as u32)
    }

    fn notices(&self, split: &Split) -> Vec<String> {
        let file = self.path.display();
        let mut notices = Vec::new();
        if split.polygons > 0 {
            notices.push(format!("{file}: split {} polygons into triangles", split.polygons));
        }
        if let Some(line) = split.crossed.first() {
            let n = split.crossed.len();
            notices.push(format!("{file}: {n} faces have an outline that crosses itself, the first in line {line}"));
        }
        if !self.passed.is_empty() {
            let lines: usize = self.passed.values().sum();
            let words: Vec<&str> = self.passed.keys().copied().collect();
            notices.push(format!(
                "{file}: ignored {} that do not describe flat faces: {}",
                format_count(lines, "line"),
                words.join(", ")
            ));
        }
        notices
    }
}
