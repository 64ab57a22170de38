//! Pads of a scene with coarser or finer cells.

use base::error::{Error, Result};
use model::part::pad;
use scene::leaf::{Count, Length, Ratio};
use scene::pad::{BoxPad, DiscPad, GelSightMini};
use scene::vector::{Cells, Tuple};
use scene::{Element, Pads};

/// Returns the same pad with cells that are `factor` times as wide.
///
/// # Errors
/// Fails for a pad from a file, whose mesh is fixed, and for a spacing or number of cells that is invalid in a scene.
pub fn coarser(pads: &Pads, factor: f64) -> Result<Pads> {
    if factor == 1.0 {
        return Ok(pads.clone());
    }
    let refused = |what: &str, m: String| Error::Mesh(format!("pads {factor:.3} times as coarse: {what} {m}"));
    let spacing = |l: Length| Length::new(l.get() * factor).map(Some).map_err(|m| refused("spacing", m));
    Ok(match pads {
        Pads::GelSightMini(g) => Pads::GelSightMini(GelSightMini { spacing: spacing(g.mesh_spacing())?, ..*g }),
        Pads::Disc(d) => Pads::Disc(DiscPad { spacing: spacing(d.mesh_spacing())?, ..*d }),
        Pads::Box(b) => Pads::Box(match b.cells {
            Some(own) => BoxPad { cells: Some(cells(own, factor).map_err(|m| refused("cells", m))?), ..*b },
            None => BoxPad { spacing: spacing(b.mesh_spacing())?, ..*b },
        }),
        Pads::File(f) => {
            return Err(Error::file(
                &f.path,
                "the mesh of a pad from a file is fixed and cannot be refined or coarsened; allowed here: \
                 GelSightMini, Box, Disc",
            ));
        }
    })
}

/// Focus of the mesh of another kind, and the factor by which it narrows the cells at the centre if their number is
/// kept.
const FOCUS: (f64, f64) = (2.0, 4.0 / 3.0);

/// Returns a mesh of another kind for the same pad, with other grid lines and therefore another discretisation error:
/// about the same cells at the centre and wider ones towards the rim, or uniform cells if the given mesh is graded in
/// this way. None for a pad from a file.
///
/// # Errors
/// Fails in the cases of [`coarser`].
pub fn alternative_mesh(pads: &Pads) -> Result<Option<Pads>> {
    let of = |focus: Ratio| Ratio::new_unchecked(if focus.get() < FOCUS.0 { FOCUS.0 } else { 1.0 });
    Ok(Some(match pads {
        Pads::GelSightMini(g) => Pads::GelSightMini(GelSightMini { focus: of(g.focus), ..*g }),
        Pads::Disc(d) => Pads::Disc(DiscPad { focus: of(d.focus), ..*d }),
        Pads::Box(b) => {
            // A spacing refers to the centre, so only a given number of cells must be changed.
            let wider = if of(b.focus).get() > 1.0 { FOCUS.1 } else { 1.0 / FOCUS.1 };
            let pads = if b.cells.is_some() { coarser(pads, wider)? } else { pads.clone() };
            match pads {
                Pads::Box(b) => Pads::Box(BoxPad { focus: of(b.focus), ..b }),
                other => other,
            }
        }
        Pads::File(_) => return Ok(None),
    }))
}

/// Returns coarser numbers of cells, even along x and y so that the mesh remains mirror-symmetric.
fn cells(own: Cells, factor: f64) -> std::result::Result<Cells, String> {
    let [x, y, z] = own.counts().map(|n| n as f64 / factor);
    let even = |n: f64| Count::new(2 * (0.5 * n).round().max(1.0) as u64);
    Ok(Tuple([even(x)?, even(y)?, Count::new(z.round().max(1.0) as u64)?]))
}

/// Describes the mesh of a pad: its spacing or numbers of cells, and its focus.
pub fn describe(pads: &Pads) -> String {
    let spacing = |l: Length| format!("{:.2} mm", 1e3 * l.get());
    let (density, focus) = match pads {
        Pads::GelSightMini(g) => (spacing(g.mesh_spacing()), g.focus.get()),
        Pads::Disc(d) => (spacing(d.mesh_spacing()), d.focus.get()),
        Pads::Box(b) => match b.cells {
            Some(cells) => (cells.counts().map(|n| n.to_string()).join("x"), b.focus.get()),
            None => (spacing(b.mesh_spacing()), b.focus.get()),
        },
        Pads::File(f) => (f.path.display().to_string(), 1.0),
    };
    if focus == 1.0 { density } else { format!("{density} focus {focus}") }
}

/// Returns the number of nodes of one pad with elements of this kind.
///
/// # Errors
/// Fails if the pad cannot be meshed.
pub fn nodes(pads: &Pads, element: Element) -> Result<usize> {
    let (pad, _) = pad::build(pads, &mut Vec::new())?;
    let middles = match element {
        Element::Linear => 0,
        Element::Quadratic => geometry::mesh::quadratic::midpoint_edges(&pad.mesh).len(),
    };
    Ok(pad.mesh.nodes.len() + middles)
}
