//! Faces that a contact vertex of the object presses on: the nearest face of the pad and, in a fold, its other incident
//! faces.
//!
//! An edge of the object folds the pad and reaches equilibrium in the fold, where it touches both incident faces. The
//! smaller of their distances has a kink there, across which Newton's method would oscillate; the sum over both has
//! none (see [`TriangleAdjacency::additional_parts`](geometry::mesh::adjacency::TriangleAdjacency::additional_parts)).

use super::closest_point::{ClosestPoint, on_edge, on_extended_face, on_face};
use super::face_bounds::FaceBounds;
use super::surface::{ContactSurface, ON_RIM};
use base::scales::FACE_HYSTERESIS;
use geometry::mesh::adjacency::{SurfacePart, TrianglePart, TrianglePosition};
use geometry::shape::outer;
use glam::{DMat3, DVec3};

/// Closest point, its weight in the sum over all of them, and the derivative of the direction to it in the position of
/// the vertex, 1/m.
pub(crate) type IncidentFace = (ClosestPoint, f64, DMat3);

impl ClosestPoint {
    /// Part of the face on which the point lies.
    pub(crate) fn part(&self) -> TrianglePart {
        let on = |k: usize| self.l[k] <= ON_RIM;
        match [on(0), on(1), on(2)] {
            [false, false, false] => TrianglePart::Face,
            // Edge `k + 1` is opposite to corner `k`.
            [true, false, false] => TrianglePart::Edge(1),
            [false, true, false] => TrianglePart::Edge(2),
            [false, false, true] => TrianglePart::Edge(0),
            [_, true, true] => TrianglePart::Corner(0),
            [true, _, true] => TrianglePart::Corner(1),
            [true, true, _] => TrianglePart::Corner(2),
        }
    }
}

/// Cosine of the angle between faces above which a fold is shallow (15 degrees).
const SHALLOW_FOLD_COSINE: f64 = 0.966;
/// The same if one face was used last (18 degrees), and if the whole fold was (12 degrees): the choice does not
/// oscillate.
const SINGLE_FACE_COSINE: f64 = 0.951;
const ALL_FACES_COSINE: f64 = 0.978;
/// The same while the choice of one face is kept (30 degrees).
const KEPT_FACE_COSINE: f64 = 0.866;
/// Contact of a vertex at the last assembly.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LastContact {
    /// Nearest face.
    pub face: usize,
    /// Flag: the face was extended beyond its rim.
    pub extended: bool,
    /// Flag: other faces were used in addition to it.
    pub folded: bool,
    /// Flag: the choice of faces is kept, so that the energy along a line has no jumps; else it is made again, with
    /// hysteresis.
    pub keeps_faces: bool,
}

impl LastContact {
    /// Cosine of the angle between faces above which a fold is shallow.
    fn shallow_fold_cosine(self) -> f64 {
        match (self.keeps_faces, self.folded) {
            (false, false) => SINGLE_FACE_COSINE,
            (false, true) => ALL_FACES_COSINE,
            (true, false) => KEPT_FACE_COSINE,
            (true, true) => f64::INFINITY,
        }
    }

    /// Difference of distances up to which the face is kept at a shallow fold, m, for contact with this `offset` (m).
    fn face_hysteresis(self, offset: f64) -> f64 {
        match (self.keeps_faces, self.extended) {
            (false, _) => FACE_HYSTERESIS * offset,
            (true, true) => f64::INFINITY,
            (true, false) => 0.0,
        }
    }
}

impl FaceBounds {
    /// Finds the closest points of a contact vertex at `y` (relative to the finger, m), the nearest first; none if it
    /// is farther than `reach` (m) from the surface.
    ///
    /// At a shallow fold, as between faces of a smoothly curved pad, the normals differ little, but they change within
    /// a fraction of the reach. A single face is used there, and that of `last` is kept as long as it is nearly as
    /// near. `side` decides on which side of the surface the vertex is.
    pub(crate) fn incident(
        &self,
        surface: &ContactSurface,
        x: &[DVec3],
        y: DVec3,
        reach: f64,
        last: Option<LastContact>,
        side: impl Fn(ClosestPoint) -> ClosestPoint,
    ) -> Vec<IncidentFace> {
        let Some(nearest) = self.closest_as(surface, x, y, reach, side) else { return Vec::new() };
        if inside(surface, x, &nearest, 2.0 * reach) && last.is_none_or(|last| last.face == nearest.face) {
            return vec![(nearest, 1.0, DMat3::ZERO)];
        }
        let others = self.beside(surface, x, y, reach, &nearest);
        let least = last.map_or(SHALLOW_FOLD_COSINE, LastContact::shallow_fold_cosine);
        let shallow = |closest_point: &ClosestPoint| closest_point.normal.dot(nearest.normal) > least;
        if others.iter().all(|(closest_point, ..)| shallow(closest_point)) {
            let kept = last.and_then(|last| {
                let closest_point = on_extended_face(last.face, &surface.faces[last.face], x, y)?;
                (shallow(&closest_point) && (closest_point.gap - nearest.gap).abs() < last.face_hysteresis(self.offset))
                    .then_some(closest_point)
            });
            return vec![(kept.unwrap_or(nearest), 1.0, DMat3::ZERO)];
        }
        let mut incident = vec![(nearest, 1.0, DMat3::ZERO)];
        incident.extend(others);
        incident
    }

    /// Closest points within `reach` except the nearest.
    fn beside(
        &self,
        surface: &ContactSurface,
        x: &[DVec3],
        y: DVec3,
        reach: f64,
        nearest: &ClosestPoint,
    ) -> Vec<IncidentFace> {
        let view = |t: u32| {
            let (i, face) = (t as usize, &surface.faces[t as usize]);
            if self.distance_bound(i, face, x, y, reach) >= reach {
                return TrianglePosition::Beyond;
            }
            match on_face(i, face, x, y) {
                closest_point if closest_point.gap.abs() >= reach => TrianglePosition::Beyond,
                closest_point if closest_point.part() == TrianglePart::Face && closest_point.gap < 0.0 => {
                    TrianglePosition::Behind
                }
                closest_point => TrianglePosition::At(closest_point.part()),
            }
        };
        let along = |t: u32, i: usize| {
            let l = on_edge(&surface.faces[t as usize], x, (i + 2) % 3, y);
            if l[i] <= ON_RIM {
                TrianglePart::Corner((i + 1) % 3)
            } else if l[(i + 1) % 3] <= ON_RIM {
                TrianglePart::Corner(i)
            } else {
                TrianglePart::Edge(i)
            }
        };
        let others = surface.rings.additional_parts(nearest.face as u32, nearest.part(), view, along).into_iter();
        others
            .filter_map(|(place, weight)| {
                outside(surface, x, y, place).map(|(closest_point, curvature)| (closest_point, weight, curvature))
            })
            .collect()
    }
}

/// Returns true if a closest point lies farther than `margin` (m) from the rim of its face.
fn inside(surface: &ContactSurface, x: &[DVec3], closest_point: &ClosestPoint, margin: f64) -> bool {
    let [a, b, c] = surface.faces[closest_point.face].corners.map(|n| x[n as usize]);
    let twice = (b - a).cross(c - a).length();
    let edges = [(c - b).length(), (a - c).length(), (b - a).length()];
    (0..3).all(|k| closest_point.l[k] * twice > margin * edges[k])
}

/// Closest point of `y`, which is outside, on a part of the surface, and the derivative of the direction to it.
fn outside(surface: &ContactSurface, x: &[DVec3], y: DVec3, place: SurfacePart) -> Option<(ClosestPoint, DMat3)> {
    let (face, l, along) = match place {
        SurfacePart::Face(i) => return Some((on_face(i as usize, &surface.faces[i as usize], x, y), DMat3::ZERO)),
        SurfacePart::Edge(e) => {
            let (t, i) = surface.rings.triangle_of_edge(e);
            let face = &surface.faces[t as usize];
            let [a, b] = [i, (i + 1) % 3].map(|k| x[face.corners[k] as usize]);
            (t, on_edge(face, x, (i + 2) % 3, y), (b - a).normalize_or_zero())
        }
        SurfacePart::Corner(v) => {
            let (t, i) = surface.rings.triangle_of_vertex(v)?;
            (t, std::array::from_fn(|k| f64::from(u8::from(k == i))), DVec3::ZERO)
        }
    };
    let away = y - surface.faces[face as usize].stencil(l).position(x);
    let normal = away.try_normalize()?;
    let across = DMat3::IDENTITY - outer(along) - outer(normal);
    Some((ClosestPoint::at(face as usize, l, away.length(), normal), across * away.length().recip()))
}
