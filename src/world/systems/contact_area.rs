//! Contact area of each pad.

use crate::components::*;
use crate::schedule::SharedModel;
use bevy_ecs::prelude::*;
use glam::DVec3;
use mech::potential::term::Stencil;
use model::part::FingerModel;

/// Fraction of the largest nodal force above which the area of a node counts, if only nodal forces are known: a node at
/// the rim of the contact also carries pressure next to it.
const WITHIN: f64 = 0.2;

/// Returns, for each node of a pad that closes along `closing`, whether its pressing force exceeds `part` of the
/// largest.
pub(super) fn pressed_nodes(force: &[ContactForce], closing: DVec3, part: f64) -> Vec<bool> {
    let pressing = |force: &ContactForce| -force.0.dot(closing);
    let most = force.iter().map(pressing).fold(0.0, f64::max);
    force.iter().map(|force| pressing(force) > part * most).collect()
}

/// Returns an estimate of the contact area of the pad of `finger`, m2, from the contact forces `force` on its nodes (N,
/// hand frame, in the order of the nodes), for a backend that has no contact points. A node counts if its pressing
/// force exceeds a fifth of the largest one.
pub fn area_from_nodal_forces(finger: &FingerModel, force: &[ContactForce]) -> f64 {
    let pressed = pressed_nodes(force, finger.placement.closing, WITHIN);
    let part = |around: &Stencil| {
        let (nodes, weights) = around.slices();
        let own = nodes.iter().zip(weights).filter(|(node, _)| pressed[**node as usize]);
        own.map(|(_, weight)| weight).sum::<f64>()
    };
    let surface = &finger.surface;
    let points = surface.area[..surface.vertices].iter().zip(surface.report.iter());
    points.map(|(area, around)| area * part(around)).sum()
}

/// Measures the contact area of each pad, m2, and writes it to [`ContactArea`]: the sum of the reference areas of the
/// contact points under pressure, or the estimate of [`area_from_nodal_forces`] if the backend has only nodal forces.
pub fn measure_contact_area(
    shared: Res<SharedModel>,
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
                area[f] = area_from_nodal_forces(&model.fingers[f], &force[rows]);
            }
        }
    }
    for (finger, mut own) in &mut fingers {
        own.0 = area[finger.0 as usize];
    }
}
