//! Broad phase for the contact vertices of the object: which are too far from a pad for an exact query, and on which
//! side of the pad surface the others lie. Both follow from bounds on the motion of vertices and pad.

use super::closest_point::ClosestPoint;
use super::face_bounds::FaceBounds;
use super::incident_faces::IncidentFace;
use super::nearby::{NearbyList, QUADRATIC_MOTION_RATIO, largest_node_motion};
use super::surface::ContactSurface;
use crate::potential::state::BodyView;
use base::scales::{DISTANCE_UPDATE_MOTION, FACE_HYSTERESIS, VERTEX_LIST_RADIUS};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Bounds of the signed distances of all contact vertices to the pad.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct CandidateList {
    /// Contact offset, m.
    offset: f64,
    /// Bounds from the last query of all vertices.
    full_query: Arc<VertexBounds>,
    /// Bounds from the last assembly, for the vertices that were near.
    last: Arc<VertexBounds>,
    nearby: Arc<NearbyList>,
}

/// Distances of all contact vertices to the pad at an earlier state.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct VertexBounds {
    /// Node positions at that state, m.
    x: Vec<DVec3>,
    vertices: Vec<GapBounds>,
}

/// Position of a contact vertex relative to the finger, and bounds of its signed distance to the pad there (positive
/// outside), m.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(crate) struct GapBounds {
    pub at: DVec3,
    least: f64,
    most: f64,
}

/// Largest motion of a node of the pad since the last query of all vertices, and since the last assembly, m; `+inf`
/// before the first.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PadMotion {
    full_query: f64,
    last: f64,
}

impl VertexBounds {
    fn moved(&self, x: &[DVec3]) -> f64 {
        largest_node_motion(&self.x, x)
    }

    /// Bounds of the signed distance of vertex `i`, now at `y`, to the pad, whose nodes have moved by up to `moved`
    /// (m).
    fn bounds(&self, i: usize, y: DVec3, moved: f64) -> GapBounds {
        match self.vertices.get(i) {
            Some(then) => {
                let change = QUADRATIC_MOTION_RATIO * moved + then.at.distance(y);
                GapBounds { at: y, least: then.least - change, most: then.most + change }
            }
            None => GapBounds { at: y, ..GapBounds::UNKNOWN },
        }
    }
}

impl GapBounds {
    /// Bounds of a vertex that was never queried.
    pub const UNKNOWN: Self = Self { at: DVec3::ZERO, least: f64::NEG_INFINITY, most: f64::INFINITY };

    /// Returns true if the vertex may be nearer than `reach` (m) to the pad.
    pub fn within(&self, reach: f64) -> bool {
        self.least <= reach
    }

    /// Narrows the bounds by the `incident` faces, which are those within `reach` (m).
    pub fn narrowed(self, incident: &[IncidentFace], reach: f64) -> Self {
        match incident.first() {
            Some((closest_point, ..)) => Self { least: closest_point.gap, most: closest_point.gap, ..self },
            None => Self { least: self.least.max(reach), most: f64::INFINITY, ..self },
        }
    }

    /// Returns `closest_point` with the sign of the gap that the bounds allow. Where a face is folded over or a fold is
    /// closed, the surface intersects itself and may give the wrong side. Contact has this `offset` (m).
    pub fn with_valid_sign(&self, closest_point: ClosestPoint, offset: f64) -> ClosestPoint {
        let slack = FACE_HYSTERESIS * offset;
        let possible = |gap: f64| self.least - slack <= gap && gap <= self.most + slack;
        if possible(closest_point.gap) || !possible(-closest_point.gap) {
            closest_point
        } else {
            closest_point.flipped()
        }
    }
}

impl CandidateList {
    /// Creates a list without any bounds; contact has this `offset` (m).
    pub fn new(offset: f64) -> Self {
        Self { offset, full_query: Arc::default(), last: Arc::default(), nearby: Arc::default() }
    }

    /// Recomputes the distances of `count` contact vertices if the pad at `x` has moved too far since the last time;
    /// `place` returns the position of each vertex.
    pub fn update(
        &mut self,
        surface: &ContactSurface,
        x: &[DVec3],
        bounds: &FaceBounds,
        count: usize,
        place: impl Fn(usize) -> DVec3,
    ) {
        let moved = self.moved(x);
        if moved.full_query > DISTANCE_UPDATE_MOTION * self.offset {
            let away = |i: usize| {
                let y = place(i);
                let near = self.bounds(i, y, moved);
                let least =
                    bounds.outside(surface, x, y, |closest_point| near.with_valid_sign(closest_point, self.offset));
                GapBounds { at: y, least, most: f64::INFINITY }
            };
            let vertices = (0..count).map(away).collect();
            self.full_query = Arc::new(VertexBounds { vertices, x: x.to_vec() });
        }
    }

    /// Stores the bounds of each vertex found in an assembly at node positions `x`.
    pub fn store_assembly(&mut self, x: &[DVec3], vertices: Vec<GapBounds>) {
        self.last = Arc::new(VertexBounds { x: x.to_vec(), vertices });
    }

    /// Lists the vertices that are near according to the last assembly, and those that `matter` at any distance. The
    /// object reaches as far as `radius` (m) from its origin.
    pub fn list(&mut self, view: &BodyView, radius: f64, matter: impl Fn(usize) -> bool) {
        let all = self.last.vertices.iter().enumerate();
        let vertices = all
            .filter(|(i, bounds)| bounds.within(VERTEX_LIST_RADIUS * self.offset) || matter(*i))
            .map(|(i, _)| i)
            .collect();
        self.nearby = Arc::new(NearbyList::new(vertices, view, radius));
    }

    /// Adds vertex `i`, whose position has changed, to the list, at `distance` (m) from the origin of the object.
    pub fn add(&mut self, i: usize, distance: f64) {
        let listed = Arc::make_mut(&mut self.nearby);
        if let Err(k) = listed.list.binary_search(&i) {
            listed.list.insert(k, i);
        }
        listed.radius = listed.radius.max(distance);
    }

    /// Returns the listed vertices, ascending, if under `view` no other one can be nearer than `reach` (m).
    pub fn nearby(&self, view: &BodyView, reach: f64) -> Option<&[usize]> {
        let moved = self.nearby.moved(view);
        (moved + reach <= VERTEX_LIST_RADIUS * self.offset).then_some(&self.nearby.list)
    }

    /// Largest motions of the nodes of the pad, which are at `x` now.
    pub fn moved(&self, x: &[DVec3]) -> PadMotion {
        PadMotion { full_query: self.full_query.moved(x), last: self.last.moved(x) }
    }

    /// Bounds of the signed distance of vertex `i`, now at `y`.
    pub fn bounds(&self, i: usize, y: DVec3, moved: PadMotion) -> GapBounds {
        let (full_query, last) = (self.full_query.bounds(i, y, moved.full_query), self.last.bounds(i, y, moved.last));
        GapBounds { at: y, least: full_query.least.max(last.least), most: full_query.most.min(last.most) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A vertex 10 um outside that moved by 1 um while the pad did not move is 9 to 11 um outside.
    #[test]
    fn a_feature_stays_on_the_side_where_it_can_be() {
        let then = GapBounds { at: DVec3::ZERO, least: 1e-5, most: 1e-5 };
        let seen = VertexBounds { x: vec![DVec3::ZERO], vertices: vec![then] };
        let now = seen.bounds(0, DVec3::X * 1e-6, 0.0);
        let gap = |gap: f64| now.with_valid_sign(ClosestPoint::at(0, [1.0, 0.0, 0.0], gap, DVec3::Z), 1e-5).gap;
        assert_eq!([gap(9.5e-6), gap(-9.5e-6)], [9.5e-6; 2], "m");
        // Neither side is possible: the sign of the surface is kept.
        assert_eq!(gap(-5e-5), -5e-5, "m");
    }
}
