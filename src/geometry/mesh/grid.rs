//! Box of hexahedral cells, each split into six tetrahedra, mirror-symmetric about the mid-planes in x and y.

use glam::DVec3;

use crate::mesh::{MAX_COUNT, TetMesh};
use base::error::{Error, Result};

/// Six Kuhn paths from corner 000 to corner 111 of a cell: the axes in the order in which they are traversed. Odd
/// permutations give negative volume in right-handed axes.
const PATHS: [([usize; 3], bool); 6] = [
    ([0, 1, 2], true),
    ([1, 2, 0], true),
    ([2, 0, 1], true),
    ([0, 2, 1], false),
    ([2, 1, 0], false),
    ([1, 0, 2], false),
];

/// Returns the node index of grid point `[i, j, k]` with `points` points per axis: x fastest, z slowest.
pub fn node(points: [usize; 3], [i, j, k]: [usize; 3]) -> usize {
    i + points[0] * (j + points[1] * k)
}

/// Builds a mesh over the grid lines `lines[axis]`, m, each strictly increasing. Nodes run x fastest, z slowest.
///
/// Each cell is split into six tetrahedra around its main diagonal (Kuhn). The diagonal starts at the corner closest to
/// the centre of the grid in x and y. Faces therefore match between cells, and the mesh is its own mirror image about
/// the mid-planes in x and y if the numbers of cells along them are even and the lines are symmetric.
///
/// # Errors
/// Fails for fewer than two lines on an axis, for lines that are not increasing or not finite, and for more nodes than
/// the cap.
pub fn structured(lines: [&[f64]; 3]) -> Result<TetMesh> {
    for (axis, values) in ["x", "y", "z"].iter().zip(lines) {
        if values.len() < 2 {
            return Err(Error::Mesh(format!("a grid needs at least 2 lines along {axis}, got {}", values.len())));
        }
        if !values.iter().all(|v| v.is_finite()) || values.windows(2).any(|w| w[0] >= w[1]) {
            return Err(Error::Mesh(format!("the grid lines along {axis} must be finite and strictly increasing")));
        }
    }
    let cells = lines.map(|l| l.len() - 1);
    check_cells(cells)?;
    let mut nodes = Vec::with_capacity(lines.iter().map(|l| l.len()).product());
    for z in lines[2] {
        for y in lines[1] {
            nodes.extend(lines[0].iter().map(|x| DVec3::new(*x, *y, *z)));
        }
    }
    Ok(TetMesh { nodes, tets: split(cells) })
}

/// Rejects zero cells and numbers of cells whose nodes or tetrahedra exceed the cap.
///
/// # Errors
/// Returns [`Error::Mesh`] with the numbers and the allowed range.
pub fn check_cells(cells: [usize; 3]) -> Result<()> {
    if cells.contains(&0) {
        return Err(Error::Mesh(format!("a grid of {cells:?} cells; at least 1 along each axis is needed")));
    }
    let tets = cells.iter().try_fold(6_usize, |n, c| n.checked_mul(*c));
    match tets {
        Some(n) if n <= MAX_COUNT => Ok(()),
        _ => Err(Error::Mesh(format!(
            "a grid of {cells:?} cells has more than the {MAX_COUNT} tetrahedra allowed; use a larger spacing"
        ))),
    }
}

/// Returns the tetrahedra of a grid of `cells`.
fn split(cells: [usize; 3]) -> Vec<[u32; 4]> {
    let points = cells.map(|c| c + 1);
    let mut tets = Vec::with_capacity(6 * cells[0] * cells[1] * cells[2]);
    for k in 0..cells[2] {
        for j in 0..cells[1] {
            for i in 0..cells[0] {
                let flip = [2 * i + 1 < cells[0], 2 * j + 1 < cells[1], false];
                let mirrored = flip.iter().filter(|f| **f).count() % 2 == 1;
                for (path, even) in PATHS {
                    let mut at = [0; 3];
                    let corner = |at: [usize; 3]| {
                        let local = |axis: usize| if flip[axis] { 1 - at[axis] } else { at[axis] };
                        node(points, [i + local(0), j + local(1), k + local(2)]) as u32
                    };
                    let mut tet = [corner(at); 4];
                    for (slot, axis) in tet[1..].iter_mut().zip(path) {
                        at[axis] = 1;
                        *slot = corner(at);
                    }
                    if even == mirrored {
                        tet.swap(2, 3);
                    }
                    tets.push(tet);
                }
            }
        }
    }
    tets
}
