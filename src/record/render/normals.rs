//! Vertex normals for shading: averaged over smooth regions, discontinuous at sharp edges.

use glam::DVec3;

/// Cosine of the crease angle (40 degrees): faces whose normals differ by more do not share a vertex normal.
const CREASE_COSINE: f64 = 0.766;

/// Returns the normal at each corner of each triangle: the area-weighted mean over the faces at that vertex whose
/// normals differ by less than the crease angle.
pub fn corner_normals(positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<[DVec3; 3]> {
    let faces: Vec<DVec3> = triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|i| positions[i as usize]);
            (b - a).cross(c - a)
        })
        .collect();
    let mut around: Vec<Vec<u32>> = vec![Vec::new(); positions.len()];
    for (face, triangle) in (0..).zip(triangles) {
        for &node in triangle {
            around[node as usize].push(face);
        }
    }
    let smooth = |face: usize, node: u32| {
        let own = faces[face].normalize_or_zero();
        let near = around[node as usize].iter().map(|&f| faces[f as usize]);
        near.filter(|n| n.normalize_or_zero().dot(own) > CREASE_COSINE).sum::<DVec3>().normalize_or(own)
    };
    triangles.iter().enumerate().map(|(face, t)| t.map(|node| smooth(face, node))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_right_angle_stays_sharp_and_a_gentle_bend_is_smoothed() {
        let bent =
            |z: f64| vec![DVec3::ZERO, DVec3::Y, DVec3::new(-1.0, 0.0, 0.0), DVec3::new((1.0 - z * z).sqrt(), 0.0, z)];
        let triangles = [[0, 1, 2], [1, 0, 3]];
        let sharp = corner_normals(&bent(1.0), &triangles);
        assert!(sharp[0][0].dot(sharp[1][1]).abs() < 1e-12);
        let gentle = corner_normals(&bent(0.3), &triangles);
        assert!(gentle[0][0].dot(gentle[1][1]) > 0.9999);
    }
}
