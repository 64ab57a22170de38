//! Writers. Every file is written atomically: to a temporary file in the same folder, which is then renamed.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use glam::DVec3;

use crate::mesh::{TetMesh, TriMesh};
use base::error::{Error, Result};
use base::files::atomic::replace;

/// Writes `path` atomically through `fill`.
///
/// # Errors
/// Fails if the folder does not exist or is not writable or the disk is full; no partial file remains in these cases.
fn atomically(path: &Path, fill: impl FnOnce(&mut dyn Write) -> std::io::Result<()>) -> Result<()> {
    replace(path, |temporary| {
        let mut out = BufWriter::new(File::create(temporary)?);
        fill(&mut out)?;
        out.into_inner().map_err(std::io::IntoInnerError::into_error)?.sync_all()
    })
}

/// Writes a `.tet` file (4-column `v` lines with tag 0, as the tools of the format expect). Coordinates (m) are
/// recovered exactly on reading.
///
/// # Errors
/// Fails if the file cannot be written.
pub fn write_tet(path: impl AsRef<Path>, mesh: &TetMesh) -> Result<()> {
    atomically(path.as_ref(), |out| {
        writeln!(out, "# Tetrahedral mesh written by tactus, metres")?;
        writeln!(out, "\n# {} vertices", mesh.nodes.len())?;
        for p in &mesh.nodes {
            writeln!(out, "v {} {} {} 0", p.x, p.y, p.z)?;
        }
        writeln!(out, "\n# {} tetrahedra", mesh.tets.len())?;
        for [a, b, c, d] in &mesh.tets {
            writeln!(out, "t {a} {b} {c} {d}")?;
        }
        Ok(())
    })
}

/// Writes an `.obj` file. Coordinates (m) are recovered exactly on reading.
///
/// # Errors
/// Fails if the file cannot be written.
pub fn write_obj(path: impl AsRef<Path>, mesh: &TriMesh) -> Result<()> {
    atomically(path.as_ref(), |out| {
        writeln!(out, "# Triangle mesh written by tactus, metres")?;
        for p in &mesh.vertices {
            writeln!(out, "v {} {} {}", p.x, p.y, p.z)?;
        }
        for [a, b, c] in &mesh.triangles {
            let one = |i: &u32| u64::from(*i) + 1;
            writeln!(out, "f {} {} {}", one(a), one(b), one(c))?;
        }
        Ok(())
    })
}

/// Writes a binary `.stl` file: coordinates in m are rounded to f32, as the format requires.
///
/// # Errors
/// Fails for an index out of range, for a coordinate outside the range of f32, and if the file cannot be written.
pub fn write_stl(path: impl AsRef<Path>, mesh: &TriMesh) -> Result<()> {
    let path = path.as_ref();
    let single = |p: DVec3| p.to_array().map(|x| x as f32);
    let mut facets = Vec::with_capacity(mesh.triangles.len());
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let mut corners = [DVec3::ZERO; 3];
        for (corner, i) in corners.iter_mut().zip(triangle) {
            let n = mesh.vertices.len();
            *corner = *mesh.vertices.get(*i as usize).ok_or_else(|| {
                Error::Mesh(format!("triangle {t} refers to vertex {i}, but there are {n} vertices (0-based)"))
            })?;
            if single(*corner).iter().any(|x| !x.is_finite()) {
                return Err(Error::Mesh(format!("vertex {i} = {corner} cannot be written as f32, which STL requires")));
            }
        }
        let [a, b, c] = corners;
        facets.push(stl_io::Triangle {
            normal: stl_io::Normal::new(single((b - a).cross(c - a).normalize_or_zero())),
            vertices: corners.map(|p| stl_io::Vertex::new(single(p))),
        });
    }
    atomically(path, |mut out| stl_io::write_stl(&mut out, facets.iter()))
}
