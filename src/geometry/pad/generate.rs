//! Generated pads: box, disc and the GelSight Mini gel, flat or domed. All have a flat bonded back face.

use serde::{Deserialize, Serialize};

use super::remesh::onto_outline;
use crate::mesh::{TetMesh, grid};
use crate::pad::{Density, PadMesh, Resolution, dome};
use base::error::{Error, Result};
use base::number::format_number;
use glam::DVec2;

/// Largest side of a generated pad, m.
pub const MAX_SIZE: f64 = 10.0;

/// Size of the GelSight Mini gel along x, y and z, m.
pub const GELSIGHT_MINI: [f64; 3] = [2.0 * dome::HALF_SIZE[0], 2.0 * dome::HALF_SIZE[1], dome::THICKNESS];

/// Profile of the sensing face of the GelSight Mini gel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub enum GelProfile {
    /// Box of 25.25 x 20.75 x 4 mm, as used in most simulators.
    #[default]
    Flat,
    /// Face of the real gel, see [`dome`]: 4 mm thick at the apex, 2.75 mm at the rim.
    Domed,
}

/// Builds a box of `size_x` x `size_y` x `thickness`, m.
///
/// # Errors
/// Fails for a length that is not in (0, [`MAX_SIZE`]] and for a bad resolution.
pub fn box_pad(size_x: f64, size_y: f64, thickness: f64, resolution: &Resolution) -> Result<PadMesh> {
    check_lengths(&[("size_x", size_x), ("size_y", size_y), ("thickness", thickness)])?;
    let cells = resolution.cells_for([size_x, size_y, thickness])?;
    let scaled = |lines: Vec<f64>, by: f64| lines.into_iter().map(|t| t * by).collect::<Vec<f64>>();
    let xs = scaled(resolution.lateral_grid_lines(cells[0]), 0.5 * size_x);
    let ys = scaled(resolution.lateral_grid_lines(cells[1]), 0.5 * size_y);
    let zs = scaled(resolution.layer_grid_lines(cells[2]), thickness);
    Ok(bonded_at_back(grid::structured([&xs, &ys, &zs])?, cells))
}

/// Builds a disc of `radius` and `thickness`, m: a square grid mapped so that its outline becomes the circle.
///
/// The grid needs the same even number of cells along x and y. The rim is a polygon inscribed in the circle, so the
/// volume is slightly too small: by the fraction 0.46 / n^2 for n uniform cells across (n = 20: 0.12 %, n = 60:
/// 0.013 %). The worst tetrahedra lie at the images of the corners of the square; their mean ratio is 0.58 at n = 20,
/// 0.45 at n = 60.
///
/// # Errors
/// Fails for a length that is not in (0, [`MAX_SIZE`]], a bad resolution, and odd or unequal numbers of cells.
pub fn disc_pad(radius: f64, thickness: f64, resolution: &Resolution) -> Result<PadMesh> {
    check_lengths(&[("radius", radius), ("thickness", thickness)])?;
    if let Density::Cells([nx, ny, _]) = resolution.density
        && (nx != ny || nx % 2 == 1)
    {
        return Err(Error::Mesh(format!(
            "a disc pad of {nx} x {ny} cells; one even number for both is needed, such as {0} x {0}",
            nx.max(ny).saturating_add(1) & !1
        )));
    }
    let cells = resolution.cells_for([2.0 * radius, 2.0 * radius, thickness])?;
    let across = resolution.lateral_grid_lines(cells[0]);
    let zs: Vec<f64> = resolution.layer_grid_lines(cells[2]).into_iter().map(|t| t * thickness).collect();
    let mut mesh = grid::structured([&across, &across, &zs])?;
    for p in &mut mesh.nodes {
        *p = (radius * onto_outline(p.truncate(), DVec2::ONE, |_| 1.0)).extend(p.z);
    }
    Ok(bonded_at_back(mesh, cells))
}

/// Builds the gel of a GelSight Mini: 25.25 (x) x 20.75 (y) x 4.0 mm.
///
/// # Errors
/// Fails for a bad resolution.
pub fn gelsight_mini(shape: GelProfile, resolution: &Resolution) -> Result<PadMesh> {
    let [x, y, z] = GELSIGHT_MINI;
    let mut pad = box_pad(x, y, z, resolution)?;
    if shape == GelProfile::Domed {
        for p in &mut pad.mesh.nodes {
            // Columns of nodes are compressed towards the flat back face, whose z remains exact.
            let above_back = p.z + dome::THICKNESS;
            p.z = above_back * (1.0 - dome::depth(p.x, p.y) / dome::THICKNESS) - dome::THICKNESS;
        }
    }
    Ok(pad)
}

/// Bonds the lowest layer of grid nodes, which come first.
fn bonded_at_back(mesh: TetMesh, cells: [usize; 3]) -> PadMesh {
    let back = (cells[0] + 1) * (cells[1] + 1);
    let bonded = (0..mesh.nodes.len()).map(|i| i < back).collect();
    PadMesh { mesh, bonded }
}

fn check_lengths(lengths: &[(&str, f64)]) -> Result<()> {
    match lengths.iter().find(|(_, l)| !(*l > 0.0 && *l <= MAX_SIZE)) {
        None => Ok(()),
        Some((name, l)) => {
            Err(Error::Mesh(format!("pad {name} is {} m; allowed: above 0, up to {MAX_SIZE} m", format_number(*l))))
        }
    }
}
