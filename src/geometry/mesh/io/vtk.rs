//! Legacy ASCII `.vtk`: the tetrahedra (cell types 10 and 24) of an unstructured grid. 0-based indices.
//!
//! Layout: "VTK file formats", simple legacy formats, up to version 5.1, which lists offsets and connectivity apart.

use std::path::Path;

use super::text::{self, VertexReference, Word};
use crate::error::{Error, Result};
use crate::geometry::mesh::{MAX_COUNT, TetMesh};

/// Numbers of the 4-node and of the 10-node tetrahedron in VTK.
const TETRAHEDRA: [u64; 2] = [10, 24];

/// Parses a legacy VTK file; `path` is for messages.
///
/// # Errors
/// Fails for binary content, a dataset other than an unstructured grid, declared counts above the cap or not met, and a
/// bad number or index. The error states line and column.
pub(crate) fn parse(path: &Path, bytes: Vec<u8>) -> Result<(TetMesh, Vec<String>)> {
    let head: Vec<&[u8]> = bytes.split(|b| *b == b'\n').take(3).map(<[u8]>::trim_ascii).collect();
    match head[..] {
        [first, _, b"ASCII"] if first.starts_with(b"# vtk DataFile") => {}
        [first, _, b"BINARY"] if first.starts_with(b"# vtk DataFile") => {
            return Err(Error::file(path, format!("binary VTK is not read; {}", super::convert(path))));
        }
        _ => {
            let message = "not a legacy VTK file: `# vtk DataFile ...`, a title and `ASCII` are its first three lines";
            return Err(Error::file(path, message));
        }
    }
    let source = text::decode(path, bytes)?;
    let mut file = Words { path, words: text::lines(&source, None).filter(|l| l.number > 3).flat_map(|l| l.words) };
    let (mut mesh, mut cells, mut types) = (TetMesh::default(), Vec::new(), Vec::new());
    while let Some(word) = file.words.next() {
        match word.text {
            "DATASET" => {
                let kind = file.next("the kind of the dataset")?;
                if kind.text != "UNSTRUCTURED_GRID" {
                    let message = format!("dataset {}; allowed: UNSTRUCTURED_GRID", text::quote(kind.text));
                    return Err(text::at(path, kind, message));
                }
            }
            "POINTS" => {
                let n = file.count("the number of points")?;
                file.next("the type of the points")?;
                for _ in 0..n {
                    let row = [file.next("a point")?, file.next("a point")?, file.next("a point")?];
                    mesh.nodes.push(text::position(path, &row)?);
                }
            }
            "CELLS" => cells = file.cells()?,
            "CELL_TYPES" => {
                let n = file.count("the number of cell types")?;
                for _ in 0..n {
                    types.push(file.integer("a cell type")?.1);
                }
            }
            // Values at points and cells come last.
            "POINT_DATA" | "CELL_DATA" => break,
            _ => {}
        }
    }
    if types.len() != cells.len() {
        let message = format!("{} cells, but {} cell types", cells.len(), types.len());
        return Err(Error::file(path, message));
    }
    collect(path, mesh, &cells, &types)
}

/// Keeps the tetrahedra among the cells.
fn collect(
    path: &Path,
    mut mesh: TetMesh,
    cells: &[Vec<VertexReference>],
    types: &[u64],
) -> Result<(TetMesh, Vec<String>)> {
    let (mut quadratic, mut others) = (0, 0);
    for (cell, kind) in cells.iter().zip(types) {
        if !TETRAHEDRA.contains(kind) {
            others += 1;
            continue;
        }
        quadratic += usize::from(*kind == TETRAHEDRA[1]);
        let [a, b, c, d, ..] = cell[..] else {
            let message = format!("a tetrahedron (cell type {kind}) of {} points", cell.len());
            return Err(Error::file(path, message));
        };
        let four = text::resolve(path, [a, b, c, d], mesh.tets.len(), mesh.nodes.len(), 0)?;
        mesh.tets.push(four);
    }
    if mesh.tets.is_empty() {
        let message = format!(
            "the mesh is empty: {} points, no tetrahedra (cell types 10, 24) and {others} other cells",
            mesh.nodes.len()
        );
        return Err(Error::file(path, message));
    }
    let mut notices = Vec::new();
    if quadratic > 0 {
        notices.push(format!(
            "{}: {quadratic} tetrahedra of 10 nodes are read by their 4 corners; quadratic elements get middle nodes anew",
            path.display()
        ));
    }
    if others > 0 {
        notices.push(format!("{}: ignored {others} cells; only tetrahedra are used", path.display()));
    }
    Ok((mesh, notices))
}

/// Words of the file.
struct Words<'p, I> {
    path: &'p Path,
    words: I,
}

impl<'a, I: Iterator<Item = Word<'a>>> Words<'_, I> {
    fn next(&mut self, expected: &str) -> Result<Word<'a>> {
        self.words.next().ok_or_else(|| text::ended(self.path, expected))
    }

    fn integer(&mut self, what: &str) -> Result<(Word<'a>, u64)> {
        let word = self.next(what)?;
        Ok((word, text::integer(self.path, word, what)?))
    }

    fn count(&mut self, what: &str) -> Result<usize> {
        let word = self.next(what)?;
        text::count(self.path, word, what)
    }

    fn reference(&mut self) -> Result<VertexReference> {
        let (word, index) = self.integer("a point of a cell")?;
        Ok(VertexReference { index, line: word.line, column: word.column })
    }

    /// Reads the points of each cell, in the old form (`n a b c ...`) or in that of version 5.
    fn cells(&mut self) -> Result<Vec<Vec<VertexReference>>> {
        let n = self.count("the number of cells")?;
        let size = self.integer("the size of the cells")?.1;
        if size > 64 * MAX_COUNT as u64 {
            return Err(Error::file(self.path, format!("cells of {size} numbers are more than is read")));
        }
        let mut cells = Vec::new();
        if n == 0 {
            return Ok(cells);
        }
        let word = self.next("a cell")?;
        if word.text != "OFFSETS" {
            let mut length = text::integer(self.path, word, "the number of points of a cell")?;
            loop {
                let cell: Result<Vec<_>> = (0..length).map(|_| self.reference()).collect();
                cells.push(cell?);
                if cells.len() == n {
                    return Ok(cells);
                }
                length = self.integer("the number of points of a cell")?.1;
            }
        }
        self.next("the type of the offsets")?;
        let mut offsets = Vec::new();
        for _ in 0..n {
            let (word, offset) = self.integer("an offset")?;
            if offsets.last().is_some_and(|last| offset < *last) || offset > size {
                return Err(text::at(self.path, word, format!("offset {offset} out of order; at most {size}")));
            }
            offsets.push(offset);
        }
        self.next("`CONNECTIVITY`")?;
        self.next("the type of the connectivity")?;
        for pair in offsets.windows(2) {
            let cell: Result<Vec<_>> = (pair[0]..pair[1]).map(|_| self.reference()).collect();
            cells.push(cell?);
        }
        Ok(cells)
    }
}
