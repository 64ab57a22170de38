//! Deepest point of an edge of the object in a pad. It usually lies where an edge between faces of the pad crosses it.
//! Fixed samples of both edges miss it by a depth that grows with the angles of the two edges.

use super::face_bounds::FaceBounds;
use super::surface::ContactSurface;
use crate::potential::state::BodyView;
use base::scales::{DEEPEST_POINT_TOLERANCE, LARGEST_PENETRATION};
use geometry::shape::EdgeSection;
use glam::DVec3;

/// The point of an edge segment that is deepest in the pad, object frame, m; None if none is deeper than `least` (m).
pub(crate) fn deepest(
    bounds: &FaceBounds,
    surface: &ContactSurface,
    view: &BodyView,
    segment: &EdgeSection,
    least: f64,
) -> Option<DVec3> {
    // Branch and bound: the distance changes no faster than the point moves, so that parts which cannot contain a
    // deeper point are skipped. Lengths are those of the arc, which is slightly longer than its chord.
    let [reach, deep, fine] =
        [bounds.cell_radius(), LARGEST_PENETRATION * bounds.offset, DEEPEST_POINT_TOLERANCE * bounds.offset];
    let length = ARC_LENGTH_RATIO * segment.length();
    let mut best = (-least, None);
    let mut parts = vec![(0.0, 1.0)];
    while let Some((from, to)) = parts.pop() {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from) * length);
        let halves = [(middle, to), (from, middle)];
        if half > reach {
            parts.extend(halves);
            continue;
        }
        let point = segment.point(middle);
        let y = view.object.position + view.object.rotation * point - view.offset;
        let Some(closest_point) = bounds.near(surface, view.x, y, (half + deep).min(reach)) else { continue };
        if closest_point.gap < best.0 {
            best = (closest_point.gap, Some(point));
        }
        if half > fine && closest_point.gap - half < best.0 {
            parts.extend(halves);
        }
    }
    best.1
}

/// Largest ratio of arc length to chord for a segment of a rim.
const ARC_LENGTH_RATIO: f64 = 1.05;
