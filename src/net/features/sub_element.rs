//! Gap between pad and object at points between the nodes of the sensing face, where first contact may occur.

use super::MAX_GAP;
use super::object_query::ObjectQuery;
use crate::linear_response::contact_point::ContactPoint;
use crate::linear_response::pad_graph::PadGraph;
use geometry::face_lookup::FaceLookup;
use glam::{DVec2, DVec3, Vec3Swizzles};

/// Smallest gap between the sensing face around a node and the object. Lengths are dimensionless: relative to the
/// thickness of the pad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SmallestGap {
    /// Smallest gap along the closing direction, among the samples around the node and the node itself.
    pub gap: f64,
    /// Position of the sample with this gap relative to the node, along x and y of the pad frame; a weighted mean if
    /// several samples have almost this gap.
    pub offset: DVec2,
}

/// Gap over the thickness up to which points between nodes are sampled.
const NEAR: f64 = 0.6;

/// Difference of gaps, over the thickness, at which the weight of a point falls to 1/e.
const ALIKE: f64 = 0.01;

/// Returns the smallest gap around each node of the sensing face, in the order of `graph.face`. `view` is the object as
/// seen from one pad at first contact; `gaps` are the gaps of the face nodes themselves, over the thickness; `lookup` locates points in the face. Samples
/// are the midpoints of face edges, the centroids of face triangles, and the contact points of the object (vertices and
/// points of sharp edges).
pub(super) fn smallest_gaps(
    view: &ObjectQuery,
    graph: &PadGraph,
    lookup: &FaceLookup,
    gaps: &[f64],
) -> Vec<SmallestGap> {
    let t = graph.thickness;
    // Samples around each node, including itself: their gaps and offsets.
    let mut seen: Vec<Vec<SmallestGap>> =
        gaps.iter().map(|gap| vec![SmallestGap { gap: *gap, offset: DVec2::ZERO }]).collect();
    let mut enter = |nodes: &[u32], at: DVec3, gap: f64| {
        for i in nodes {
            seen[*i as usize].push(SmallestGap { gap, offset: (at - graph.rest[*i as usize]).xy() / t });
        }
    };
    let mut between = |nodes: &[u32]| {
        let least = nodes.iter().map(|i| gaps[*i as usize]).fold(f64::INFINITY, f64::min);
        if least < NEAR {
            let at = nodes.iter().map(|i| graph.rest[*i as usize]).sum::<DVec3>() / nodes.len() as f64;
            let gap = view.gap(view.pad_to_object(at), least * t) / t;
            enter(nodes, at, gap);
        }
    };
    graph.edges.list.iter().filter(|(a, b)| a < b).for_each(|(a, b)| between(&[*a, *b]));
    graph.triangles.iter().for_each(|t| between(t));
    let highest = graph.rest.iter().map(|x| x.z).fold(f64::NEG_INFINITY, f64::max);
    for feature in view.model.features.iter() {
        let at = view.object_to_pad(feature.position);
        if at.z > highest + NEAR * t || !graph.bounds_contain(at.xy()) {
            continue;
        }
        let corners = lookup.interpolation_at(at);
        let below: DVec3 = corners.iter().map(|(i, w)| graph.rest[*i as usize] * *w).sum();
        // Points outside the face have no face point below them.
        if below.xy().distance(at.xy()) < 1e-6 * t {
            enter(&corners.map(|(i, _)| i), below, (at.z - below.z) / t);
        }
    }
    seen.into_iter().map(|points| least(&points)).collect()
}

/// Differences between the gap of a node and the smallest gap around it, over the thickness, from and up to which its
/// contact point moves: more than a curved object has between neighbouring nodes, less than beside an edge, where the
/// closing direction passes the object.
const EDGE: [f64; 2] = [0.1, 0.3];
/// Number of bisections that locate an edge between a node and a point in contact, about half a thickness apart.
const BISECTIONS: usize = 6;
/// Distance of a contact point from the edge, over the thickness: above the error of a grazing ray, so that the object
/// touches the point with its face.
const INSIDE: f64 = 0.02;

/// Returns the contact points of the face nodes: the nodes, or, where a node lies beside the edge of the object, the
/// point at this edge. `view` is the object as seen from one pad at first contact; `gaps` are those of the nodes,
/// `nearest` the smallest ones around them.
pub(super) fn contact_points(
    view: &ObjectQuery,
    graph: &PadGraph,
    lookup: &FaceLookup,
    gaps: &[f64],
    nearest: &[SmallestGap],
) -> Vec<ContactPoint> {
    let t = graph.thickness;
    let point = |(i, (x, (gap, nearest))): (usize, (&DVec3, (&f64, &SmallestGap)))| {
        let beside = ((gap - nearest.gap - EDGE[0]) / (EDGE[1] - EDGE[0])).clamp(0.0, 1.0);
        let beside = beside * beside * (3.0 - 2.0 * beside);
        if beside == 0.0 || nearest.gap > NEAR {
            // Out of sight, it is beside the object, too.
            let covered = if *gap < MAX_GAP { 1.0 } else { 0.0 };
            return ContactPoint::at_node(i as u32, *x, covered);
        }
        let at = |part: f64| {
            let corners = lookup.interpolation_at(*x + (nearest.offset * part * t).extend(0.0));
            let position: DVec3 = corners.iter().map(|(i, w)| graph.rest[*i as usize] * *w).sum();
            let covered = 1.0 - beside * (0.5 + position.distance(*x) / graph.area[i].sqrt()).min(1.0);
            ContactPoint { position, corners, covered }
        };
        let far = (nearest.gap.max(0.0) + EDGE[0]) * t;
        let touches = |part: f64| view.gap(view.pad_to_object(at(part).position), far) < far;
        let (mut off, mut on) = (0.0, 1.0);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (off + on);
            *(if touches(middle) { &mut on } else { &mut off }) = middle;
        }
        at(beside * (on + INSIDE / nearest.offset.length().max(INSIDE)))
    };
    graph.rest.iter().zip(gaps.iter().zip(nearest)).enumerate().map(point).collect()
}

/// Returns the smallest gap, and the mean offset of the points with almost this gap, weighted so that the offset is
/// continuous when two points exchange order.
fn least(points: &[SmallestGap]) -> SmallestGap {
    let gap = points.iter().map(|p| p.gap).fold(f64::INFINITY, f64::min);
    let weighted = points.iter().map(|p| (p.offset, (-(p.gap - gap) / ALIKE).exp()));
    let (sum, whole) = weighted.fold((DVec2::ZERO, 0.0), |(sum, whole), (offset, w)| (sum + offset * w, whole + w));
    SmallestGap { gap, offset: sum / whole }
}
