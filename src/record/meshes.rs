//! `meshes.npz`: the constant meshes of a run, written once, so that a run folder can be displayed on its own. It holds
//! the object and one pad, in the layout of data sets, or both pads if they differ.

use super::arrays::{io_error, put};
use super::check;
use super::frame::{ElementNodes, PadTopology};
use super::names;
use base::error::{Error, Result};
use base::files::atomic::replace;
use geometry::mesh::TriMesh;
use glam::DVec3;
use ndarray::{Array, Ix1, Ix2};
use ndarray_npy::{NpzReader, NpzWriter, ReadableElement};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Name of the file.
pub const MESHES: &str = "meshes.npz";

/// Writes the meshes to `dir`; the file is replaced atomically.
///
/// # Errors
/// Fails if the file cannot be written.
pub fn write(dir: &Path, pads: &[PadTopology], object: &TriMesh) -> Result<()> {
    replace(&dir.join(MESHES), |temporary| write_to(temporary, pads, object))
}

fn write_to(path: &Path, pads: &[PadTopology], object: &TriMesh) -> io::Result<()> {
    let mut npz = NpzWriter::new(BufWriter::new(File::create(path)?));
    let flat = |v: &[DVec3]| v.iter().flat_map(|p| p.to_array()).collect::<Vec<f64>>();
    for (group, pad) in names::PADS.iter().zip(distinct_pads(pads)) {
        let (nodes, elements) = (pad.rest.len(), &pad.elements);
        let of = |name: &str| format!("{group}/{name}");
        put(&mut npz, &of(names::REST), (nodes, 3), &flat(&pad.rest))?;
        put(&mut npz, &of(names::TETS), (elements.len(), elements.width()), elements.nodes())?;
        put(&mut npz, &of(names::SURFACE), (pad.surface.len(), 3), pad.surface.as_flattened())?;
        put(&mut npz, &of(names::SENSING), (pad.sensing.len(), 3), pad.sensing.as_flattened())?;
        put(&mut npz, &of(names::BONDED), nodes, &pad.bonded)?;
    }
    put(&mut npz, &object_array(names::VERTICES), (object.vertices.len(), 3), &flat(&object.vertices))?;
    put(&mut npz, &object_array(names::TRIANGLES), (object.triangles.len(), 3), object.triangles.as_flattened())?;
    npz.finish().map_err(io_error)?.flush()
}

/// Returns the first pad if all pads are equal, otherwise all.
fn distinct_pads(pads: &[PadTopology]) -> &[PadTopology] {
    if pads.windows(2).all(|pair| pair[0] == pair[1]) { &pads[..pads.len().min(1)] } else { pads }
}

/// Reads the meshes of the run in `dir`: its `count` pads, left first, and the object.
///
/// # Errors
/// Fails if the file is missing or damaged.
pub fn read(dir: &Path, count: usize) -> Result<(Vec<PadTopology>, TriMesh)> {
    let path = dir.join(MESHES);
    let fail = |message: String| Error::file(&path, message);
    let file = File::open(&path)
        .map_err(|e| fail(format!("cannot be read: {e}; runs write it with `arrays.npz`: run the scene again")))?;
    let mut npz = NpzReader::new(file).map_err(|e| fail(format!("is not an archive of arrays: {e}")))?;
    let arrays = npz.names().map_err(|e| fail(format!("is not an archive of arrays: {e}")))?;
    let mut archive = Archive { path: &path, npz: &mut npz };
    let [left, right] = names::PADS;
    let mut pads = vec![archive.pad(left)?; count];
    if let (Some(pad), true) = (pads.get_mut(1), arrays.iter().any(|name| name.starts_with(right))) {
        *pad = archive.pad(right)?;
    }
    pads.iter().enumerate().try_for_each(|(i, pad)| check::topology(i, pad)).map_err(fail)?;
    let object = TriMesh {
        vertices: archive.points(&object_array(names::VERTICES))?,
        triangles: archive.triangles(&object_array(names::TRIANGLES))?,
    };
    check::object(&object).map_err(fail)?;
    Ok((pads, object))
}

fn object_array(name: &str) -> String {
    format!("object/{name}")
}

/// Open archive with its path for error messages.
struct Archive<'a> {
    path: &'a Path,
    npz: &'a mut NpzReader<File>,
}

impl Archive<'_> {
    /// Reads the mesh of a pad.
    fn pad(&mut self, group: &str) -> Result<PadTopology> {
        let of = |name: &str| format!("{group}/{name}");
        let rest = self.points(&of(names::REST))?;
        let tets = self.table::<u32>(&of(names::TETS))?;
        let width = tets.ncols();
        let nodes: Vec<u32> = tets.into_iter().collect();
        let elements = ElementNodes::from_flat(&nodes, width).ok_or_else(|| {
            Error::file(self.path, format!("`{group}/tets` has {width} nodes per tetrahedron; it must be 4 or 10"))
        })?;
        Ok(PadTopology {
            rest,
            corner_count: elements.corners(),
            elements,
            surface: self.triangles(&of(names::SURFACE))?,
            sensing: self.triangles(&of(names::SENSING))?,
            bonded: self.row::<bool>(&of(names::BONDED))?,
        })
    }

    fn table<T: ReadableElement>(&mut self, name: &str) -> Result<Array<T, Ix2>> {
        let fail = |e| Error::file(self.path, format!("array `{name}` cannot be read: {e}"));
        self.npz.by_name(name).map_err(fail)
    }

    fn row<T: ReadableElement>(&mut self, name: &str) -> Result<Vec<T>> {
        let fail = |e| Error::file(self.path, format!("array `{name}` cannot be read: {e}"));
        let row: Array<T, Ix1> = self.npz.by_name(name).map_err(fail)?;
        Ok(row.into_iter().collect())
    }

    fn points(&mut self, name: &str) -> Result<Vec<DVec3>> {
        let numbers: Vec<f64> = self.table::<f64>(name)?.into_iter().collect();
        Ok(numbers.as_chunks::<3>().0.iter().map(|p| DVec3::from_array(*p)).collect())
    }

    fn triangles(&mut self, name: &str) -> Result<Vec<[u32; 3]>> {
        let numbers: Vec<u32> = self.table::<u32>(name)?.into_iter().collect();
        Ok(numbers.as_chunks::<3>().0.to_vec())
    }
}
