//! Surface of a file that bounds a solid: as given, or repaired.

use crate::mesh::TriMesh;
use crate::shape::repair::repair;
use crate::shape::validity::orient_and_check;
use base::error::{Error, Result};

/// Orients triangles and shells of `mesh` and rejects a surface that bounds no solid, with the location of the fault;
/// with `mend` it is repaired instead. Returns the surface and a notice for each change.
pub fn valid_surface(mesh: TriMesh, mend: bool) -> Result<(TriMesh, Vec<String>)> {
    let mut turned = mesh.clone();
    match orient_and_check(&mut turned) {
        Ok(news) => Ok((turned, news)),
        Err(Error::Mesh(fault)) if mend => {
            let (mesh, news) = repair(mesh)?;
            let fault = fault.split(';').next().unwrap_or_default();
            Ok((mesh, [vec![format!("repaired: {fault}")], news].concat()))
        }
        Err(Error::Mesh(fault)) => Err(Error::Mesh(format!("{fault}, or set `repair: true`"))),
        Err(other) => Err(other),
    }
}
