//! Legacy `.vtk`, ASCII and binary: the tetrahedra (cell types 10 and 24) of an unstructured grid. 0-based indices.
//!
//! Layout: "VTK file formats", simple legacy formats, up to version 5.1, which stores offsets and connectivity
//! separately.

mod binary;
mod content;
mod words;

use std::path::Path;

use super::text;
use crate::mesh::{MAX_COUNT, TetMesh};
use base::error::{Error, Result};
use base::number::format_count;
use binary::Bytes;
use content::{Index, VtkContent};
use glam::DVec3;
use words::Words;

/// Cell types of the 4-node and of the 10-node tetrahedron in VTK.
const TETRAHEDRA: [u64; 2] = [10, 24];

/// Parses a legacy VTK file; `path` is for messages.
///
/// # Errors
/// Fails for a dataset other than an unstructured grid, declared counts that exceed the cap or differ from the content,
/// and a bad number or index. The error states line and column of a text file, the byte offset of a binary file.
pub(crate) fn parse(path: &Path, bytes: Vec<u8>) -> Result<(TetMesh, Vec<String>)> {
    let head: Vec<&[u8]> = bytes.split(|b| *b == b'\n').take(3).map(<[u8]>::trim_ascii).collect();
    match head[..] {
        [first, _, b"ASCII"] if first.starts_with(b"# vtk DataFile") => {
            let source = text::decode(path, bytes)?;
            sections(path, Words::new(path, &source))
        }
        [first, _, b"BINARY"] if first.starts_with(b"# vtk DataFile") => sections(path, Bytes::new(path, &bytes)),
        _ => {
            let message = "not a legacy VTK file: `# vtk DataFile ...`, a title and `ASCII` or `BINARY` are its first three lines";
            Err(Error::file(path, message))
        }
    }
}

/// Reads the sections after the header.
fn sections<'a>(path: &Path, mut file: impl VtkContent<'a>) -> Result<(TetMesh, Vec<String>)> {
    let (mut mesh, mut cells, mut types) = (TetMesh::default(), Vec::new(), Vec::new());
    while let Some(word) = file.word()? {
        match word {
            "DATASET" => {
                let kind = file.next("the kind of the dataset")?;
                if kind != "UNSTRUCTURED_GRID" {
                    return Err(file.fail(format!("dataset {}; allowed: UNSTRUCTURED_GRID", text::quote(kind))));
                }
            }
            "POINTS" => {
                let n = file.count("the number of points", MAX_COUNT)?;
                let kind = file.next("the type of the points")?;
                let values = file.reals(3 * n, kind)?;
                mesh.nodes = values.as_chunks::<3>().0.iter().copied().map(DVec3::from_array).collect();
            }
            "CELLS" => cells = read_cells(&mut file)?,
            "CELL_TYPES" => {
                let n = file.count("the number of cell types", MAX_COUNT)?;
                types = file.integers(n, "int")?;
            }
            // Point and cell data come last.
            "POINT_DATA" | "CELL_DATA" => break,
            other => file.skip(other)?,
        }
    }
    if types.len() != cells.len() {
        let message = format!("{} cells, but {} cell types", cells.len(), types.len());
        return Err(Error::file(path, message));
    }
    collect(path, mesh, &cells, &types)
}

/// Reads the points of each cell, in the old form (`n a b c ...`) or in that of version 5.
fn read_cells<'a>(file: &mut impl VtkContent<'a>) -> Result<Vec<Vec<Index>>> {
    let n = file.count("the number of cells", MAX_COUNT)?;
    let size = file.count("the size of the cells", 64 * MAX_COUNT)?;
    let mut cells = Vec::new();
    if n == 0 {
        return Ok(cells);
    }
    if let Some(kind) = file.offsets()? {
        let offsets = file.integers(n, kind)?;
        let ordered = offsets.is_sorted_by_key(|offset| offset.value);
        if let Some(last) = offsets.iter().find(|offset| !ordered || offset.value > size as u64) {
            return Err(
                file.fail(format!("offsets out of order, such as {}; they must rise to at most {size}", last.value))
            );
        }
        let word = file.next("`CONNECTIVITY`")?;
        if word != "CONNECTIVITY" {
            return Err(file.fail(format!("expected `CONNECTIVITY`, found {}", text::quote(word))));
        }
        let kind = file.next("the type of the connectivity")?;
        let points = file.integers(size, kind)?;
        let bounds = offsets.windows(2).map(|pair| pair[0].value as usize..pair[1].value as usize);
        return Ok(bounds.map(|cell| points[cell].to_vec()).collect());
    }
    let numbers = file.integers(size, "int")?;
    let mut rest = &numbers[..];
    for cell in 0..n {
        let points = rest.split_first().and_then(|(length, points)| points.split_at_checked(length.value as usize));
        let Some((points, after)) = points else {
            return Err(file.fail(format!("the {size} numbers of the cells end within cell {cell} of {n}")));
        };
        cells.push(points.to_vec());
        rest = after;
    }
    Ok(cells)
}

/// Keeps the tetrahedra among the cells.
fn collect(path: &Path, mut mesh: TetMesh, cells: &[Vec<Index>], types: &[Index]) -> Result<(TetMesh, Vec<String>)> {
    let (mut quadratic, mut others) = (0, 0);
    let count = mesh.nodes.len();
    for (cell, kind) in cells.iter().zip(types) {
        if !TETRAHEDRA.contains(&kind.value) {
            others += 1;
            continue;
        }
        quadratic += usize::from(kind.value == TETRAHEDRA[1]);
        let [a, b, c, d, ..] = cell[..] else {
            let message = format!("a tetrahedron (cell type {}) of {} points", kind.value, cell.len());
            return Err(Error::file(path, message));
        };
        if let Some(point) = [a, b, c, d].iter().find(|point| point.value >= count as u64) {
            let message = format!(
                "tetrahedron {} refers to node {}, but the file has {count} nodes; allowed: 0..={}",
                mesh.tets.len(),
                point.value,
                count.saturating_sub(1)
            );
            let place = point.place.map_or(String::new(), |(line, column)| format!("line {line}, column {column}: "));
            return Err(Error::file(path, place + &message));
        }
        mesh.tets.push([a, b, c, d].map(|point| point.value as u32));
    }
    if mesh.tets.is_empty() {
        let message =
            format!("the mesh is empty: {count} points, no tetrahedra (cell types 10, 24) and {others} other cells");
        return Err(Error::file(path, message));
    }
    let mut notices = Vec::new();
    if quadratic > 0 {
        notices.push(format!(
            "{}: only the 4 corners of {quadratic} tetrahedra of 10 nodes are read; quadratic elements get new \
             mid-edge nodes",
            path.display()
        ));
    }
    if others > 0 {
        notices.push(format!("{}: ignored {}; only tetrahedra are used", path.display(), format_count(others, "cell")));
    }
    Ok((mesh, notices))
}
