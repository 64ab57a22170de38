//! Contact of the predicted faces with the object: the travel that closes the gap, and the consistency of displacement
//! field and pose.

use super::predicted_state::PadState;
use crate::features::GraspFeatures;
use crate::linear_response::GraspLoad;
use crate::linear_response::first_contact::GeometricContact;
use crate::linear_response::object_motion::pose_after_motion;
use crate::network::interval::ErrorIndicators;
use geometry::{Pose, Wrench};
use glam::DVec3;
use model::Model;

/// Pressing force of a node, over the largest, below which the node is not used to locate the object.
const SMALLEST_FORCE: f64 = 1e-2;
/// Largest correction of the travel, over the thickness: a field that requires more is not reliable.
const FARTHEST: f64 = 0.3;
/// Difference of gaps, over the thickness, at which the weight of a point around a node falls to 1/e: more than the
/// error of a predicted displacement, less than the gap of a point beside the edge of the object.
const ALIKE: f64 = 0.015;
/// Mismatch and overlap, over the depth, below which values are not distinguished.
const LEAST: f64 = 1e-3;

/// Distance of a point of the deformed face from the object.
#[derive(Clone, Copy)]
struct PointGap {
    /// Signed distance, m.
    distance: f64,
    /// Its derivative with respect to the travel.
    closing: f64,
}

/// Face node near the object.
struct NearNode {
    /// Distance to the object minus the gap that the contact law implies for its force, m; of a pressed node, that of
    /// the closest points around it.
    gap: f64,
    /// Derivative of that distance with respect to the travel.
    closing: f64,
    /// Pressing force, N; zero if negligible.
    force: f64,
    /// Difference between the gap of the node and the smallest gap around it, over the thickness.
    hidden: f64,
}

/// Returns translation (m) and rotation vector of the object in hand axes, as the mean of the predictions of all pads.
fn mean_motion(model: &Model, pads: &[PadState]) -> [DVec3; 2] {
    let mean = |pick: fn(&PadState) -> DVec3| {
        let all = model.fingers.iter().zip(pads).map(|(f, pad)| f.placement.rotation * pick(pad));
        all.sum::<DVec3>() / pads.len() as f64
    };
    [mean(|p| p.translation), mean(|p| p.rotation_vector)]
}

/// Returns the pose of the object in a state of the pads of a grasp with first contact `touch`.
pub fn object_pose(model: &Model, touch: &GeometricContact, pads: &[PadState]) -> Pose {
    let [shift, turn] = mean_motion(model, pads);
    if model.free { pose_after_motion(model, &touch.object, shift, turn) } else { touch.object }
}

/// Answer at a load that the travel is corrected for.
pub(super) struct UncorrectedAnswer<'a> {
    /// States of the pads, on the canonical mesh.
    pub pads: &'a [PadState],
    /// Load.
    pub load: &'a GraspLoad,
    /// Mean displacement of the pads, m.
    pub depth: f64,
    /// Fraction of the contact force that the network moved to other nodes.
    pub moved_force: f64,
    /// Effective contact area over the square of the thickness.
    pub area: f64,
}

/// Returns the travel of each finger at which the force-weighted mean gap of its pressed nodes agrees with the contact
/// law, and the error indicators of this answer.
pub(super) fn corrected_travel(features: &GraspFeatures, answer: &UncorrectedAnswer) -> (Vec<f64>, ErrorIndicators) {
    let UncorrectedAnswer { pads, load, depth, moved_force, area } = *answer;
    let (model, t) = (&*features.model, features.graph.thickness);
    let object = object_pose(model, &features.first_contact, pads);
    let [_, turn] = mean_motion(model, pads);
    let nodes: Vec<Vec<NearNode>> =
        pads.iter().enumerate().map(|(p, pad)| near_nodes(features, p, pad, &object)).collect();
    let sums = nodes.iter().map(|own| {
        let pressed = own.iter().filter(|n| n.force > 0.0);
        pressed.fold((0.0, 0.0), |(lacks, gains), n| (lacks - n.force * n.gap, gains + n.force * n.closing))
    });
    let sums: Vec<(f64, f64)> = sums.collect();
    let far = FARTHEST * t;
    let by = |(lacks, gains): (f64, f64)| if gains < 0.0 { (lacks / gains).clamp(-far, far) } else { 0.0 };
    // Geared fingers have the same travel correction.
    let both = sums.iter().fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
    let by: Vec<f64> = sums.iter().map(|own| by(if model.has_coupled_fingers() { both } else { *own })).collect();
    let (mut force, mut mismatch, mut hidden, mut overlap) = (0.0, 0.0, 0.0, 0.0_f64);
    for (own, by) in nodes.iter().zip(&by) {
        for n in own {
            let gap = n.gap + n.closing * by;
            force += n.force;
            mismatch += n.force * gap.abs();
            hidden += n.force * n.hidden * t;
            overlap = overlap.max(-gap);
        }
    }
    let ratio = |value: f64| value / depth.max(f64::MIN_POSITIVE);
    let [mismatch, hidden] = [mismatch, hidden].map(|sum| ratio(sum / f64::max(force, f64::MIN_POSITIVE)));
    let Wrench { force: carried, torque } = features.equilibrium.load_about_centre(load);
    let carried = carried.length() + torque.length();
    let changed = by.iter().map(|by| by.abs()).sum::<f64>() / by.len().max(1) as f64;
    let signs = [
        1.0,
        (mismatch + LEAST).ln(),
        (ratio(overlap) + LEAST).ln(),
        (depth / t).max(LEAST).ln(),
        turn.length().min(1.0),
        hidden.min(1.0),
        (carried / load.force.max(f64::MIN_POSITIVE)).min(1.0),
        (moved_force + LEAST).ln(),
        (ratio(changed) + LEAST).ln(),
        area.max(LEAST).ln(),
    ];
    (pads.iter().zip(&by).map(|(pad, by)| pad.travel + by).collect(), signs)
}

/// Column of a node's features with the difference between its gap and the smallest gap around it.
const GAP_DIFFERENCE: usize = 26;

/// Queries the object at the face nodes of pad `p` that are pressed or close to it. The force of a node is that of the
/// face around it. Beside the edge of an object the node itself is off the object, and the points between it and its
/// neighbours are in contact.
fn near_nodes(features: &GraspFeatures, p: usize, pad: &PadState, object: &Pose) -> Vec<NearNode> {
    let (model, graph) = (&*features.model, &features.graph);
    let finger = &model.fingers[p];
    let pressing: Vec<f64> = graph.face.iter().map(|node| -pad.contact[*node as usize].z).collect();
    let most = pressing.iter().copied().fold(0.0, f64::max);
    let carried = finger.placement.closing * (features.first_contact.travel[p] + pad.travel);
    let inverse = object.rotation.inverse();
    let columns = features.node.len() / (features.pads * graph.face.len());
    let force = |i: usize| Some(pressing[i]).filter(|force| *force > SMALLEST_FORCE * most);
    let moved = graph.rest.iter().zip(&graph.face).map(|(x, node)| *x + pad.displacement[*node as usize]);
    let places: Vec<DVec3> = moved.map(|x| finger.placement.place(x) + carried).collect();
    let query = |at: DVec3, reach: f64| {
        let closest = model.object.distance.closest(inverse * (at - object.position), reach)?;
        let closing = (object.rotation * closest.normal).dot(finger.placement.closing);
        Some(PointGap { distance: closest.distance, closing })
    };
    let mut around: Vec<Vec<PointGap>> = vec![Vec::new(); graph.face.len()];
    for [a, b] in graph.edges.list.iter().filter(|(a, b)| a < b).map(|(a, b)| [*a as usize, *b as usize]) {
        if force(a).or(force(b)).is_some()
            && let Some(gap) = query(0.5 * (places[a] + places[b]), f64::INFINITY)
        {
            [a, b].into_iter().for_each(|i| around[i].push(gap));
        }
    }
    let of = |i: usize| {
        let force = force(i);
        // A node without pressing force matters only if it penetrates the object.
        let own = query(places[i], if force.is_some() { f64::INFINITY } else { finger.law.offset })?;
        let hidden = f64::from(features.node[(p * graph.face.len() + i) * columns + GAP_DIFFERENCE]);
        let Some(force) = force else {
            return Some(NearNode { gap: own.distance, closing: own.closing, force: 0.0, hidden });
        };
        let wanted = (finger.law.offset - force / graph.area[i] / finger.law.stiffness).max(finger.law.smallest_gap());
        let near = closest_mean(own, &around[i], ALIKE * graph.thickness);
        Some(NearNode { gap: near.distance - wanted, closing: near.closing, force, hidden })
    };
    (0..graph.face.len()).filter_map(of).collect()
}

/// Returns `own`, or the mean of the closest of `own` and `around` if these are closer than `own` by more than `alike`
/// (m). Transition and weights are exponential: the result is continuous when two points exchange order.
fn closest_mean(own: PointGap, around: &[PointGap], alike: f64) -> PointGap {
    let all = || around.iter().chain([&own]);
    let least = all().map(|p| p.distance).fold(f64::INFINITY, f64::min);
    let weight = |p: &PointGap| ((least - p.distance) / alike).exp();
    let whole: f64 = all().map(weight).sum();
    let closer = 1.0 - (-((own.distance - least) / alike).powi(2)).exp();
    let mix = |pick: fn(&PointGap) -> f64| {
        let mean = all().map(|p| weight(p) * pick(p)).sum::<f64>() / whole;
        pick(&own) + closer * (mean - pick(&own))
    };
    PointGap { distance: mix(|p| p.distance), closing: mix(|p| p.closing) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(distance: f64) -> PointGap {
        PointGap { distance, closing: -1.0 }
    }

    /// A node 0.17 thicknesses beside the edge of a flat face, whose neighbours touch it, has their gap (within 1e-3
    /// thicknesses); a node among points that scatter by 1e-3 thicknesses keeps its own (within 1e-4).
    #[test]
    fn a_node_beside_an_edge_has_the_gap_of_the_points_on_the_face() {
        let beside = closest_mean(at(0.17), &[at(0.0), at(1e-4), at(0.08), at(0.3)], ALIKE);
        assert!(beside.distance.abs() < 1e-3, "{}", beside.distance);
        let among = closest_mean(at(2e-3), &[at(1e-3), at(2e-3), at(3e-3)], ALIKE);
        assert!((among.distance - 2e-3).abs() < 1e-4, "{}", among.distance);
        assert_eq!(closest_mean(at(0.1), &[], ALIKE).distance, 0.1);
    }
}
