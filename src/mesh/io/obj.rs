//! Wavefront `.obj`: the positions and faces of all groups, as one triangle mesh.

use std::collections::BTreeMap;
use std::path::Path;

use super::text::{self, Line, Word};
use crate::error::{Error, Result};
use crate::mesh::{MAX_COUNT, TriMesh, polygon};

/// Keywords of names, colours, normals and materials: no word is lost about them.
const SILENT: [&str; 10] = ["vt", "vn", "vp", "g", "o", "s", "usemtl", "mtllib", "l", "p"];

/// Other keywords of the format that say nothing of flat faces: display, grouping, curves and free-form surfaces.
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

/// Parses the text of an `.obj` file; `path` is for messages. Vertices keep the order of the file; polygons are split by
/// [`polygon::triangulate`].
///
/// Errors: unknown keyword, bad column count, number or index, each with line and column; more than the cap; no faces.
pub(crate) fn parse(path: &Path, source: &str) -> Result<(TriMesh, Vec<String>)> {
    let mut reader =
        Reader { path, mesh: TriMesh::default(), polygons: 0, crossed: Vec::new(), passed: BTreeMap::new() };
    for line in joined(source) {
        reader.line(&line)?;
    }
    if reader.mesh.triangles.is_empty() {
        let n = reader.mesh.vertices.len();
        return Err(Error::file(path, format!("the mesh is empty: {n} vertices (`v` lines) and no faces (`f` lines)")));
    }
    let notices = reader.notices();
    Ok((reader.mesh, notices))
}

/// The lines of the file; one that ends in `\` goes on with the next.
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

struct Reader<'a> {
    path: &'a Path,
    mesh: TriMesh,
    /// Faces of more than three corners.
    polygons: usize,
    /// Lines of faces whose outline crosses itself.
    crossed: Vec<usize>,
    /// How many lines of each keyword were passed over.
    passed: BTreeMap<&'static str, usize>,
}

impl Reader<'_> {
    fn line(&mut self, line: &Line<'_>) -> Result<()> {
        let keyword = line.first();
        match keyword.text {
            "" => {}
            "v" => {
                // x y z, a weight or a colour may follow.
                text::columns(self.path, line, &[4, 5, 7, 8], "a `v x y z` line")?;
                self.mesh.vertices.push(text::position(self.path, &line.words[1..4])?);
            }
            // `fo` is what the first version of the format called a face.
            "f" | "fo" => self.face(line)?,
            other if SILENT.contains(&other) => {}
            other => match PASSED.iter().find(|k| **k == other) {
                Some(known) => *self.passed.entry(known).or_default() += 1,
                None => {
                    let message = format!(
                        "unknown keyword `{}`; allowed: v, f, {}; passed over: {}",
                        other.chars().take(40).collect::<String>().escape_debug(),
                        SILENT.join(", "),
                        PASSED.join(", ")
                    );
                    return Err(text::at(self.path, keyword, message));
                }
            },
        }
        if self.mesh.vertices.len().max(self.mesh.triangles.len()) > MAX_COUNT {
            let message = format!("more than the {MAX_COUNT} vertices or triangles allowed");
            return Err(text::at(self.path, keyword, message));
        }
        Ok(())
    }

    fn face(&mut self, line: &Line<'_>) -> Result<()> {
        let words = &line.words[1..];
        if words.len() < 3 {
            let message = format!("a face of {} vertices; at least 3 are needed", words.len());
            return Err(text::at(self.path, line.first(), message));
        }
        let corners = words.iter().map(|w| self.reference(*w)).collect::<Result<Vec<u32>>>()?;
        let points: Vec<_> = corners.iter().map(|v| self.mesh.vertices[*v as usize]).collect();
        self.polygons += usize::from(corners.len() > 3);
        let triangles = polygon::triangulate(&points).unwrap_or_else(|| {
            self.crossed.push(line.number);
            (1..corners.len() - 1).map(|i| [0, i, i + 1]).collect()
        });
        self.mesh.triangles.extend(triangles.into_iter().map(|t| t.map(|i| corners[i])));
        Ok(())
    }

    /// The vertex of `i`, `i/t`, `i//n` or `i/t/n`, 0-based; in the file it counts from one, or back from the latest if negative.
    fn reference(&self, word: Word<'_>) -> Result<u32> {
        let (count, triangle) = (self.mesh.vertices.len(), self.mesh.triangles.len());
        let head = word.text.split('/').next().unwrap_or("");
        let index: i64 = head.parse().map_err(|_| {
            text::at(self.path, word, format!("face index `{}` is not a whole number", word.text.escape_debug()))
        })?;
        if index == 0 || index.unsigned_abs() > count as u64 {
            let message = format!(
                "triangle {triangle} refers to vertex {index}, but {count} vertices stand above; allowed: 1..={count} or \
                 -{count}..=-1"
            );
            return Err(text::at(self.path, word, message));
        }
        let back = index.unsigned_abs() as usize;
        Ok((if index > 0 { back - 1 } else { count - back }) as u32)
    }

    fn notices(&self) -> Vec<String> {
        let file = self.path.display();
        let mut notices = Vec::new();
        if self.polygons > 0 {
            notices.push(format!("{file}: split {} polygons into triangles", self.polygons));
        }
        if let Some(line) = self.crossed.first() {
            let n = self.crossed.len();
            notices.push(format!("{file}: {n} faces have an outline that crosses itself, the first in line {line}"));
        }
        if !self.passed.is_empty() {
            let lines: usize = self.passed.values().sum();
            let words: Vec<&str> = self.passed.keys().copied().collect();
            notices.push(format!(
                "{file}: passed over {lines} lines that say nothing of flat faces: {}",
                words.join(", ")
            ));
        }
        notices
    }
}
