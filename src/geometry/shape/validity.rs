//! Validity of a surface: whether it bounds a solid once its triangles and shells are oriented.

use crate::mesh::TriMesh;
use crate::mesh::facets::drop_back_to_back;
use crate::mesh::shells::{flat_shell, orient, orient_consistently, shells};
use crate::mesh::topology::check_edges;
use crate::shape::overlap::find_overlaps;
use crate::shape::topology::Topology;
use base::error::{Error, Result};
use base::number::format_count;

/// Orients triangles and shells, and rejects a surface that bounds no solid. Returns a notice for each change.
pub(crate) fn orient_and_check(mesh: &mut TriMesh) -> Result<Vec<String>> {
    let mut news = Vec::new();
    let pairs = drop_back_to_back(mesh);
    if mesh.triangles.is_empty() {
        return Err(Error::Mesh(
            "the object's mesh: it is a sheet, which encloses no volume; give it a thickness".into(),
        ));
    }
    if pairs > 0 {
        news.push(format!("dropped {} of coincident triangles with opposite normals", format_count(pairs, "pair")));
    }
    let odd = orient_consistently(mesh);
    if odd > 0 {
        news.push(format!("reversed {} that disagreed with its neighbours", format_count(odd, "triangle")));
    }
    let edges = check_edges(mesh);
    if [&edges.boundary, &edges.non_manifold, &edges.inconsistent].iter().any(|f| f.count > 0) {
        return Err(Error::Mesh(edges.defect_message().unwrap_or_default()));
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
    let overlaps = find_overlaps(mesh);
    if let Some(fault) = overlaps.error_message(mesh) {
        return Err(Error::Mesh(fault));
    }
    if overlaps.shallow > 0 {
        let n = overlaps.shallow;
        news.push(format!(
            "{n} pairs of triangles cross, none by more than {:e} of the object's size",
            super::overlap::MAX_OVERLAP
        ));
    }
    Ok(news)
}
