//! Conversion of unsupported formats to gmsh, as advice in messages.

use std::path::Path;

/// Returns the command that converts a file to gmsh. (Without `-o`, meshio takes `.msh` for a format of ANSYS; to write
/// version 4.1 it requires data that most files lack.)
pub(super) fn convert(path: &Path) -> String {
    let (name, mesh) = names(path);
    format!("convert it with Python's meshio: `meshio convert -o gmsh22 {name} {mesh}`")
}

/// Returns the names of a file and of the gmsh file to which it is converted.
pub(super) fn names(path: &Path) -> (String, String) {
    let name = |p: &Path| p.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mesh = name(&path.with_extension("msh"));
    let own = name(path);
    let mesh = if mesh == own { format!("gmsh_{mesh}") } else { mesh };
    (own, mesh)
}
