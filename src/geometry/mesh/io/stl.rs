//! `.stl`, binary (through `stl_io`) and ASCII. The three corners of every facet are separate; weld them afterwards.

use std::io::Cursor;
use std::path::Path;

use glam::DVec3;

use super::text;
use crate::mesh::{MAX_COUNT, TriMesh};
use base::error::{Error, Result};

/// Number of bytes before the first facet of a binary file: comment and count.
const HEADER: usize = 84;
/// Size of one binary facet, bytes.
const FACET: usize = 50;

/// Largest accepted error of the facet count of a binary file.
const MISCOUNTED: u64 = 8;

/// Parses an `.stl` file. It is binary if its length agrees with its binary facet count (many binary files also start
/// with `solid`). Otherwise it is ASCII if it starts with `solid`, in upper or lower case. Otherwise it is binary with
/// bytes after its last facet, or with a count that is wrong by a few.
///
/// # Errors
/// Fails for a file of neither kind or cut short, non-finite numbers, more facets than the cap and no facet.
pub(crate) fn parse(path: &Path, bytes: Vec<u8>) -> Result<(TriMesh, Vec<String>)> {
    let declared = bytes.get(80..HEADER).and_then(|b| b.try_into().ok()).map(u32::from_le_bytes);
    let length = |n: u64| HEADER as u64 + FACET as u64 * n;
    let (size, file) = (bytes.len() as u64, path.display());
    let mut notices = Vec::new();
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes).trim_ascii_start();
    let mesh = if declared.is_some_and(|n| length(n.into()) == size) {
        parse_binary(path, bytes)?
    } else if text.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid")) && !text.contains(&0) {
        parse_ascii(path, &String::from_utf8_lossy(text))?
    } else {
        let Some(declared) = declared.map(u64::from) else {
            let message = format!("not an STL file: {size} bytes, and it does not start with `solid`");
            return Err(Error::file(path, message));
        };
        let (whole, over) = ((size - HEADER as u64) / FACET as u64, (size - HEADER as u64) % FACET as u64);
        let count = if whole.abs_diff(declared) <= MISCOUNTED && (over == 0 || whole < declared) {
            let news =
                format!("{file}: the header counts {declared} facets, but the file contains {whole}, which are read");
            notices.push(news);
            whole
        } else if whole >= declared && declared >= 4 {
            notices.push(format!("{file}: ignored {} bytes after the {declared} facets", size - length(declared)));
            declared
        } else {
            let message = format!(
                "not an STL file, or truncated: its binary header declares {declared} facets = {} bytes, but it has \
                 {size} bytes, and it does not start with `solid`",
                length(declared)
            );
            return Err(Error::file(path, message));
        };
        let mut bytes = bytes;
        bytes.truncate(length(count) as usize);
        bytes[80..HEADER].copy_from_slice(&(count as u32).to_le_bytes());
        parse_binary(path, bytes)?
    };
    if mesh.triangles.is_empty() {
        return Err(Error::file(path, "the mesh is empty: the STL file contains no facets"));
    }
    Ok((mesh, notices))
}

/// Adds a facet with three new vertices.
fn push(mesh: &mut TriMesh, corners: [DVec3; 3]) {
    let first = mesh.vertices.len() as u32;
    mesh.vertices.extend(corners);
    mesh.triangles.push([first, first + 1, first + 2]);
}

fn parse_binary(path: &Path, mut bytes: Vec<u8>) -> Result<TriMesh> {
    // stl_io takes a header that starts with "solid " for ASCII, so the header is blanked.
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
        match keyword.text.to_ascii_lowercase().as_str() {
            "vertex" => {
                text::columns(path, &line, &[4], "a `vertex x y z` line")?;
                corners.push(text::position(path, &line.words[1..])?);
            }
            "endfacet" => {
                let Ok(three) = <[DVec3; 3]>::try_from(std::mem::take(&mut corners)) else {
                    return Err(text::word_error(path, keyword, "a facet without exactly 3 `vertex` lines"));
                };
                push(&mut mesh, three);
                if mesh.triangles.len() > MAX_COUNT {
                    return Err(text::word_error(path, keyword, format!("more than the {MAX_COUNT} facets allowed")));
                }
            }
            "solid" | "facet" | "outer" | "endloop" | "endsolid" => {}
            other => {
                let message = format!(
                    "unknown keyword `{}`; allowed: solid, facet, outer, vertex, endloop, endfacet, endsolid",
                    other.chars().take(40).collect::<String>().escape_debug()
                );
                return Err(text::word_error(path, keyword, message));
            }
        }
    }
    if !corners.is_empty() {
        return Err(text::end_error(path, "`endfacet`"));
    }
    Ok(mesh)
}
