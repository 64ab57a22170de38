//! Rejection of pads that meet next to a thin object: contact between the pads is not modelled.

use crate::components::{ClosingDirection, FingerIndex, FingerTravel, Position, TABLES, rows_by_pad};
use crate::schedule::{NextPhase, Phase, SharedModel, StepLoad, StepReport};
use base::scales::FACE_BULGE;
use bevy_ecs::prelude::*;
use glam::{DVec2, DVec3};
use mech::contact::{ContactSurface, SurfaceFace};

/// Ends the grasp with a fault, without recording the frame, if the pads overlap in the state just reached.
pub fn reject_pad_overlap(
    shared: Res<SharedModel>,
    load: Res<StepLoad>,
    mut report: ResMut<StepReport>,
    mut next: ResMut<NextPhase>,
    nodes: Query<(&FingerIndex, &Position)>,
    fingers: Query<(&FingerIndex, &FingerTravel, &ClosingDirection)>,
) {
    let [first, second] = shared.0.fingers.as_slice() else { return };
    let mut carried = [DVec3::ZERO; 2];
    for (finger, travel, closing) in &fingers {
        carried[finger.0 as usize] = closing.0 * travel.0;
    }
    let axis = first.placement.closing;
    // Quick test: end of the first pad and start of the second along the axis; usually they do not overlap there.
    let (mut tip, mut lowest) = (f64::NEG_INFINITY, f64::INFINITY);
    for (finger, position) in nodes.contiguous_iter().expect(TABLES) {
        for (finger, position) in finger.iter().zip(position) {
            let height = (position.0 + carried[finger.0 as usize]).dot(axis);
            if finger.0 == 0 { tip = tip.max(height) } else { lowest = lowest.min(height) }
        }
    }
    let offset = shared.0.offset;
    if tip + FACE_BULGE * offset <= lowest {
        return;
    }
    let mut x = [const { Vec::new() }; 2];
    for (finger, position) in nodes.contiguous_iter().expect(TABLES) {
        rows_by_pad(finger).for_each(|(f, rows)| x[f] = position[rows].iter().map(|x| x.0 + carried[f]).collect());
    }
    let depth = overlap_depth(&first.surface, &x[0], &second.surface, &x[1], axis);
    // Smaller overlaps are below the resolution of contact.
    if depth > offset {
        report.reached = false;
        next.request(Phase::Fault {
            reason: format!(
                "the pads touch each other next to the object and would overlap by {:.3} mm at load {:.4e}: contact \
                 between the pads is not modelled; use less force, smaller pads or a thicker object",
                depth * 1e3,
                load.level
            ),
        });
    }
}

/// Returns the largest depth, m, by which two surfaces overlap that face each other along the unit vector `axis` (from
/// the first to the second), over the points of the second; zero if they are apart. `x`, `y`: node positions, m.
pub fn overlap_depth(first: &ContactSurface, x: &[DVec3], second: &ContactSurface, y: &[DVec3], axis: DVec3) -> f64 {
    let nodes = first.faces.iter().flat_map(|f| f.corners.into_iter().chain(f.mids.into_iter().flatten()));
    let tip = nodes.map(|n| x[n as usize].dot(axis)).fold(f64::NEG_INFINITY, f64::max);
    let u = axis.any_orthonormal_vector();
    let v = axis.cross(u);
    let plane = |p: DVec3| (DVec2::new(p.dot(u), p.dot(v)), p.dot(axis));
    let behind: Vec<_> = second.points.iter().map(|s| plane(s.position(y))).filter(|(_, h)| *h < tip).collect();
    let lowest = behind.iter().map(|(_, h)| *h).fold(f64::INFINITY, f64::min);
    let mut worst = 0.0_f64;
    for triangle in first.faces.iter().flat_map(SurfaceFace::flat_parts) {
        let [a, b, c] = triangle.map(|n| plane(x[n as usize]));
        // Front faces are counter-clockwise as seen from the other pad.
        let area = (b.0 - a.0).perp_dot(c.0 - a.0);
        if a.1.max(b.1).max(c.1) <= lowest || area <= 0.0 {
            continue;
        }
        for (q, h) in &behind {
            let weight = |from: DVec2, to: DVec2| (to - from).perp_dot(*q - from) / area;
            let (wa, wb, wc) = (weight(b.0, c.0), weight(c.0, a.0), weight(a.0, b.0));
            if wa >= 0.0 && wb >= 0.0 && wc >= 0.0 {
                worst = worst.max(wa * a.1 + wb * b.1 + wc * c.1 - h);
            }
        }
    }
    worst
}
