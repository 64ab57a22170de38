//! Finger travel to first contact, from geometry alone.

use geometry::shape::SignedDistance;
use glam::{DMat3, DVec2, DVec3};
use mech::contact::{ContactSurface, ContactVertex};

/// Result of closing a finger.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Approach {
    /// First contact after this travel, m.
    Contact(f64),
    /// The open pad overlaps the object, with about this penetration, m.
    Overlap(f64),
    /// No contact within the stroke.
    Misses,
}

/// Computes the travel of a rigid pad along `closing` until it is `clearance` from the object.
///
/// The contact points of the pad advance along the closing direction by sphere tracing (Hart 1996: the distance
/// function is 1-Lipschitz, so that no step can cross the surface); rays from the object's contact vertices are
/// intersected with the pad's faces. `x` are the pad node positions at zero travel (hand frame, m), `position` and
/// `rotation` the object's pose, `features` the vertices and points of sharp edges of the object (object frame).
#[allow(clippy::too_many_arguments)]
pub fn approach(
    surface: &ContactSurface,
    x: &[DVec3],
    closing: DVec3,
    object: &dyn SignedDistance,
    features: &[ContactVertex],
    position: DVec3,
    rotation: DMat3,
    stroke: f64,
    clearance: f64,
) -> Approach {
    let (mut first, mut deepest) = (f64::INFINITY, 0.0_f64);
    let inverse = rotation.transpose();
    let direction = inverse * closing;
    let starts = surface.points[..surface.vertices].iter().map(|stencil| inverse * (stencil.position(x) - position));
    let mut points: Vec<(DVec3, f64)> = starts.map(|start| (start, object.distance(start))).collect();
    // The nearest points first: their travel bounds the search of the others.
    points.sort_by(|a, b| a.1.total_cmp(&b.1));
    for (start, distance) in points {
        deepest = deepest.max(-distance);
        let (mut t, mut d) = (0.0, distance);
        // Grazing rays converge slowly; after the last iteration the point is close enough to count as touching.
        for step in 0..200 {
            if d <= clearance * 1.001 || step == 199 {
                first = first.min(t);
                break;
            }
            t += d - clearance;
            if t >= first.min(stroke) {
                break;
            }
            d = object.distance(start + direction * t);
        }
    }
    // Only vertices within the pad's bounding rectangle in projection along the closing direction can touch the pad.
    let (u, v) = closing.any_orthonormal_pair();
    let seen = |p: DVec3| DVec2::new(u.dot(p), v.dot(p));
    let outline = surface.faces.iter().flat_map(|face| face.corners).map(|n| seen(x[n as usize]));
    let (low, high) = outline.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
    let (low, high) = (low - clearance, high + clearance);
    let corners = surface.faces.iter().flat_map(|face| face.corners).map(|n| x[n as usize].dot(closing));
    let foremost = corners.fold(f64::NEG_INFINITY, f64::max);
    for feature in features {
        let point = rotation * feature.position + position;
        // Lower bound of the travel: the foremost corner of the pad reaches the point.
        if point.dot(closing) - foremost - clearance >= first {
            continue;
        }
        let before = seen(point);
        if before.cmplt(low).any() || before.cmpgt(high).any() {
            continue;
        }
        for face in surface.faces.iter() {
            let [a, b, c] = face.corners.map(|n| x[n as usize]);
            // The pad moves by t along `closing`: the face reaches the point where the ray from the point along
            // `-closing` intersects the face.
            if let Some(t) = cast(point, -closing, a, b, c) {
                if t < clearance && t > -1e-3 {
                    let inside = (b - a).cross(c - a).normalize_or_zero().dot(point - a);
                    deepest = deepest.max(-inside);
                }
                if t >= clearance {
                    first = first.min(t - clearance);
                }
            }
        }
    }
    if deepest > 0.0 {
        Approach::Overlap(deepest)
    } else if first < stroke {
        Approach::Contact(first)
    } else {
        Approach::Misses
    }
}

/// Returns the signed parameter t of the intersection of the line `origin + t direction` with the front side of a
/// triangle (Moeller & Trumbore 1997).
fn cast(origin: DVec3, direction: DVec3, a: DVec3, b: DVec3, c: DVec3) -> Option<f64> {
    let (e1, e2) = (b - a, c - a);
    let p = direction.cross(e2);
    let det = e1.dot(p);
    // Only faces whose outward normal is opposite to the direction are hit from outside.
    if direction.dot(e1.cross(e2)) >= -1e-9 * e1.length() * e2.length() {
        return None;
    }
    let s = origin - a;
    let u = s.dot(p) / det;
    let q = s.cross(e1);
    let v = direction.dot(q) / det;
    let edge = -1e-12;
    (u >= edge && v >= edge && u + v <= 1.0 - edge).then(|| e2.dot(q) / det)
}
