//! Binary form, in the byte order that an integer 1 in the file indicates.

use std::path::Path;

use super::collect::{MeshBuilder, tetrahedron_nodes};
use super::cursor::Cursor;
use super::groups::NumberWidth;
use super::version::{PARAMETRIC, Version, declared};
use crate::mesh::{MAX_COUNT, TetMesh};
use base::error::Result;

/// Number of nodes of the element types 1 to 31 of gmsh.
const NODES: [usize; 31] =
    [2, 3, 4, 4, 8, 6, 5, 3, 6, 9, 10, 27, 18, 14, 1, 8, 20, 15, 13, 9, 10, 12, 15, 15, 21, 4, 5, 6, 20, 35, 56];

/// Parses a binary gmsh file; `path` is for messages. Keeps the tetrahedra of `group`.
pub(crate) fn parse(path: &Path, bytes: &[u8], group: Option<&str>) -> Result<(TetMesh, Vec<String>)> {
    let mut file = Cursor::new(path, bytes);
    let mut found = MeshBuilder::default();
    while let Some(name) = file.section()? {
        let body = name.trim_start_matches('$').to_string();
        match (name, file.version) {
            ("$MeshFormat", _) => file.format()?,
            ("$Nodes" | "$Elements", None) => {
                return Err(file.fail("a section precedes `$MeshFormat`; the format version must come first"));
            }
            ("$ParametricNodes", _) => return Err(file.fail(PARAMETRIC)),
            ("$Nodes", Some(Version::V2)) => nodes_v2(&mut file, &mut found)?,
            ("$Nodes", Some(version)) => nodes_v4(&mut file, &mut found, version)?,
            ("$Elements", Some(Version::V2)) => elements_v2(&mut file, &mut found)?,
            ("$Elements", Some(version)) => elements_v4(&mut file, &mut found, version)?,
            _ => {
                let mut section = file.skip_to(&format!("$End{body}"))?;
                match (name, file.version) {
                    ("$PhysicalNames", _) => {
                        while let Ok(Some(line)) = section.rest_of_line() {
                            found.groups.name(line);
                        }
                    }
                    ("$Entities", Some(version)) => {
                        found.groups.entities(version, |width| match width {
                            NumberWidth::Real => section.take(8, "a real").ok().map(|_| 0),
                            NumberWidth::Int => section.any_int("a tag").ok().map(i64::from),
                            NumberWidth::Size => section.size("a count").ok()?.try_into().ok(),
                        });
                    }
                    _ => {}
                }
                continue;
            }
        }
        let end = format!("$End{body}");
        if file.section()? != Some(end.as_str()) {
            return Err(file.fail(&format!("expected `{end}`: the counts of the section do not match its contents")));
        }
    }
    found.finish(path, group)
}

fn nodes_v2(file: &mut Cursor<'_>, found: &mut MeshBuilder) -> Result<()> {
    for _ in 0..file.text_count("the number of nodes")? {
        let tag = file.int("node tag")?;
        node(file, found, tag)?;
        let position = file.position(0)?;
        found.set_position(found.nodes() - 1, position);
    }
    Ok(())
}

fn nodes_v4(file: &mut Cursor<'_>, found: &mut MeshBuilder, version: Version) -> Result<()> {
    let blocks = file.count("the number of node blocks")?;
    let total = file.count("the number of nodes")?;
    if version == Version::V41 {
        file.take(2 * file.wide, "the smallest and largest tag")?;
    }
    for _ in 0..blocks {
        let entity = [file.any_int("an entity's number")?, file.any_int("an entity's number")?];
        let dimension = if version == Version::V41 { entity[0] } else { entity[1] };
        let parametric = file.int("`parametric`")? != 0;
        // The number of parameters of a node is the dimension of the curve, surface or volume that contains it.
        let extra = if parametric { dimension.clamp(0, 3) as usize } else { 0 };
        let n = file.count("the number of nodes of a block")?;
        if found.nodes() + n > total {
            return Err(file.fail(&format!("the blocks contain more nodes than the {total} declared")));
        }
        let first = found.nodes();
        for k in first..first + n {
            let tag = if version == Version::V41 { file.size("node tag")? } else { file.int("node tag")? };
            node(file, found, tag)?;
            if version == Version::V40 {
                let position = file.position(extra)?;
                found.set_position(k, position);
            }
        }
        if version == Version::V41 {
            for k in first..first + n {
                let position = file.position(extra)?;
                found.set_position(k, position);
            }
        }
    }
    if found.nodes() < total {
        return Err(file.fail(&declared(total, found.nodes(), "nodes")));
    }
    Ok(())
}

fn node(file: &Cursor<'_>, found: &mut MeshBuilder, tag: u64) -> Result<()> {
    found.add_node(tag).map_err(|message| file.fail(&message))
}

fn elements_v2(file: &mut Cursor<'_>, found: &mut MeshBuilder) -> Result<()> {
    let total = file.text_count("the number of elements")?;
    let mut read = 0;
    while read < total {
        let kind = file.int("element type")?;
        let follow = file.int("the number of elements of a block")? as usize;
        let tags = file.int("the number of tags")? as usize;
        if follow == 0 || follow > total - read {
            let left = total - read;
            return Err(file.fail(&format!("a block of {follow} elements, but only {left} of {total} remain")));
        }
        for _ in 0..follow {
            file.take(4, "an element's number")?;
            // The first tag is the physical group.
            let group = if tags > 0 { u64::from(file.any_int("an element's group")?.unsigned_abs()) } else { 0 };
            file.take(4 * tags.saturating_sub(1).min(MAX_COUNT), "an element's tags")?;
            element(file, found, (kind, group), Cursor::int)?;
        }
        read += follow;
    }
    Ok(())
}

fn elements_v4<'a>(file: &mut Cursor<'a>, found: &mut MeshBuilder, version: Version) -> Result<()> {
    let tag: fn(&mut Cursor<'a>, &str) -> Result<u64> =
        if version == Version::V41 { Cursor::size } else { Cursor::int };
    let blocks = file.count("the number of element blocks")?;
    let total = file.count("the number of elements")?;
    let mut read = 0;
    if version == Version::V41 {
        file.take(2 * file.wide, "the smallest and largest tag")?;
    }
    for _ in 0..blocks {
        let entity = [file.any_int("an entity's number")?, file.any_int("an entity's number")?];
        // In version 4.0 the dimension is the second number.
        let volume = u64::from(entity[if version == Version::V41 { 1 } else { 0 }].unsigned_abs());
        let kind = file.int("element type")?;
        let n = file.count("the number of elements of a block")?;
        for _ in 0..n {
            tag(file, "an element's number")?;
            element(file, found, (kind, volume), tag)?;
        }
        read += n;
    }
    if read != total {
        return Err(file.fail(&declared(total, read, "elements")));
    }
    Ok(())
}

/// Stores a tetrahedron; counts and skips any other element. `tag` reads a node tag.
fn element<'a>(
    file: &mut Cursor<'a>,
    found: &mut MeshBuilder,
    (kind, volume): (u64, u64),
    tag: fn(&mut Cursor<'a>, &str) -> Result<u64>,
) -> Result<()> {
    let known = (kind as usize).checked_sub(1).and_then(|k| NODES.get(k));
    let Some(&n) = known else {
        return Err(file.fail(&format!("element type {kind} is not known; allowed: 1 to {}", NODES.len())));
    };
    if tetrahedron_nodes(kind).is_none() {
        for _ in 0..n {
            tag(file, "node tag")?;
        }
        found.count_omitted(kind);
        return Ok(());
    }
    let mut tags = [0; 10];
    for t in &mut tags[..n] {
        *t = tag(file, "node tag")?;
    }
    found.add_tetrahedron(volume, &tags[..n]).map_err(|(_, message)| file.fail(&message))
}
