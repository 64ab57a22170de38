//! Side of a pad surface on which a point lies whose closest point is on an edge or corner shared by faces.
//!
//! The normal of one of the faces does not determine the side: at a sharp fold, such as that over an edge of the
//! object, the point may be behind one face and yet outside. The angle-weighted pseudo-normal of all faces that meet
//! there determines it (Baerentzen and Aanaes 2005).

use super::closest_point::ClosestPoint;
use super::surface::{ContactSurface, ON_RIM, SurfaceFace, face_frame, tangents};
use geometry::mesh::adjacency::TrianglePart;
use glam::DVec3;

impl ClosestPoint {
    /// Returns the closest point of `y` with the sign of the whole surface at node positions `x`, not of its face
    /// alone.
    pub(crate) fn signed(self, surface: &ContactSurface, x: &[DVec3], y: DVec3) -> Self {
        if self.l.iter().all(|v| *v > ON_RIM) {
            return self;
        }
        let face = &surface.faces[self.face];
        let away = y - face.stencil(self.l).position(x);
        let distance = away.length();
        let pseudo = pseudo_normal(surface, x, &self);
        if face.touches(x, distance) {
            return Self { normal: pseudo, gap: away.dot(pseudo), ..self };
        }
        let side = if away.dot(pseudo) < 0.0 { -1.0 } else { 1.0 };
        Self { normal: away * (side / distance), gap: side * distance, ..self }
    }
}

/// Sum of the normals of the faces that meet at a closest point, at a corner weighted by their angles there; unit.
fn pseudo_normal(surface: &ContactSurface, x: &[DVec3], closest_point: &ClosestPoint) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for (face, l) in meeting(surface, closest_point) {
        let (_, d1, d2) = tangents(face, x, l);
        let angle = match l.iter().position(|v| *v > 1.0 - ON_RIM) {
            Some(0) => d1.angle_between(d2),
            Some(1) => (-d1).angle_between(d2 - d1),
            Some(_) => (-d2).angle_between(d1 - d2),
            None => 1.0,
        };
        sum += face_frame(face, x, l).1 * angle;
    }
    sum.normalize_or(closest_point.normal)
}

/// Faces that meet at a closest point on the rim of its face, each with its own coordinates of that point.
fn meeting<'a>(
    surface: &'a ContactSurface,
    closest_point: &ClosestPoint,
) -> impl Iterator<Item = (&'a SurfaceFace, [f64; 3])> {
    let (corners, l) = (surface.faces[closest_point.face].corners, closest_point.l);
    let own = closest_point.face as u32;
    let faces = match closest_point.part() {
        TrianglePart::Corner(k) => surface.rings.vertex_triangles(corners[k]).to_vec(),
        TrianglePart::Edge(k) => surface.rings.edge_triangles(own, k).map_or(vec![own], |sides| sides.to_vec()),
        TrianglePart::Face => vec![own],
    };
    // Coordinates belong to nodes; here, those of nodes outside the face are zero.
    let of = move |node: u32| corners.iter().position(|n| *n == node).map_or(0.0, |k| l[k].max(0.0));
    faces.into_iter().map(move |i| &surface.faces[i as usize]).map(move |face| (face, face.corners.map(of)))
}
