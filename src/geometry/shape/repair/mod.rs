//! Repair of surfaces that bound no solid: open, self-intersecting, non-manifold.

mod contour;
mod field;
mod fill;

use crate::mesh::shells::{orient, orient_consistently, shells};
use crate::mesh::topology::{check_edges, drop_unused};
use crate::mesh::{TriMesh, format_point};
use crate::shape::validity::orient_and_check;
use crate::shape::winding::Winding;
use base::error::{Error, Result};
use base::number::format_count;
use field::OccupancyGrid;
use glam::DVec3;

/// Volume, over the total volume, below which a closed part is removed as an artefact (dust).
const SMALL_SHELL: f64 = 1e-3;

/// Returns the surface as a solid: with its holes filled, if that suffices, otherwise the level set of its generalized
/// winding number at one half, sampled on a grid. Also returns a list of the changes, with the displacement of the
/// surface.
pub(crate) fn repair(mesh: TriMesh) -> Result<(TriMesh, Vec<String>)> {
    let mut whole = mesh.clone();
    orient_consistently(&mut whole);
    let filled = fill::fill(&mut whole);
    if let (Some(filled), Ok(news)) = (filled, orient_and_check(&mut whole)) {
        let done = format!(
            "filled {} with {} of {:.3e} m2 in all; nothing else moved",
            format_count(filled.holes, "hole"),
            format_count(filled.triangles, "triangle"),
            filled.area
        );
        return Ok((whole, [vec![done], news].concat()));
    }
    resample(mesh)
}

fn resample(mut mesh: TriMesh) -> Result<(TriMesh, Vec<String>)> {
    orient_consistently(&mut mesh);
    let edges = check_edges(&mesh);
    if let ([a, b], 0) = (edges.inconsistent.first.unwrap_or_default(), edges.non_manifold.count)
        && edges.inconsistent.count > 0
    {
        return Err(Error::Mesh(format!(
            "the surface is one-sided, like a Moebius strip: for any orientation of its triangles, those at the edge \
             from {} to {} disagree, so that it encloses no volume; cut it there, or give it a thickness",
            format_point(a),
            format_point(b)
        )));
    }
    orient(&mut mesh);
    if mesh.triangles.iter().enumerate().all(|(t, _)| crate::mesh::facets::is_flat(mesh.corners(t))) {
        return Err(Error::Mesh("the surface has no area: there is nothing to repair".into()));
    }
    let winding = Winding::new(&mesh);
    let field = OccupancyGrid::new(&winding);
    // Sharp corners first; if the surface is then invalid, for example self-intersecting, corners rounded by a cell.
    let attempt = |sharp: bool| {
        let mut surface = contour::surface(&field, &winding, sharp);
        let dust = drop_small_shells(&mut surface);
        orient_and_check(&mut surface).map(|_| (surface, dust))
    };
    let nothing = |_| {
        let advice =
            "the surface encloses no volume that could be remeshed: give it a thickness, or close it in a mesh editor";
        Error::Mesh(advice.into())
    };
    let (surface, dust) = attempt(true).or_else(|_| attempt(false)).map_err(nothing)?;
    let moved = Moved::of(&surface, &winding, field.step);
    let mut done = format!(
        "remeshed from its winding number on a grid of {:.2e} m: {} triangles; the surface moved by at most {:.2e} m, \
         by {:.2e} m on average",
        field.step,
        surface.triangles.len(),
        moved.most,
        moved.mean
    );
    if moved.new > 0.0 {
        done += &format!("; {:.1} % of its area is new and closes holes", 100.0 * moved.new);
    }
    if dust > 0 {
        done += &format!("; dropped {} of less than {SMALL_SHELL} of its volume", format_count(dust, "closed part"));
    }
    Ok((surface, vec![done]))
}

/// Drops shells whose volume is below [`SMALL_SHELL`] times the total; returns their number.
fn drop_small_shells(mesh: &mut TriMesh) -> usize {
    let shells = shells(mesh);
    let whole: f64 = shells.iter().map(|s| s.volume).sum();
    let small: Vec<_> = shells.into_iter().filter(|s| s.volume.abs() < SMALL_SHELL * whole.abs()).collect();
    let mut gone = vec![false; mesh.triangles.len()];
    small.iter().flat_map(|s| &s.triangles).for_each(|t| gone[*t as usize] = true);
    let mut keep = gone.into_iter().map(|g| !g);
    mesh.triangles.retain(|_| keep.next().unwrap_or(true));
    drop_unused(mesh);
    small.len()
}

/// Distance of a new surface from the old one, at sample points; those farther than a cell count as new surface.
struct Moved {
    /// Largest distance, m.
    most: f64,
    /// Mean distance, m.
    mean: f64,
    /// Fraction of sample points that are farther from the old surface than a cell.
    new: f64,
}

impl Moved {
    fn of(surface: &TriMesh, old: &Winding, cell: f64) -> Self {
        let middle = |t: usize| surface.corners(t).into_iter().sum::<DVec3>() / 3.0;
        let points = surface.vertices.iter().copied().chain((0..surface.triangles.len()).map(middle));
        let away: Vec<f64> = points.map(|p| old.bvh.nearest(p, (f64::INFINITY, u32::MAX)).0.sqrt()).collect();
        let near: Vec<f64> = away.iter().copied().filter(|d| *d <= cell).collect();
        Self {
            most: near.iter().copied().fold(0.0, f64::max),
            mean: near.iter().sum::<f64>() / near.len().max(1) as f64,
            new: 1.0 - near.len() as f64 / away.len().max(1) as f64,
        }
    }
}
