//! First contact, determined geometrically with undeformed pads.

use crate::components::{FingerIndex, FingerTravel, FirstContact, ObjectPose};
use crate::schedule::{NextPhase, Phase, SharedModel};
use crate::systems::apart::overlap_depth;
use bevy_ecs::prelude::*;
use geometry::Pose;
use glam::{DMat3, DVec3};
use model::Model;
use model::gripper::{Approach, approach};
use model::part::FingerModel;
use record::pad_name;

/// Closes every finger until its pad touches the object, or ends the grasp with the reason why it cannot.
///
/// The fingers of a parallel gripper travel together: the first one in contact pushes a free object along until the
/// other makes contact, too. Without weight and obstacles this is a translation along the closing direction.
pub fn close_to_contact(
    phase: Res<Phase>,
    shared: Res<SharedModel>,
    mut next: ResMut<NextPhase>,
    mut pose: Single<&mut ObjectPose>,
    mut fingers: Query<(&FingerIndex, &mut FingerTravel, &mut FirstContact)>,
) {
    if *phase != Phase::Close {
        return;
    }
    let model = &shared.0;
    let travel = match first_contact(model, &mut pose.0) {
        Ok(travel) => travel,
        Err(reason) => return next.request(Phase::Infeasible { reason }),
    };
    for (index, mut now, mut first) in &mut fingers {
        (now.0, first.0) = (travel[index.0 as usize], travel[index.0 as usize]);
    }
    next.request(Phase::Ramp { frame: 0 });
}

/// Returns the travel of every finger until its undeformed pad touches the object, m; a free object is moved to the
/// centre between them. Geared fingers of a dynamic scene stop when the first pad touches the object, or do not move.
///
/// # Errors
/// Fails if a pad overlaps the object in the open hand, a finger does not reach the object, or the pads overlap each
/// other; the message states which.
pub fn first_contact(model: &Model, pose: &mut Pose) -> Result<Vec<f64>, String> {
    if let Some(dynamics) = &model.dynamics {
        let meets = if dynamics.squeezes() { geared_travel(model, pose) } else { Ok(0.0) };
        let travel = vec![meets?; model.fingers.len()];
        return check_pad_overlap(model, &travel).map(|()| travel);
    }
    let each = (0..model.fingers.len()).map(|index| travel_to_contact(model, index, pose, model.offset));
    let mut travel = each.collect::<Result<Vec<f64>, String>>()?;
    pose.position += center_object(model, &mut travel);
    if let Some((index, t)) = travel.iter().enumerate().find(|(_, t)| **t > model.stroke) {
        let (t, stroke) = (t * 1e3, model.stroke * 1e3);
        let name = pad_name(index);
        return Err(format!(
            "the {name} finger would touch the object after {t:.1} mm, beyond its `stroke` of {stroke:.1} mm"
        ));
    }
    check_pad_overlap(model, &travel).map(|()| travel)
}

/// Equalises the travels at which two fingers touch a free object; returns the displacement of the object to the
/// centre, m.
pub fn center_object(model: &Model, travel: &mut [f64]) -> DVec3 {
    let (true, [first, second]) = (model.free, travel) else { return DVec3::ZERO };
    let pushed = model.fingers[0].placement.closing * (0.5 * (*second - *first));
    let mean = 0.5 * (*first + *second);
    (*first, *second) = (mean, mean);
    pushed
}

/// Rejects pads that overlap when they first touch the object: no load separates them again.
fn check_pad_overlap(model: &Model, travel: &[f64]) -> Result<(), String> {
    let ([first, second], [t, u]) = (model.fingers.as_slice(), travel) else { return Ok(()) };
    let axis = first.placement.closing;
    if t + u < model.opening {
        return Ok(());
    }
    let moved = |finger: &FingerModel, t: f64| -> Vec<DVec3> {
        finger.body.rest.iter().map(|x| *x + finger.placement.closing * t).collect()
    };
    let depth = overlap_depth(&first.surface, &moved(first, *t), &second.surface, &moved(second, *u), axis);
    if depth <= model.offset {
        return Ok(());
    }
    Err(format!(
        "the pads touch each other next to the object before both touch it and would overlap by {:.3} mm: contact \
         between the pads is not modelled; use smaller pads, a thicker object or another grasp",
        depth * 1e3
    ))
}

/// Returns the common travel of geared fingers until the first pad touches the object.
fn geared_travel(model: &Model, pose: &Pose) -> Result<f64, String> {
    let mut each = (0..model.fingers.len()).map(|i| travel_to_contact(model, i, pose, model.offset));
    each.try_fold(model.stroke, |first, travel| Ok(first.min(travel?)))
}

/// Returns the travel of finger `index` until its undeformed pad is `clearance` (m) from the object at `pose`, m.
///
/// # Errors
/// Fails if the pad overlaps the object in the open hand, or if the finger meets nothing within its reach; the message
/// states which.
pub fn travel_to_contact(model: &Model, index: usize, pose: &Pose, clearance: f64) -> Result<f64, String> {
    let finger = &model.fingers[index];
    let met = approach(
        &finger.surface,
        &finger.body.rest,
        finger.placement.closing,
        model.object.distance.as_ref(),
        &model.features,
        pose.position,
        DMat3::from_quat(pose.rotation),
        // A free object will be centred; until then the travel of a finger may exceed its stroke.
        if model.free { 2.0 * model.stroke } else { model.stroke },
        clearance,
    );
    let name = pad_name(index);
    match met {
        Approach::Contact(travel) => Ok(travel),
        Approach::Overlap(depth) => Err(format!(
            "the {name} pad overlaps the object by {:.2} mm in the open hand; increase `opening` ({:.1} mm) or move \
             the grasp",
            depth * 1e3,
            model.opening * 1e3
        )),
        Approach::Misses => {
            let away = distance_from_middle(model, finger, pose);
            let place = if away > 0.0 {
                format!("the object is {:.1} mm from the point midway between the pads", away * 1e3)
            } else {
                "the point midway between the pads is inside the object".into()
            };
            Err(format!(
                "the {name} finger does not touch the object within its stroke of {:.1} mm: {place}; move the grasp \
                 (`centre` of a pose sets this point) or increase `stroke`",
                model.stroke * 1e3
            ))
        }
    }
}

/// Returns the signed distance of the object from the point midway between the pads of the open hand, m.
fn distance_from_middle(model: &Model, finger: &FingerModel, pose: &Pose) -> f64 {
    let middle = finger.placement.origin + 0.5 * model.opening * finger.placement.closing;
    model.object.distance.distance(pose.rotation.conjugate() * (middle - pose.position))
}
