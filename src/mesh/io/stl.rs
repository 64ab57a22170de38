//! `.stl`, binary (through `stl_io`) and ASCII. The three corners of every facet are separate here: weld afterwards.

use std::io::Cursor;
use std::path::Path;

use glam::DVec3;

use super::text;
use crate::error::{Error, Result};
use crate::mesh::{MAX_COUNT, TriMesh};

/// Bytes before the first facet of a binary file: comment and count.
const HEADER: usize = 84;
/// Bytes of one binary facet.
const FACET: usize = 50;

/// Parses an `.stl` file. It is binary if its length is what its binary count says (many binary files start with
/// `solid` too), else ASCII if it starts with `solid`.
///
/// Errors: neither kind, cut short, non-finite numbers, more facets than the cap, no facet.
pub(crate) fn parse(path: &Path, bytes: Vec<u8>) -> Result<TriMesh> {
    let declared = bytes.get(80..HEADER).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    let binary = declared.is_some_and(|n| HEADER as u64 + FACET as u64 * u64::from(n) == bytes.len() as u64);
    let mesh = if binary {
        parse_binary(path, bytes)?
    } else if bytes.trim_ascii_start().starts_with(b"solid") && !bytes.contains(&0) {
        parse_ascii(path, &String::from_utf8_lossy(&bytes))?
    } else {
        let message = match declared {
            Some(n) => format!(
                "not an STL file, or cut short: its binary header declares {n} facets = {} bytes, but it has {} bytes, and \
                 it does not start with `solid`",
                HEADER as u64 + FACET as u64 * u64::from(n),
                bytes.len()
            ),
            None => format!("not an STL file: {} bytes, and it does not start with `solid`", bytes.len()),
        };
        return Err(Error::file(path, message));
    };
    if mesh.triangles.is_empty() {
        return Err(Error::file(path, "the mesh is empty: the STL file holds no facets"));
    }
    Ok(mesh)
}

/// A triangle soup: three new vertices per facet.
fn push(mesh: &mut TriMesh, corners: [DVec3; 3]) {
    let first = mesh.vertices.len() as u32;
    mesh.vertices.extend(corners);
    mesh.triangles.push([first, first + 1, first + 2]);
}

fn parse_binary(path: &Path, mut bytes: Vec<u8>) -> Result<TriMesh> {
    // stl_io takes a comment starting with "solid " for ASCII: blank it.
    bytes[..80].fill(0);
    let facets = (bytes.len() - HEADER) / FACET;
    if facets > MAX_COUNT {
        return Err(Error::file(path, format!("{facets} facets; at most {MAX_COUNT} are allowed")));
    }
    let failed = |e: std::io::Error| Error::file(path, format!("binary STL cannot be read: {e}"));
    let mut cursor = Cursor::new(bytes);
    let mut mesh = TriMesh::default();
    for (k, facet) in stl_io::create_stl_reader(&mut cursor).map_err(failed)?.enumerate() {
        let corners = facet.map_err(failed)?.vertices.map(|v| DVec3::from_array(v.0.map(f64::from)));
        if let Some(bad) = corners.iter().find(|c| !c.is_finite()) {
            let message = format!("facet {k} (0-based) has the vertex {bad}; only finite numbers are allowed");
            return Err(Error::file(path, message));
        }
        push(&mut mesh, corners);
    }
    Ok(mesh)
}

fn parse_ascii(path: &Path, source: &str) -> Result<TriMesh> {
    let mut mesh = TriMesh::default();
    let mut corners = Vec::with_capacity(3);
    for line in text::lines(source, None) {
        let keyword = line.first();
        match keyword.text {
            "vertex" => {
                text::columns(path, &line, &[4], "a `vertex x y z` line")?;
                corners.push(text::position(path, &line.words[1..])?);
            }
            "endfacet" => {
                let Ok(three) = <[DVec3; 3]>::try_from(std::mem::take(&mut corners)) else {
                    return Err(text::at(path, keyword, "a facet without exactly 3 `vertex` lines"));
                };
                push(&mut mesh, three);
                if mesh.triangles.len() > MAX_COUNT {
                    return Err(text::at(path, keyword, format!("more than the {MAX_COUNT} facets allowed")));
                }
            }
            "solid" | "facet" | "outer" | "endloop" | "endsolid" => {}
            other => {
                let message = format!(
                    "unknown keyword `{}`; allowed: solid, facet, outer, vertex, endloop, endfacet, endsolid",
                    other.chars().take(40).collect::<String>().escape_debug()
                );
                return Err(text::at(path, keyword, message));
            }
        }
    }
    if !corners.is_empty() {
        return Err(text::ended(path, "`endfacet`"));
    }
    Ok(mesh)
}
