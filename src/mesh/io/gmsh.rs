//! gmsh ASCII `.msh`, versions 2.2 and 4.1: only first-order tetrahedra (type 4) are kept. Tags may be sparse.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use super::text::{self, Line};
use crate::error::{Error, Result};
use crate::mesh::{MAX_COUNT, TetMesh};

/// gmsh's number of the 4-node tetrahedron.
const TETRAHEDRON: u64 = 4;

/// What is collected while reading.
#[derive(Default)]
struct Builder {
    mesh: TetMesh,
    /// Node tag -> index; only looked up, never iterated.
    index_of: HashMap<u64, u32>,
    /// Element type -> number left out.
    skipped: BTreeMap<u64, usize>,
}

/// Parses the text of a gmsh file; `path` is for messages.
///
/// Errors: binary or unknown version, declared counts above the cap or not met, doubled or unknown tags, bad numbers,
/// no tetrahedra; each with line and column where there is one.
pub(crate) fn parse(path: &Path, source: &str) -> Result<(TetMesh, Vec<String>)> {
    let mut lines = text::lines(source, None);
    let mut next = |expected: &str| lines.next().ok_or_else(|| text::ended(path, expected));
    let mut builder = Builder::default();
    let mut version = None;
    while let Ok(line) = next("a section") {
        let name = line.first().text;
        match name {
            "$MeshFormat" => version = Some(format_version(path, &next("the format line")?)?),
            "$Nodes" | "$Elements" => {
                let Some(v4) = version else {
                    let message = "a section stands before `$MeshFormat`; the format version must come first";
                    return Err(text::at(path, line.first(), message));
                };
                match (name, v4) {
                    ("$Nodes", true) => builder.nodes_v4(path, &mut next)?,
                    ("$Nodes", false) => builder.nodes_v2(path, &mut next)?,
                    (_, true) => builder.elements_v4(path, &mut next)?,
                    (_, false) => builder.elements_v2(path, &mut next)?,
                }
            }
            _ if name.starts_with('$') => {}
            other => {
                let message = format!("expected a section such as `$Nodes`, found `{}`", other.escape_debug());
                return Err(text::at(path, line.first(), message));
            }
        }
        // Rows of a section that is not needed, and the closing line.
        let end = format!("$End{}", name.trim_start_matches('$'));
        loop {
            let row = next(&format!("`{end}`"))?;
            if row.first().text == end {
                break;
            }
            if matches!(name, "$Nodes" | "$Elements" | "$MeshFormat") {
                let message = format!("expected `{end}`, found more rows than the counts declare");
                return Err(text::at(path, row.first(), message));
            }
        }
    }
    if version.is_none() {
        return Err(Error::file(
            path,
            "no `$MeshFormat` section: this is not a gmsh file; allowed: gmsh ASCII 2.2 or 4.1",
        ));
    }
    builder.finish(path)
}

/// True for 4.1, false for 2.2.
fn format_version(path: &Path, line: &Line<'_>) -> Result<bool> {
    text::columns(path, line, &[3], "the `version file-type data-size` line")?;
    let v4 = match line.words[0].text {
        "4.1" => true,
        "2.2" => false,
        other => {
            let message = format!("gmsh format {}; allowed: 2.2 or 4.1 (gmsh -format msh41)", other.escape_debug());
            return Err(text::at(path, line.first(), message));
        }
    };
    if line.words[1].text != "0" {
        return Err(text::at(path, line.words[1], "binary gmsh is not read; save as ASCII (Mesh.Binary = 0)"));
    }
    Ok(v4)
}

impl Builder {
    fn nodes_v2<'a>(&mut self, path: &Path, next: &mut impl FnMut(&str) -> Result<Line<'a>>) -> Result<()> {
        let head = next("the number of nodes")?;
        text::columns(path, &head, &[1], "the number of nodes")?;
        for _ in 0..text::count(path, head.first(), "the number of nodes")? {
            let line = next("a node `tag x y z`")?;
            text::columns(path, &line, &[4], "a node `tag x y z`")?;
            self.tag(path, &line)?;
            self.mesh.nodes.push(text::position(path, &line.words[1..])?);
        }
        Ok(())
    }

    fn nodes_v4<'a>(&mut self, path: &Path, next: &mut impl FnMut(&str) -> Result<Line<'a>>) -> Result<()> {
        let head = next("`blocks nodes min max`")?;
        text::columns(path, &head, &[4], "the `blocks nodes min max` line")?;
        let total = text::count(path, head.words[1], "the number of nodes")?;
        for _ in 0..text::count(path, head.first(), "the number of node blocks")? {
            let block = next("a node block")?;
            text::columns(path, &block, &[4], "a node block `dim tag parametric count`")?;
            let n = text::count(path, block.words[3], "the number of nodes of a block")?;
            for _ in 0..n {
                let line = next("a node tag")?;
                text::columns(path, &line, &[1], "a node tag")?;
                self.tag(path, &line)?;
                // Keeps `tag` counting from the number of nodes named so far; overwritten below.
                self.mesh.nodes.push(glam::DVec3::ZERO);
            }
            let first = self.mesh.nodes.len() - n;
            for k in first..first + n {
                let line = next("node coordinates")?;
                text::columns(path, &line, &[3, 4, 5, 6], "node coordinates")?;
                self.mesh.nodes[k] = text::position(path, &line.words[..3])?;
            }
            if self.mesh.nodes.len() > total {
                let message = format!("the blocks hold more nodes than the {total} declared");
                return Err(text::at(path, block.first(), message));
            }
        }
        if self.mesh.nodes.len() < total {
            let message = format!("{total} nodes declared, but the blocks hold {}", self.mesh.nodes.len());
            return Err(text::at(path, head.words[1], message));
        }
        Ok(())
    }

    fn elements_v2<'a>(&mut self, path: &Path, next: &mut impl FnMut(&str) -> Result<Line<'a>>) -> Result<()> {
        let head = next("the number of elements")?;
        text::columns(path, &head, &[1], "the number of elements")?;
        for _ in 0..text::count(path, head.first(), "the number of elements")? {
            let line = next("an element")?;
            let [_, kind, tags, ..] = line.words[..] else {
                return Err(text::at(path, line.last(), "an element `id type n-tags ...` has fewer than 3 columns"));
            };
            let kind = text::integer(path, kind, "element type")?;
            let tags = text::count(path, tags, "the number of tags")?;
            self.element(path, &line, kind, 3 + tags)?;
        }
        Ok(())
    }

    fn elements_v4<'a>(&mut self, path: &Path, next: &mut impl FnMut(&str) -> Result<Line<'a>>) -> Result<()> {
        let head = next("`blocks elements min max`")?;
        text::columns(path, &head, &[4], "the `blocks elements min max` line")?;
        for _ in 0..text::count(path, head.first(), "the number of element blocks")? {
            let block = next("an element block")?;
            text::columns(path, &block, &[4], "an element block `dim tag type count`")?;
            let kind = text::integer(path, block.words[2], "element type")?;
            for _ in 0..text::count(path, block.words[3], "the number of elements of a block")? {
                self.element(path, &next("an element")?, kind, 1)?;
            }
        }
        Ok(())
    }

    /// Keeps a tetrahedron whose node tags start at column `skip`, counts anything else.
    fn element(&mut self, path: &Path, line: &Line<'_>, kind: u64, skip: usize) -> Result<()> {
        if kind != TETRAHEDRON {
            *self.skipped.entry(kind).or_default() += 1;
            return Ok(());
        }
        text::columns(path, line, &[skip + 4], "a tetrahedron")?;
        let mut tet = [0; 4];
        for (corner, word) in tet.iter_mut().zip(&line.words[skip..]) {
            let tag = text::integer(path, *word, "node tag")?;
            *corner = *self.index_of.get(&tag).ok_or_else(|| {
                let (e, n) = (self.mesh.tets.len(), self.mesh.nodes.len());
                text::at(
                    path,
                    *word,
                    format!("tetrahedron {e} refers to node tag {tag}, which is not among the {n} nodes"),
                )
            })?;
        }
        self.mesh.tets.push(tet);
        if self.mesh.tets.len() > MAX_COUNT {
            return Err(text::at(path, line.first(), format!("more than the {MAX_COUNT} tetrahedra allowed")));
        }
        Ok(())
    }

    /// Registers the tag in the first column for the next node.
    fn tag(&mut self, path: &Path, line: &Line<'_>) -> Result<()> {
        let tag = text::integer(path, line.first(), "node tag")?;
        if self.mesh.nodes.len() >= MAX_COUNT {
            return Err(text::at(path, line.first(), format!("more than the {MAX_COUNT} nodes allowed")));
        }
        if self.index_of.insert(tag, self.mesh.nodes.len() as u32).is_some() {
            return Err(text::at(path, line.first(), format!("node tag {tag} is used twice; tags must be unique")));
        }
        Ok(())
    }

    fn finish(self, path: &Path) -> Result<(TetMesh, Vec<String>)> {
        let list: Vec<String> = self.skipped.iter().map(|(kind, n)| format!("{n} of type {kind}")).collect();
        if self.mesh.tets.is_empty() {
            let found = if list.is_empty() { "no elements".into() } else { list.join(", ") };
            return Err(Error::file(
                path,
                format!(
                    "the mesh is empty: no 4-node tetrahedra (type 4), found {found}; mesh the volume to first order"
                ),
            ));
        }
        let mut notices = Vec::new();
        if !list.is_empty() {
            notices.push(format!("{}: ignored elements {}; only type 4 is used", path.display(), list.join(", ")));
        }
        Ok((self.mesh, notices))
    }
}
