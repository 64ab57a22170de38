//! Deepest point of an edge of the object in a pad. It mostly lies where an edge between faces of the pad crosses it. Points at
//! fixed places of both edges miss it by the more the steeper the two are.

use super::project::FaceBounds;
use super::surface::ContactSurface;
use crate::geometry::shape::Stretch;
use crate::mech::potential::state::BodyView;
use crate::scales::{DEEPEST, DEEPEST_LENGTH};
use glam::DVec3;

/// The point of a stretch that is deepest in the pad, object axes, m; None if none is deeper than `least` (m).
pub(crate) fn deepest(
    bounds: &FaceBounds,
    surface: &ContactSurface,
    view: &BodyView,
    stretch: &Stretch,
    least: f64,
) -> Option<DVec3> {
    // The distance changes no faster than the point moves, along an arc a little more than along its chord: parts that cannot go
    // deeper than what is found are skipped.
    let [reach, deep, fine] = [bounds.at_once(), DEEPEST * bounds.offset, DEEPEST_LENGTH * bounds.offset];
    let length = ARC * stretch.length();
    let mut best = (-least, None);
    let mut parts = vec![(0.0, 1.0)];
    while let Some((from, to)) = parts.pop() {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from) * length);
        let halves = [(middle, to), (from, middle)];
        if half > reach {
            parts.extend(halves);
            continue;
        }
        let point = stretch.point(middle);
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

/// Length of the flattest arc of a rim, over its chord, at most.
const ARC: f64 = 1.05;
