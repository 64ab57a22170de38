//! The pads of a scene with coarser or finer cells.

use crate::error::{Error, Result};
use crate::model::pad;
use crate::scene::leaf::{Count, Length};
use crate::scene::pad::{BoxPad, DiscPad, GelSightMini};
use crate::scene::vector::{Cells, Tuple};
use crate::scene::{Element, Pads, defaults};

/// The same pad with cells `factor` times as wide.
///
/// # Errors
/// A pad from a file, whose density is given; a spacing or number of cells that a scene could not name.
pub fn coarser(pads: &Pads, factor: f64) -> Result<Pads> {
    let refused = |what: &str, m: String| Error::Mesh(format!("pads {factor:.3} times as coarse: {what} {m}"));
    let spacing = |l: Length| Length::new(l.get() * factor).map_err(|m| refused("spacing", m));
    Ok(match pads {
        Pads::GelSightMini(g) => Pads::GelSightMini(GelSightMini { spacing: spacing(g.spacing)?, ..*g }),
        Pads::Disc(d) => Pads::Disc(DiscPad { spacing: spacing(d.spacing)?, ..*d }),
        Pads::Box(b) => Pads::Box(match b.cells {
            Some(own) => BoxPad { cells: Some(cells(own, factor).map_err(|m| refused("cells", m))?), ..*b },
            None => BoxPad { spacing: Some(spacing(b.spacing.unwrap_or(defaults::PAD_SPACING))?), ..*b },
        }),
        Pads::File(f) => {
            return Err(Error::file(
                &f.path,
                "a pad from a file has one density, so there is nothing finer to compare with; allowed here: GelSightMini, Box, Disc",
            ));
        }
    })
}

/// Even numbers along x and y, so that the mesh stays mirror-symmetric; the same numbers for a factor of one.
fn cells(own: Cells, factor: f64) -> std::result::Result<Cells, String> {
    if factor == 1.0 {
        return Ok(own);
    }
    let [x, y, z] = own.counts().map(|n| n as f64 / factor);
    let even = |n: f64| Count::new(2 * (0.5 * n).round().max(1.0) as u64);
    Ok(Tuple([even(x)?, even(y)?, Count::new(z.round().max(1.0) as u64)?]))
}

/// How fine a pad is, in words: its spacing or its cells.
pub fn describe(pads: &Pads) -> String {
    let spacing = |l: Length| format!("{:.2} mm", 1e3 * l.get());
    match pads {
        Pads::GelSightMini(g) => spacing(g.spacing),
        Pads::Disc(d) => spacing(d.spacing),
        Pads::Box(b) => match b.cells {
            Some(cells) => cells.counts().map(|n| n.to_string()).join("x"),
            None => spacing(b.spacing.unwrap_or(defaults::PAD_SPACING)),
        },
        Pads::File(f) => f.path.display().to_string(),
    }
}

/// Nodes of one pad with elements of this kind.
///
/// # Errors
/// Those of meshing.
pub fn nodes(pads: &Pads, element: Element) -> Result<usize> {
    let (pad, _) = pad::build(pads, &mut Vec::new())?;
    let middles = match element {
        Element::Linear => 0,
        Element::Quadratic => crate::mesh::quadratic::midpoint_edges(&pad.mesh).len(),
    };
    Ok(pad.mesh.nodes.len() + middles)
}
