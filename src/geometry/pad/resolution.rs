//! Resolution of a generated pad: cells or spacing, graded through the thickness and towards the centre.

use serde::{Deserialize, Serialize};

use crate::mesh::{MAX_COUNT, grid};
use base::error::{Error, Result};
use base::number::format_number;

/// Largest thickness of the layer at the sensing face, in spacings.
pub const LAYER_ASPECT: f64 = 1.3;
/// Smallest number of layers chosen from a spacing.
pub const MIN_LAYERS: usize = 2;
/// Largest `grading` and `focus` accepted.
pub const MAX_RATIO: f64 = 20.0;

/// Choice of the number of cells.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Density {
    /// Target spacing of corner nodes on the sensing face at its centre, m. Numbers of cells along x and y become even,
    /// so that the mesh is mirror-symmetric; the layer at the sensing face is at most [`LAYER_ASPECT`] spacings thick
    /// and there are at least [`MIN_LAYERS`].
    Spacing(f64),
    /// Numbers of cells along x, y and z (layers). Even numbers along x and y give a mirror-symmetric mesh; a disc
    /// needs one even number for both.
    Cells([usize; 3]),
}

/// Density and its variation over the pad.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Resolution {
    /// Choice of the number of cells.
    pub density: Density,
    /// Thickness of each layer over that of the layer before it, away from the sensing face. 1 is uniform;
    /// 1..=[`MAX_RATIO`].
    pub grading: f64,
    /// Width of the cells at the rim over those at the centre, varying smoothly. 1 is uniform; 1..=[`MAX_RATIO`].
    pub focus: f64,
}

impl Resolution {
    /// Returns a uniform resolution with the given corner-node spacing on the sensing face, m.
    pub fn spacing(spacing: f64) -> Self {
        Resolution { density: Density::Spacing(spacing), grading: 1.0, focus: 1.0 }
    }

    /// Returns a uniform resolution with the given numbers of cells along x, y, z.
    pub fn cells(cells: [usize; 3]) -> Self {
        Resolution { density: Density::Cells(cells), grading: 1.0, focus: 1.0 }
    }

    /// Sets the ratio by which layers grow away from the sensing face.
    pub fn with_grading(self, grading: f64) -> Self {
        Resolution { grading, ..self }
    }

    /// Sets the ratio of the widths of the cells at the rim and at the centre.
    pub fn with_focus(self, focus: f64) -> Self {
        Resolution { focus, ..self }
    }

    /// Returns the numbers of cells for a pad of `size` x, y, z, m.
    ///
    /// # Errors
    /// Fails for ratios or a spacing out of range, no cells, or more cells than the cap.
    pub fn cells_for(&self, size: [f64; 3]) -> Result<[usize; 3]> {
        for (name, ratio) in [("grading", self.grading), ("focus", self.focus)] {
            if !(1.0..=MAX_RATIO).contains(&ratio) {
                let found = format_number(ratio);
                return Err(Error::Mesh(format!("pad {name} is {found}; allowed: 1 (uniform) to {MAX_RATIO}")));
            }
        }
        let cells = match self.density {
            Density::Cells(cells) => cells,
            Density::Spacing(spacing) => {
                if !(spacing.is_finite() && spacing > 0.0) {
                    let found = format_number(spacing);
                    return Err(Error::Mesh(format!("pad spacing is {found} m; a positive length is needed")));
                }
                // At the centre a cell is 1 / (1 + beta) of the uniform width, see `across`.
                let centre = spacing * (1.0 + self.beta());
                let lateral = |length: f64| at_least(0.5 * length / centre).max(1).saturating_mul(2);
                [lateral(size[0]), lateral(size[1]), self.layers(size[2] / (LAYER_ASPECT * spacing))]
            }
        };
        grid::check_cells(cells)?;
        Ok(cells)
    }

    /// Returns the smallest number of layers for which the first is at most `1/n` of the thickness.
    fn layers(&self, n: f64) -> usize {
        // The sum of a geometric series of m layers, in thicknesses of the first, must reach n.
        let (mut sum, mut layer, mut m) = (0.0, 1.0, 0);
        while (sum < n * (1.0 - 1e-9) && m < MAX_COUNT) || m < MIN_LAYERS {
            sum += layer;
            layer *= self.grading;
            m += 1;
        }
        m
    }

    fn beta(&self) -> f64 {
        beta(self.focus)
    }

    /// Returns the width of the cells at the distance `at` from the centre, in half widths of the pad, over the width
    /// at the centre.
    pub fn width_ratio(focus: f64, at: f64) -> f64 {
        let (beta, mut low, mut high) = (beta(focus), 0.0, 1.0);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if line(beta, middle) < at { low = middle } else { high = middle }
        }
        1.0 + (focus - 1.0) * low * low
    }

    /// Returns the grid lines of `cells` cells over [-1, 1], exactly symmetric about 0:
    /// `t (1 + beta t^2) / (1 + beta)`, whose slope at the rim is `focus` times that at the centre.
    pub(crate) fn lateral_grid_lines(&self, cells: usize) -> Vec<f64> {
        let beta = self.beta();
        (0..=cells).map(|i| line(beta, (2.0 * i as f64 - cells as f64) / cells as f64)).collect()
    }

    /// Returns the grid lines of `layers` layers over [-1, 0], from the bonded face (-1) to the sensing face (0).
    pub(crate) fn layer_grid_lines(&self, layers: usize) -> Vec<f64> {
        let mut depth = vec![0.0];
        let (mut sum, mut layer) = (0.0, 1.0);
        for _ in 0..layers {
            sum += layer;
            layer *= self.grading;
            depth.push(sum);
        }
        depth.iter().rev().map(|d| 0.0 - d / sum).collect()
    }
}

/// Number of bisections for the grid line at a position: about the precision of a double, in bits.
const BISECTIONS: u32 = 50;

fn beta(focus: f64) -> f64 {
    (focus - 1.0) / 3.0
}

/// Maps the grid line `t` in -1..=1 of a uniform grid to its graded position.
fn line(beta: f64, t: f64) -> f64 {
    t * (1.0 + beta * t * t) / (1.0 + beta)
}

/// Returns the smallest count that is at least `x`, with tolerance for rounding; saturates.
fn at_least(x: f64) -> usize {
    (x * (1.0 - 1e-9)).ceil().max(0.0) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_as_wide_as_the_grid_lines_say() {
        let lines = Resolution::cells([1; 3]).with_focus(2.0).lateral_grid_lines(2000);
        let ratio = |k: usize| (lines[k + 1] - lines[k]) / (lines[1001] - lines[1000]);
        for k in [1000, 1300, 1600, 1999] {
            let found = Resolution::width_ratio(2.0, lines[k]);
            assert!((found - ratio(k)).abs() < 5e-3, "{found} for {}", ratio(k));
        }
    }
}
