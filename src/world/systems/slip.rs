//! Slip of the nodes of the pads over the object.

use crate::components::*;
use crate::schedule::SharedModel;
use crate::systems::contact_area::pressed_nodes;
use bevy_ecs::prelude::*;
use geometry::Pose;
use geometry::face_lookup::FaceLookup;
use glam::DVec3;
use mech::contact::coulomb::tangential;
use mech::potential::term::Stencil;
use model::Model;

/// Fraction of Coulomb's limit from which on a tangential force counts as slipping, if only nodal forces are known.
const AT_LIMIT: f64 = 0.99;
/// Fraction of the largest nodal force above which a node can slip: forces of a network are nowhere exactly zero.
const PRESSED: f64 = 0.01;

/// Node columns.
type Nodes<'a> = (&'a FingerIndex, &'a Position, &'a ContactForce, &'a mut NodeSlip);

/// Measures the fraction of the contact force of each node that slipping points carry. With friction at contact points,
/// their slip state is used; if only nodal forces are known, a node slips if its tangential force is at Coulomb's limit
/// of this friction.
pub fn measure_slip(
    shared: Res<SharedModel>,
    edges: Query<(&FingerIndex, &ContactEdge, &ContactFriction)>,
    fingers: Query<(&FingerIndex, &ClosingDirection, &FingerTravel)>,
    object: Single<&ObjectPose>,
    mut nodes: Query<Nodes>,
) {
    let model = &shared.0;
    let mut carried = vec![DVec3::ZERO; model.fingers.len()];
    for (index, closing, travel) in &fingers {
        carried[index.0 as usize] = closing.0 * travel.0;
    }
    let known = !edges.is_empty();
    for (finger, position, force, mut slip) in nodes.contiguous_iter_mut().expect(TABLES) {
        let slip = slip.bypass_change_detection();
        for (f, rows) in rows_by_pad(finger) {
            let (x, own) = (&position[rows.clone()], &mut slip[rows.clone()]);
            if known {
                own.fill(NodeSlip(0.0));
                let edges = edges.contiguous_iter().expect(TABLES).flat_map(|(finger, edges, friction)| {
                    let pads = rows_by_pad(finger).filter(move |(pad, _)| *pad == f);
                    pads.map(move |(_, rows)| (&edges[rows.clone()], &friction[rows]))
                });
                edges.for_each(|(edges, friction)| {
                    slip_from_contact_points((model, f), carried[f], x, edges, friction, own)
                });
            } else {
                let x = x.iter().map(|x| x.0 + carried[f]);
                let parts = slip_from_nodal_forces((model, f), x, &force[rows], &object.0);
                own.iter_mut().zip(parts).for_each(|(own, part)| own.0 = part);
            }
        }
    }
}

/// Returns the fraction of the force of each node of pad `f` that slips, 0 or 1, if only nodal forces are known: `x`
/// are the positions of the nodes, hand frame.
pub fn slip_from_nodal_forces(
    (model, f): (&Model, usize),
    x: impl Iterator<Item = DVec3>,
    force: &[ContactForce],
    object: &Pose,
) -> Vec<f64> {
    let back = object.rotation.inverse();
    let pressed = pressed_nodes(force, model.fingers[f].placement.closing, PRESSED);
    let part = |((x, force), pressed): ((DVec3, &ContactForce), bool)| {
        let at = back * (x - object.position);
        let normal = || model.object.distance.closest(at, f64::INFINITY).map(|c| object.rotation * c.normal);
        f64::from(match model.needs.friction {
            true => pressed && normal().is_some_and(|n| at_friction_limit(force.0, n, model.fingers[f].law.friction)),
            // Without friction, everything in contact slips.
            false => force.0 != DVec3::ZERO,
        })
    };
    x.zip(force).zip(pressed).map(part).collect()
}

/// Returns true if a force on a pad (N) that presses along the outward normal of the object is at Coulomb's limit of
/// this friction.
fn at_friction_limit(force: DVec3, normal: DVec3, friction: f64) -> bool {
    force.dot(normal) > 0.0 && tangential(force, normal, friction).1 >= AT_LIMIT
}

/// Accumulates the slip of the contact points of pad `f` at its nodes: `x` are their positions relative to the finger,
/// `carried` is its displacement, m.
fn slip_from_contact_points(
    (model, f): (&Model, usize),
    carried: DVec3,
    x: &[Position],
    edges: &[ContactEdge],
    friction: &[ContactFriction],
    slip: &mut [NodeSlip],
) {
    let finger = &model.fingers[f];
    let points = finger.surface.points.len();
    let (axes, origin) = (finger.placement.rotation.transpose(), finger.placement.origin);
    let moved = edges[points..].iter().any(|edge| edge.force != DVec3::ZERO);
    let face: Vec<DVec3> = if moved { x.iter().map(|x| axes * (x.0 - origin)).collect() } else { Vec::new() };
    let lookup = moved.then(|| FaceLookup::new(&face, &finger.topology.sensing));
    // Contact vertices of the object may touch the pad anywhere.
    let touched = |edge: &ContactEdge| {
        let under = lookup.as_ref().map(|lookup| lookup.interpolation_at(axes * (edge.point - carried - origin)));
        under.map_or(Stencil::NONE, |nodes| Stencil::new(nodes.into_iter()))
    };
    let mut whole = vec![0.0; slip.len()];
    for (i, (edge, friction)) in
        edges.iter().zip(friction).enumerate().filter(|(_, (edge, _))| edge.force != DVec3::ZERO)
    {
        let report = if i < points { finger.surface.report[i] } else { touched(edge) };
        let (nodes, weights) = report.slices();
        for (node, weight) in nodes.iter().zip(weights) {
            let part = weight * edge.force.length();
            whole[*node as usize] += part;
            slip[*node as usize].0 += if friction.slips { part } else { 0.0 };
        }
    }
    slip.iter_mut().zip(whole).filter(|(_, whole)| *whole > 0.0).for_each(|(own, whole)| own.0 /= whole);
}
