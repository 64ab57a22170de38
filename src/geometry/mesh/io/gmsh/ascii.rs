//! ASCII form, read line by line.

use std::path::Path;

use super::collect::{MeshBuilder, tetrahedron_nodes};
use super::groups::NumberWidth;
use super::version::{PARAMETRIC, Version, declared};
use crate::mesh::TetMesh;
use crate::mesh::io::text::{self, Line};
use base::error::{Error, Result};

/// Parses the text of a gmsh file; `path` is for messages. Keeps the tetrahedra of `group`.
pub(crate) fn parse(path: &Path, source: &str, group: Option<&str>) -> Result<(TetMesh, Vec<String>)> {
    let mut lines = text::lines(source, None);
    let mut next = |expected: &str| lines.next().ok_or_else(|| text::end_error(path, expected));
    let mut found = MeshBuilder::default();
    let mut version = None;
    while let Ok(line) = next("a section") {
        let name = line.first().text;
        match name {
            "$MeshFormat" => version = Some(format_version(path, &next("the format line")?)?),
            "$Nodes" | "$Elements" => {
                let Some(version) = version else {
                    let message = "a section precedes `$MeshFormat`; the format version must come first";
                    return Err(text::word_error(path, line.first(), message));
                };
                match (name, version) {
                    ("$Nodes", Version::V2) => nodes_v2(&mut found, path, &mut next)?,
                    ("$Nodes", _) => nodes_v4(&mut found, version, path, &mut next)?,
                    (_, Version::V2) => elements_v2(&mut found, path, &mut next)?,
                    _ => elements_v4(&mut found, version, path, &mut next)?,
                }
            }
            "$ParametricNodes" => return Err(text::word_error(path, line.first(), PARAMETRIC)),
            _ if name.starts_with('$') => {}
            other => {
                let message = format!("expected a section such as `$Nodes`, found {}", text::quote(other));
                return Err(text::word_error(path, line.first(), message));
            }
        }
        // Rows that have not been read yet, and the closing line.
        let end = format!("$End{}", name.trim_start_matches('$'));
        let mut numbers = Vec::new();
        loop {
            let row = next(&text::quote(&end))?;
            if row.first().text == end {
                break;
            }
            match name {
                "$PhysicalNames" => {
                    let words: Vec<&str> = row.words.iter().map(|w| w.text).collect();
                    found.groups.name(&words.join(" "));
                }
                "$Entities" => numbers.extend(row.words.iter().map(|w| w.text)),
                _ => {}
            }
            if matches!(name, "$Nodes" | "$Elements" | "$MeshFormat") {
                let message = format!("expected `{end}`, found more rows than the counts declare");
                return Err(text::word_error(path, row.first(), message));
            }
        }
        let mut numbers = numbers.into_iter();
        if let Some(version) = version {
            found.groups.entities(version, |width| match width {
                NumberWidth::Real => numbers.next().map(|_| 0),
                NumberWidth::Int | NumberWidth::Size => numbers.next()?.parse().ok(),
            });
        }
    }
    if version.is_none() {
        return Err(Error::file(
            path,
            "no `$MeshFormat` section: this is not a gmsh file; allowed: gmsh 2.2, 4.0 or 4.1",
        ));
    }
    found.finish(path, group)
}

fn format_version(path: &Path, line: &Line<'_>) -> Result<Version> {
    text::columns(path, line, &[3], "the `version file-type data-size` line")?;
    if line.words[1].text != "0" {
        let message = format!("file type {}; allowed: 0 (ASCII) or 1 (binary)", text::quote(line.words[1].text));
        return Err(text::word_error(path, line.words[1], message));
    }
    Version::of(line.words[0].text).map_err(|message| text::word_error(path, line.first(), message))
}

/// Adds the node whose tag starts the line.
fn node(found: &mut MeshBuilder, path: &Path, line: &Line<'_>) -> Result<()> {
    let tag = text::integer(path, line.first(), "node tag")?;
    found.add_node(tag).map_err(|message| text::word_error(path, line.first(), message))
}

fn nodes_v2<'a>(found: &mut MeshBuilder, path: &Path, next: &mut impl FnMut(&str) -> Result<Line<'a>>) -> Result<()> {
    let head = next("the number of nodes")?;
    text::columns(path, &head, &[1], "the number of nodes")?;
    for _ in 0..text::count(path, head.first(), "the number of nodes")? {
        let line = next("a node `tag x y z`")?;
        text::columns(path, &line, &[4], "a node `tag x y z`")?;
        node(found, path, &line)?;
        found.set_position(found.nodes() - 1, text::position(path, &line.words[1..])?);
    }
    Ok(())
}

fn nodes_v4<'a>(
    found: &mut MeshBuilder,
    version: Version,
    path: &Path,
    next: &mut impl FnMut(&str) -> Result<Line<'a>>,
) -> Result<()> {
    let head = block_counts(version, path, next, "nodes")?;
    let total = text::count(path, head.words[1], "the number of nodes")?;
    for _ in 0..text::count(path, head.first(), "the number of node blocks")? {
        let block = next("a node block")?;
        text::columns(path, &block, &[4], "a node block of an entity's two numbers, `parametric`, `count`")?;
        let n = text::count(path, block.words[3], "the number of nodes of a block")?;
        if n > total - found.nodes().min(total) {
            let message = format!("the blocks contain more nodes than the {total} declared");
            return Err(text::word_error(path, block.first(), message));
        }
        let first = found.nodes();
        for _ in 0..n {
            if version == Version::V40 {
                let line = next("a node `tag x y z`")?;
                text::columns(path, &line, &[4, 5, 6, 7], "a node `tag x y z`")?;
                node(found, path, &line)?;
                found.set_position(found.nodes() - 1, text::position(path, &line.words[1..4])?);
            } else {
                let line = next("a node tag")?;
                text::columns(path, &line, &[1], "a node tag")?;
                node(found, path, &line)?;
            }
        }
        if version == Version::V41 {
            for k in first..first + n {
                let line = next("node coordinates")?;
                text::columns(path, &line, &[3, 4, 5, 6], "node coordinates")?;
                found.set_position(k, text::position(path, &line.words[..3])?);
            }
        }
    }
    if found.nodes() < total {
        return Err(text::word_error(path, head.words[1], declared(total, found.nodes(), "nodes")));
    }
    Ok(())
}

/// Reads the first line of a section of blocks: numbers of blocks and items, and since 4.1 the smallest and largest
/// tag.
fn block_counts<'a>(
    version: Version,
    path: &Path,
    next: &mut impl FnMut(&str) -> Result<Line<'a>>,
    what: &str,
) -> Result<Line<'a>> {
    let (columns, names) = match version {
        Version::V41 => (4, format!("blocks {what} min max")),
        _ => (2, format!("blocks {what}")),
    };
    let head = next(&format!("`{names}`"))?;
    text::columns(path, &head, &[columns], &format!("the `{names}` line"))?;
    Ok(head)
}

fn elements_v2<'a>(
    found: &mut MeshBuilder,
    path: &Path,
    next: &mut impl FnMut(&str) -> Result<Line<'a>>,
) -> Result<()> {
    let head = next("the number of elements")?;
    text::columns(path, &head, &[1], "the number of elements")?;
    for _ in 0..text::count(path, head.first(), "the number of elements")? {
        let line = next("an element")?;
        let [_, kind, tags, ..] = line.words[..] else {
            return Err(text::word_error(
                path,
                line.last(),
                "an element `id type n-tags ...` has fewer than 3 columns",
            ));
        };
        let kind = text::integer(path, kind, "element type")?;
        let tags = text::count(path, tags, "the number of tags")?;
        // The first tag is the physical group.
        let group = if tags > 0 { line.words.get(3) } else { None };
        let group = group.map_or(Ok(0), |word| text::integer(path, *word, "physical group"))?;
        element(found, path, &line, (kind, group), 3 + tags)?;
    }
    Ok(())
}

fn elements_v4<'a>(
    found: &mut MeshBuilder,
    version: Version,
    path: &Path,
    next: &mut impl FnMut(&str) -> Result<Line<'a>>,
) -> Result<()> {
    let head = block_counts(version, path, next, "elements")?;
    let total = text::count(path, head.words[1], "the number of elements")?;
    let mut read = 0;
    for _ in 0..text::count(path, head.first(), "the number of element blocks")? {
        let block = next("an element block")?;
        text::columns(path, &block, &[4], "an element block of an entity's two numbers, `type`, `count`")?;
        let kind = text::integer(path, block.words[2], "element type")?;
        // In version 4.0 the dimension is the second number.
        let volume = block.words[if version == Version::V41 { 1 } else { 0 }];
        let volume = volume.text.parse::<i64>().map_or(0, i64::unsigned_abs);
        let n = text::count(path, block.words[3], "the number of elements of a block")?;
        for _ in 0..n {
            element(found, path, &next("an element")?, (kind, volume), 1)?;
        }
        read += n;
    }
    if read != total {
        return Err(text::word_error(path, head.words[1], declared(total, read, "elements")));
    }
    Ok(())
}

/// Stores a tetrahedron of a volume, whose node tags start at column `skip`; counts any other element.
fn element(
    found: &mut MeshBuilder,
    path: &Path,
    line: &Line<'_>,
    (kind, volume): (u64, u64),
    skip: usize,
) -> Result<()> {
    let Some(n) = tetrahedron_nodes(kind) else {
        found.count_omitted(kind);
        return Ok(());
    };
    text::columns(path, line, &[skip + n], "a tetrahedron")?;
    let mut tags = [0; 10];
    for (tag, word) in tags.iter_mut().zip(&line.words[skip..]) {
        *tag = text::integer(path, *word, "node tag")?;
    }
    found
        .add_tetrahedron(volume, &tags[..n])
        .map_err(|(node, message)| text::word_error(path, line.words[skip + node], message))
}
