//! Shape quality of the tetrahedra of a mesh.

use glam::DVec3;

use crate::mesh::{TetMesh, signed_volume};

/// Six edges of a tetrahedron as pairs of corners, in the order of the mid-edge nodes of [`super::quadratic`].
pub const EDGES: [(usize, usize); 6] = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)];

/// Computes the mean ratio of a tetrahedron, `12 (3 V)^(2/3) / (sum of squared edge lengths)`, in [0, 1]: 1 for a regular
/// tetrahedron, 0 for a flat or inverted one. (A. Liu and B. Joe, "Relationship between tetrahedron shape measures", BIT
/// 34 (1994) 268-287.)
pub fn mean_ratio(corners: [DVec3; 4]) -> f64 {
    let sum: f64 = EDGES.iter().map(|(a, b)| corners[*a].distance_squared(corners[*b])).sum();
    let volume = signed_volume(corners).max(0.0);
    if sum > 0.0 { 12.0 * (3.0 * volume).cbrt().powi(2) / sum } else { 0.0 }
}

/// Number of bins of [`Quality::histogram`].
pub const BINS: usize = 10;

/// Quality of a whole mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Quality {
    /// Index of the tetrahedron with the lowest mean ratio.
    pub worst_index: usize,
    /// Mean ratio of that tetrahedron, in [0, 1].
    pub worst: f64,
    /// Centroid of that tetrahedron, m.
    pub worst_centroid: DVec3,
    /// Smallest signed volume, m^3.
    pub min_volume: f64,
    /// Sum of the signed volumes, m^3.
    pub total_volume: f64,
    /// Mean of the mean ratios.
    pub mean: f64,
    /// Number of tetrahedra per tenth of mean ratio: bin k counts [k/10, (k+1)/10), the last one also 1.
    pub histogram: [usize; BINS],
    /// Shortest edge, m.
    pub min_edge: f64,
    /// Longest edge, m.
    pub max_edge: f64,
}

/// Measures the quality of every tetrahedron; returns None for a mesh without any. Indices must be valid.
pub fn quality(mesh: &TetMesh) -> Option<Quality> {
    let mut report = Quality {
        worst_index: 0,
        worst: f64::INFINITY,
        worst_centroid: DVec3::ZERO,
        min_volume: f64::INFINITY,
        total_volume: 0.0,
        mean: 0.0,
        histogram: [0; BINS],
        min_edge: f64::INFINITY,
        max_edge: 0.0,
    };
    for t in 0..mesh.tets.len() {
        let corners = mesh.corners(t);
        let ratio = mean_ratio(corners);
        let volume = signed_volume(corners);
        if ratio < report.worst {
            report.worst = ratio;
            report.worst_index = t;
            report.worst_centroid = corners.iter().sum::<DVec3>() / 4.0;
        }
        report.min_volume = report.min_volume.min(volume);
        report.total_volume += volume;
        report.mean += ratio / mesh.tets.len() as f64;
        report.histogram[((ratio * BINS as f64) as usize).min(BINS - 1)] += 1;
        for (a, b) in EDGES {
            let length = corners[a].distance(corners[b]);
            report.min_edge = report.min_edge.min(length);
            report.max_edge = report.max_edge.max(length);
        }
    }
    (!mesh.tets.is_empty()).then_some(report)
}

/// Returns the signed volume of every tetrahedron, m^3, length `tets`. Indices must be valid.
pub fn volumes(mesh: &TetMesh) -> Vec<f64> {
    (0..mesh.tets.len()).map(|t| signed_volume(mesh.corners(t))).collect()
}
