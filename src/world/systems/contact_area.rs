//! Area of each pad that touches the object.

use crate::mech::potential::term::Stencil;
use crate::part::FingerModel;
use crate::world::components::*;
use crate::world::schedule::Shared;
use bevy_ecs::prelude::*;
use glam::DVec3;

/// Part of the largest force of a node from which the area of another counts, where forces are known at nodes alone: a node at the rim
/// of the contact feels what presses beside it.
const WITHIN: f64 = 0.2;

/// Returns which nodes of a pad that closes along `closing` are pressed with more than `part` of the largest force.
pub(super) fn pressed(force: &[ContactForce], closing: DVec3, part: f64) -> Vec<bool> {
    let pressing = |force: &ContactForce| -force.0.dot(closing);
    let most = force.iter().map(pressing).fold(0.0, f64::max);
    force.iter().map(|force| pressing(force) > part * most).collect()
}

/// Returns the area of a pad that touches, m2, where forces are known at nodes alone.
pub fn by_nodes(finger: &FingerModel, force: &[ContactForce]) -> f64 {
    let pressed = pressed(force, finger.placement.closing, WITHIN);
    let part = |around: &Stencil| {
        let (nodes, weights) = around.slices();
        let own = nodes.iter().zip(weights).filter(|(node, _)| pressed[**node as usize]);
        own.map(|(_, weight)| weight).sum::<f64>()
    };
    let surface = &finger.surface;
    let points = surface.area[..surface.vertices].iter().zip(surface.report.iter());
    points.map(|(area, around)| area * part(around)).sum()
}

/// Measures the area of each pad that touches: that of the points of contact that press. Where forces are known at nodes alone, a point
/// counts for the pressed ones of the nodes around it.
pub fn measure_contact_area(
    shared: Res<Shared>,
    edges: Query<(&FingerIndex, &ContactEdge)>,
    nodes: Query<(&FingerIndex, &ContactForce)>,
    mut fingers: Query<(&FingerIndex, &mut ContactArea)>,
) {
    let model = &shared.0;
    let mut area = vec![0.0; model.fingers.len()];
    for (finger, edges) in edges.contiguous_iter().expect(TABLES) {
        for (f, rows) in rows_by_pad(finger) {
            let surface = &model.fingers[f].surface;
            let points = surface.area[..surface.vertices].iter().zip(&edges[rows]);
            area[f] = points.filter(|(_, edge)| edge.pressure > 0.0).map(|(area, _)| area).sum();
        }
    }
    if edges.is_empty() {
        for (finger, force) in nodes.contiguous_iter().expect(TABLES) {
            for (f, rows) in rows_by_pad(finger) {
                area[f] = by_nodes(&model.fingers[f], &force[rows]);
            }
        }
    }
    for (finger, mut own) in &mut fingers {
        own.0 = area[finger.0 as usize];
    }
}
