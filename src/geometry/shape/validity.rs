//! Validity of a surface: whether it bounds a solid once its triangles and shells are oriented.

use crate::mesh::TriMesh;
use crate::mesh::facets::drop_back_to_back;
use crate::mesh::shells::{flat_shell, orient, orient_consistently, shells};
use crate::mesh::topology::watertight;
use crate::shape::overlap::overlaps;
use crate::shape::topology::Topology;
use base::error::{Error, Result};
use base::number::counted;

/// Orients triangles and shells, and rejects a surface that bounds no solid. Returns a notice for each change.
pub(crate) fn judge(mesh: &mut TriMesh) -> Result<Vec<String>> {
    let mut news = Vec::new();
    let pairs = drop_back_to_back(mesh);
    if mesh.triangles.is_empty() {
        return Err(Error::Mesh(
            "the object's mesh: it is a sheet, which encloses no volume; give it a thickness".into(),
        ));
    }
    if pairs > 0 {
        news.push(format!("dropped {} of coincident triangles with opposite normals", counted(pairs, "pair")));
    }
    let odd = orient_consistently(mesh);
    if odd > 0 {
        news.push(format!("reversed {} that disagreed with its neighbours", counted(odd, "triangle")));
    }
    let edges = watertight(mesh);
    if [&edges.open, &edges.crowded, &edges.twisted].iter().any(|f| f.count > 0) {
        return Err(Error::Mesh(edges.complaint().unwrap_or_default()));
    }
    Topology::new(mesh)?;
    if let Some(fault) = flat_shell(mesh) {
        return Err(Error::Mesh(fault));
    }
    let turned = orient(mesh);
    let parts = shells(mesh).len();
    if turned.outward > 0 {
        news.push(format!(
            "reversed {} of {parts} closed parts of the surface, which were oriented inward",
            turned.outward
        ));
    }
    if turned.inward > 0 {
        news.push(format!(
            "oriented {} of {parts} closed parts of the surface inward: they are inside others and bound cavities",
            turned.inward
        ));
    }
    let overlaps = overlaps(mesh);
    if let Some(fault) = overlaps.complaint(mesh) {
        return Err(Error::Mesh(fault));
    }
    if overlaps.shallow > 0 {
        let n = overlaps.shallow;
        news.push(format!(
            "{n} pairs of triangles cross, none by more than {:e} of the object's size",
            super::overlap::DEPTH
        ));
    }
    Ok(news)
}
