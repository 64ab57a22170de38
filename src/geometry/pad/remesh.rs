//! Structured mesh of a pad that is given by another mesh: the same shape, with nodes that do not depend on that mesh.
//!
//! ```text
//! square grid (u, v)  ->  outline of the sensing face     straight lines from its centre are kept
//! layers              ->  between sensing face and back   along z
//! ```
//! The outline must be star-shaped about its centre. A side wall that is not part of the sensing face is replaced by
//! the vertical wall below the outline.

use super::{PadMesh, Resolution};
use crate::barycentric::{barycentric, clamp_to_triangle, min_coordinate};
use crate::face_lookup::FaceLookup;
use crate::mesh::{grid, surface};
use base::error::{Error, Result};
use glam::{DVec2, DVec3, Vec3Swizzles};

/// Shape of a pad, pad frame.
#[derive(Debug, Clone, Copy)]
pub struct PadShape<'a> {
    /// Positions of the nodes, m.
    pub nodes: &'a [DVec3],
    /// Triangles of the outer surface.
    pub surface: &'a [[u32; 3]],
    /// Triangles of the sensing face.
    pub sensing: &'a [[u32; 3]],
    /// Flag per node: true if it is bonded to the finger.
    pub bonded: &'a [bool],
}

/// Smallest thickness of a column of cells, over the thickness of the pad.
const MIN_COLUMN: f64 = 0.1;
/// Difference of the radii of outline and bounding rectangle, relative, below which they are equal: rounding.
const SAME_RADIUS: f64 = 1e-9;
/// Smallest z component of the normal of a triangle at the back, negative.
const BACK_SLOPE: f64 = -0.1;
/// Tolerance of the barycentric coordinates of a point at the rim.
const RIM: f64 = 1e-6;
/// Largest relative difference between the areas of the outline and of the sensing face, seen along z.
const AREA: f64 = 0.05;

/// Meshes the shape of a pad of this thickness, m, with cells of the width `spacing`, m.
///
/// # Errors
/// Fails for a pad without a sensing face, and if the outline of the face is not star-shaped.
pub fn remesh(pad: &PadShape, thickness: f64, spacing: f64) -> Result<PadMesh> {
    // Seen along z.
    let rim: Vec<[DVec2; 2]> =
        surface::rim(pad.sensing).into_iter().map(|edge| edge.map(|i| pad.nodes[i as usize].xy())).collect();
    let ends =
        |pick: fn(DVec2, DVec2) -> DVec2, start: f64| rim.iter().flatten().copied().fold(DVec2::splat(start), pick);
    let (low, high) = (ends(DVec2::min, f64::INFINITY), ends(DVec2::max, f64::NEG_INFINITY));
    let (center, half) = (0.5 * (low + high), 0.5 * (high - low));
    if rim.is_empty() || half.min_element() <= 0.0 || thickness <= 0.0 {
        return Err(Error::Mesh("the pad has no sensing face above its back".into()));
    }
    let resolution = Resolution::spacing(spacing);
    let cells = resolution.cells_for([2.0 * half.x, 2.0 * half.y, thickness])?;
    let lines = [0, 1].map(|k| resolution.lateral_grid_lines(cells[k]));
    let layers = resolution.layer_grid_lines(cells[2]);
    let mut mesh = grid::structured([&lines[0], &lines[1], &layers])?;
    let place = |u: f64, v: f64| center + onto_outline(DVec2::new(u, v), half, |d| radius(&rim, center, d));
    check_area(pad, &lines, place)?;

    let back = Back::of(pad);
    let face = FaceLookup::new(pad.nodes, pad.sensing);
    let columns: Vec<Column> = (lines[1].iter())
        .flat_map(|v| lines[0].iter().map(|u| place(*u, *v)))
        .map(|at| {
            let corners = face.interpolation_at(at.extend(0.0));
            let top = corners.into_iter().map(|(i, w)| pad.nodes[i as usize].z * w).sum();
            let (bottom, bonded) = back.below(at, top).unwrap_or((-thickness, true));
            Column { at, top, bottom: bottom.min(top - MIN_COLUMN * thickness), bonded }
        })
        .collect();
    let nodes = mesh.nodes.iter_mut().zip(columns.iter().cycle());
    for (node, column) in nodes {
        let z = column.top + node.z * (column.top - column.bottom);
        *node = column.at.extend(z);
    }
    let mut bonded: Vec<bool> = (0..mesh.nodes.len()).map(|i| i < columns.len() && columns[i].bonded).collect();
    if !bonded.contains(&true) {
        // A shell that is held at its sides only.
        let [nx, ny] = [0, 1].map(|k| cells[k] + 1);
        let on_rim = |at: usize, count: usize| at == 0 || at == count - 1;
        let at_side = |i: usize| on_rim(i % nx, nx) || on_rim(i / nx, ny);
        bonded = (0..mesh.nodes.len()).map(|i| at_side(i % columns.len())).collect();
    }
    Ok(PadMesh { mesh, bonded })
}

/// Column of nodes.
#[derive(Debug, Clone, Copy)]
struct Column {
    at: DVec2,
    top: f64,
    bottom: f64,
    bonded: bool,
}

/// Returns the distance of the rim from `center` along the unit vector `direction`, m.
fn radius(rim: &[[DVec2; 2]], center: DVec2, direction: DVec2) -> f64 {
    let crossing = |[a, b]: &[DVec2; 2]| {
        let (from, along) = (*a - center, *b - *a);
        let whole = direction.perp_dot(along);
        let part = from.perp_dot(direction) / whole;
        // An edge along the ray is met by its neighbours.
        ((-RIM..=1.0 + RIM).contains(&part)).then(|| from.perp_dot(along) / whole)
    };
    rim.iter().filter_map(crossing).fold(0.0, f64::max)
}

/// Maps a point of the square [-1, 1]^2 into the outline with half sides `half` of its bounding rectangle and radius
/// `radius` in each direction. Points move along their radius, further near the outline, so that cells at the centre
/// keep their shape; a rectangle is mapped linearly.
pub(super) fn onto_outline(square: DVec2, half: DVec2, radius: impl Fn(DVec2) -> f64) -> DVec2 {
    let (outer, at) = (square.abs().max_element(), square * half);
    let length = at.x.hypot(at.y);
    if length == 0.0 {
        return at;
    }
    let ratio = radius(at / length) * outer / length;
    if (ratio - 1.0).abs() < SAME_RADIUS { at } else { at * (1.0 - outer * (1.0 - ratio)) }
}

/// Checks that the grid covers the sensing face.
fn check_area(pad: &PadShape, lines: &[Vec<f64>; 2], place: impl Fn(f64, f64) -> DVec2) -> Result<()> {
    let double = |[a, b, c]: [DVec2; 3]| (b - a).perp_dot(c - a);
    let face: f64 = pad.sensing.iter().map(|t| double(t.map(|i| pad.nodes[i as usize].xy())).abs()).sum();
    let mut covered = 0.0;
    for x in lines[0].windows(2) {
        for y in lines[1].windows(2) {
            let [a, b, c, d] = [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])].map(|(u, v)| place(u, v));
            covered += double([a, b, c]) + double([a, c, d]);
        }
    }
    if (covered - face).abs() <= AREA * face {
        return Ok(());
    }
    Err(Error::Mesh(format!(
        "the sensing face of the pad is not star-shaped about its centre, or folds over itself: {:.1} mm2 seen along the \
         closing direction, its outline encloses {:.1} mm2",
        0.5e6 * face,
        0.5e6 * covered
    )))
}

/// Triangles at the back of a pad, which point away from the object.
struct Back<'a> {
    nodes: &'a [DVec3],
    bonded: &'a [bool],
    triangles: Vec<[u32; 3]>,
}

impl<'a> Back<'a> {
    fn of(pad: &PadShape<'a>) -> Self {
        let looks_back = |t: &&[u32; 3]| {
            let [a, b, c] = t.map(|i| pad.nodes[i as usize]);
            (b - a).cross(c - a).normalize_or_zero().z < BACK_SLOPE
        };
        Self {
            nodes: pad.nodes,
            bonded: pad.bonded,
            triangles: pad.surface.iter().filter(looks_back).copied().collect(),
        }
    }

    /// Returns the height, m, at which a vertical line at the point `at` first leaves the pad below the height `top`, and
    /// whether the surface is bonded there. Beside all triangles, the nearest one counts; None without triangles.
    fn below(&self, at: DVec2, top: f64) -> Option<(f64, bool)> {
        let value = |t: &[u32; 3], l: [f64; 3]| (0..3).map(|k| self.nodes[t[k] as usize].z * l[k]).sum::<f64>();
        let seen = self.triangles.iter().map(|t| (t, barycentric(at, t.map(|i| self.nodes[i as usize].xy()))));
        let (mut highest, mut nearest) = (None, (f64::NEG_INFINITY, None));
        for (t, l) in seen {
            let inside = min_coordinate(l);
            let clamped = clamp_to_triangle(l);
            let here = (value(t, clamped), t.iter().all(|i| self.bonded[*i as usize]));
            if inside > -RIM && here.0 < top && highest.is_none_or(|(z, _)| here.0 > z) {
                highest = Some(here);
            }
            if inside > nearest.0 {
                nearest = (inside, Some(here));
            }
        }
        highest.or(nearest.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pad::{GelProfile, box_pad, disc_pad, gelsight_mini, sensing_faces};

    fn again(pad: &PadMesh, spacing: f64) -> PadMesh {
        let surface: Vec<[u32; 3]> = surface::boundary(&pad.mesh).into_iter().map(|f| f.nodes).collect();
        let sensing: Vec<[u32; 3]> = sensing_faces(pad).into_iter().map(|f| f.nodes).collect();
        let shape = PadShape { nodes: &pad.mesh.nodes, surface: &surface, sensing: &sensing, bonded: &pad.bonded };
        remesh(&shape, pad.thickness(), spacing).unwrap()
    }

    fn volume(pad: &PadMesh) -> f64 {
        let of = |t: &[u32; 4]| {
            let [a, b, c, d] = t.map(|i| pad.mesh.nodes[i as usize]);
            (b - a).cross(c - a).dot(d - a) / 6.0
        };
        pad.mesh.tets.iter().map(of).sum()
    }

    fn farthest(a: &PadMesh, b: &PadMesh) -> f64 {
        assert_eq!(a.mesh.tets, b.mesh.tets);
        assert_eq!(a.bonded, b.bonded);
        a.mesh.nodes.iter().zip(&b.mesh.nodes).map(|(x, y)| x.distance(*y)).fold(0.0, f64::max)
    }

    #[test]
    fn the_mesh_of_a_box_does_not_depend_on_the_mesh_it_is_made_from() {
        let spacing = 2.8e-3;
        let own = box_pad(25.25e-3, 20.75e-3, 4e-3, &Resolution::spacing(spacing)).unwrap();
        for given in [1.3e-3, 2.8e-3, 6e-3] {
            let other = box_pad(25.25e-3, 20.75e-3, 4e-3, &Resolution::spacing(given).with_focus(2.0)).unwrap();
            let off = farthest(&again(&other, spacing), &own);
            assert!(off < 1e-12, "{off} m from {given} m");
        }
    }

    #[test]
    fn discs_and_domes_keep_their_volume_to_the_error_of_their_facets() {
        let fine = Resolution::spacing(1e-3);
        for (pad, least) in
            [(disc_pad(9e-3, 3e-3, &fine).unwrap(), 0.98), (gelsight_mini(GelProfile::Domed, &fine).unwrap(), 0.97)]
        {
            let ratio = volume(&again(&pad, 2.8e-3)) / volume(&pad);
            assert!(least < ratio && ratio < 1.0 + 1e-6, "{ratio}");
        }
    }
}
