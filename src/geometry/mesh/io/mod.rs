//! Reading and writing of mesh files; the extension determines the format. Coordinates are taken as metres.

mod convert;
mod file;
mod gmsh;
mod medit;
mod obj;
mod ply;
mod stl;
mod tet;
mod tetgen;
pub(crate) mod text;
mod vtk;
mod write;

use std::path::Path;

pub use write::{write_obj, write_stl, write_tet};

use crate::mesh::{MAX_COORDINATE, TetMesh, TriMesh, clean, facets, is_out_of_range, topology, weld};
use base::error::{Error, Result};
use base::number::format_count;
use convert::{convert, names};
use file::read_bytes;
pub(crate) use file::read_text;

/// Supported formats of triangle meshes, for messages.
const SURFACES: &str =
    ".obj, .stl, .ply (a STEP or IGES solid: export it as STL; glTF, OFF, 3MF, DAE: convert with MeshLab or Blender)";

/// Reads a tetrahedral mesh and repairs it with [`clean::repair`]: `.tet` (Isaac Gym), `.msh` (gmsh 2.2, 4.0 or 4.1,
/// ASCII or binary, tetrahedra of first or second order), `.mesh` (Medit ASCII), `.vtk` (legacy, ASCII or binary) or
/// `.node` with `.ele` (TetGen). Returns the mesh (m) and notices about everything that was changed or omitted.
///
/// # Errors
/// Fails for a missing file, an unknown extension (with advice on the conversion, if there is any), a bad number, index
/// or column count (with line and column), an empty mesh, more than [`crate::mesh::MAX_COUNT`] nodes, and in
/// the cases of [`clean::repair`], with the file's name.
pub fn read_tet_mesh(path: impl AsRef<Path>) -> Result<(TetMesh, Vec<String>)> {
    let path = path.as_ref();
    let (mut mesh, mut notices) = read_tet_mesh_raw(path)?;
    let repaired = clean::repair(&mut mesh).map_err(|e| Error::file(path, e.to_string()))?;
    notices.extend(repaired.into_iter().map(|n| format!("{}: {n}", path.display())));
    Ok((mesh, notices))
}

/// Reads a mesh like [`read_tet_mesh`], but without the repair: nodes and tetrahedra are in the order and winding of
/// the file, indices are valid and coordinates finite. It is meant for files that come with lists of node numbers.
///
/// # Errors
/// Fails in those cases of [`read_tet_mesh`] that concern the file and not the geometry.
pub fn read_tet_mesh_raw(path: impl AsRef<Path>) -> Result<(TetMesh, Vec<String>)> {
    read_tet_group(path, None)
}

/// Reads the tetrahedra of one group of a mesh like [`read_tet_mesh_raw`], with all nodes of the file: those of the
/// physical volume of this name or tag of a gmsh file. None reads all.
///
/// # Errors
/// Fails in the cases of [`read_tet_mesh_raw`], and if the file has no such group.
pub fn read_tet_group(path: impl AsRef<Path>, group: Option<&str>) -> Result<(TetMesh, Vec<String>)> {
    let path = path.as_ref();
    match (extension(path).as_str(), group) {
        ("msh", _) => gmsh::parse(path, read_bytes(path)?, group),
        (other, Some(group)) => {
            let message =
                format!("group {group:?}: groups of files of type `.{}` are not supported", other.escape_debug());
            Err(Error::file(path, format!("{message}; convert it to gmsh (.msh), or leave `group` out")))
        }
        (known, None) => read_by_extension(path, known),
    }
}

/// Reads a mesh of a format without groups.
fn read_by_extension(path: &Path, extension: &str) -> Result<(TetMesh, Vec<String>)> {
    match extension {
        "tet" => tet::parse(path, &read_text(path)?),
        "mesh" => medit::parse(path, read_bytes(path)?),
        "vtk" => vtk::parse(path, read_bytes(path)?),
        "node" | "ele" => tetgen::read(path),
        other => {
            let allowed = ".tet, .msh (gmsh), .mesh (Medit ASCII), .vtk (legacy ASCII), .node with .ele (TetGen)";
            Err(unknown(path, other, &format!("{allowed}{}", advice(path, other))))
        }
    }
}

/// Reads a triangle mesh: `.obj` (all groups merged, polygons triangulated), `.stl` or `.ply` (binary or ASCII). Welds
/// equal vertices and, where the surface is not closed, those within [`weld::tolerance`]; drops repeated triangles and
/// triangles without area. Returns the mesh (m) and notices. [`topology::check_edges`] checks if it is closed.
///
/// # Errors
/// Fails for a missing file, an unknown extension, bad content (with line and column where they exist) and an empty
/// mesh.
pub fn read_tri_mesh(path: impl AsRef<Path>) -> Result<(TriMesh, Vec<String>)> {
    let path = path.as_ref();
    let (mut mesh, mut notices) = match extension(path).as_str() {
        "obj" => obj::parse(path, &read_text(path)?)?,
        "stl" => stl::parse(path, read_bytes(path)?)?,
        "ply" => ply::parse(path, &read_bytes(path)?)?,
        other => return Err(unknown(path, other, SURFACES)),
    };
    // The following steps compare lengths, which must not overflow.
    let far = mesh.triangles.iter().flatten().map(|v| (v, mesh.vertices[*v as usize]));
    if let Some((v, p)) = far.into_iter().find(|(_, p)| is_out_of_range(*p)) {
        let message =
            format!("vertex {v} (0-based) is at {p}; coordinates must be finite and within {MAX_COORDINATE:e}");
        return Err(Error::file(path, message));
    }
    let mut told = |text: String| notices.push(format!("{}: {text}", path.display()));
    // Every facet of an STL file has its own corners, so welding them is not reported.
    let news = extension(path) != "stl";
    let welded = topology::weld(&mut mesh);
    if news && welded.vertices > 0 {
        told(format!("welded {}", format_count(welded.vertices, "duplicate or unused vertex")));
    }
    if welded.triangles > 0 {
        told(format!("dropped {} with a repeated vertex", format_count(welded.triangles, "triangle")));
    }
    if let Some(closed) = weld::weld_faulty_edges(&mut mesh) {
        told(format!(
            "welded {} at open edges with others within {:.2e} m (1e-6 of the object's size and the rounding to 32 \
             bits); none moved by more than {:.2e} m",
            format_count(closed.vertices, "vertex"),
            closed.tolerance,
            closed.moved
        ));
    }
    let repeated = facets::drop_repeated(&mut mesh);
    if repeated > 0 {
        told(format!("dropped {}", format_count(repeated, "repeated triangle")));
    }
    let flat = facets::remove_flat(&mut mesh);
    if flat > 0 {
        told(format!("removed {} without area", format_count(flat, "triangle")));
    }
    if mesh.triangles.is_empty() {
        return Err(Error::file(path, "the mesh is empty: every triangle has a repeated vertex or no area"));
    }
    Ok((mesh, notices))
}

/// Returns the extension in lower case, empty if there is none.
fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

fn unknown(path: &Path, extension: &str, allowed: &str) -> Error {
    Error::file(path, format!("file type `.{}` is not supported here; allowed: {allowed}", extension.escape_debug()))
}

/// Returns advice, after a `; `, on the conversion of a file of an unsupported format to a supported one.
fn advice(path: &Path, extension: &str) -> String {
    match extension {
        "meshb" | "vtu" | "xdmf" | "inp" | "nas" | "bdf" | "med" | "exo" | "e" | "cgns" | "avs" | "su2" | "ugrid" => {
            format!("; {}", convert(path))
        }
        "step" | "stp" | "iges" | "igs" | "brep" | "geo" => {
            let (name, mesh) = names(path);
            format!("; mesh it: `gmsh -3 {name} -o {mesh}`")
        }
        "stl" | "obj" | "ply" | "off" => {
            "; a surface has no volume elements: mesh its volume with tetrahedra, by gmsh or TetGen".into()
        }
        _ => String::new(),
    }
}
