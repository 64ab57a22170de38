//! Triangulation of polygons.

use std::collections::{BTreeMap, VecDeque};

use glam::DVec3;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

/// Splits the polygon with the corners `points` (m) into triangles, given as indices of its corners and with its
/// orientation. The fan from the first corner is used if all its triangles agree with the normal of the polygon;
/// otherwise a constrained Delaunay triangulation of the outline, projected along the coordinate axis closest to the
/// normal. It uses every corner, including those on straight sides. A hole is represented by a slit from the outline to
/// the hole and back.
///
/// Returns None if the outline crosses itself.
pub(crate) fn triangulate(points: &[DVec3]) -> Option<Vec<[usize; 3]>> {
    let fan: Vec<_> = (1..points.len().saturating_sub(1)).map(|i| [0, i, i + 1]).collect();
    let normal = area_vector(points);
    let turns = |t: &[usize; 3]| {
        let [a, b, c] = t.map(|i| points[i]);
        (b - a).cross(c - a).dot(normal) > 1e-12 * normal.length_squared()
    };
    if fan.len() < 2 || normal.length_squared() == 0.0 || fan.iter().all(turns) {
        return Some(fan);
    }
    constrained(points, normal)
}

/// Returns the area vector of the polygon (Newell), along its normal and of twice its area, m2.
fn area_vector(points: &[DVec3]) -> DVec3 {
    let Some(first) = points.first() else { return DVec3::ZERO };
    points.windows(2).map(|p| (p[0] - first).cross(p[1] - first)).sum()
}

fn constrained(points: &[DVec3], normal: DVec3) -> Option<Vec<[usize; 3]>> {
    let size = normal.abs();
    let axis = (0..3).fold(0, |best, k| if size[k] > size[best] { k } else { best });
    let (mut u, mut v) = ((axis + 1) % 3, (axis + 2) % 3);
    if normal[axis] < 0.0 {
        (u, v) = (v, u);
    }
    let mut net = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
    let mut corner_of = BTreeMap::new();
    let mut handles = Vec::with_capacity(points.len());
    for (i, p) in points.iter().enumerate() {
        // Coordinates smaller than the library accepts are set to zero.
        let flat = |x: f64| if x.abs() < spade::MIN_ALLOWED_VALUE { 0.0 } else { x };
        let handle = net.insert(Point2::new(flat(p[u]), flat(p[v]))).ok()?;
        corner_of.entry(handle.index()).or_insert(i);
        handles.push(handle);
    }
    // A slit is traversed twice, so it does not separate inside from outside.
    let mut walked = BTreeMap::new();
    for (i, from) in handles.iter().enumerate() {
        let to = handles[(i + 1) % handles.len()];
        if *from == to {
            continue;
        }
        let stretches = net.try_add_constraint(*from, to);
        if stretches.is_empty() {
            return None;
        }
        for stretch in stretches {
            *walked.entry(stretch.as_undirected().index()).or_insert(false) ^= true;
        }
    }
    // A face is inside if an odd number of outlines separates it from the outer face.
    let mut beside = vec![Vec::new(); net.num_all_faces()];
    for edge in net.undirected_edges() {
        let odd = walked.get(&edge.fix().index()).copied().unwrap_or(false);
        let [one, two] = [edge.as_directed(), edge.as_directed().rev()].map(|e| e.face().fix().index());
        beside[one].push((two, odd));
        beside[two].push((one, odd));
    }
    let mut inside = vec![None; net.num_all_faces()];
    let outer = net.outer_face().fix().index();
    inside[outer] = Some(false);
    let mut next = VecDeque::from([outer]);
    while let Some(face) = next.pop_front() {
        for (other, odd) in &beside[face] {
            if inside[*other].is_none() {
                inside[*other] = inside[face].map(|i| i ^ odd);
                next.push_back(*other);
            }
        }
    }
    let faces = net.inner_faces().filter(|f| inside[f.fix().index()] == Some(true));
    Some(faces.map(|f| f.vertices().map(|v| corner_of[&v.fix().index()])).collect())
}
