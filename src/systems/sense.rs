//! First contact, found geometrically on the undeformed pads.

use crate::components::{FingerIndex, FingerTravel, FirstContact, ObjectPose};
use crate::gripper::{Approach, approach};
use crate::model::Model;
use crate::record::pad_name;
use crate::schedule::{Next, Phase, Shared};
use bevy_ecs::prelude::*;
use glam::DMat3;

/// Closes every finger until its pad touches the object, or says why it cannot.
pub fn close_to_contact(
    phase: Res<Phase>,
    shared: Res<Shared>,
    mut next: ResMut<Next>,
    pose: Single<&ObjectPose>,
    mut fingers: Query<(&FingerIndex, &mut FingerTravel, &mut FirstContact)>,
) {
    if *phase != Phase::Close {
        return;
    }
    for (index, mut travel, mut first) in &mut fingers {
        match first_contact(&shared.0, index.0 as usize, &pose, shared.0.law.offset) {
            Ok(t) => (travel.0, first.0) = (t, t),
            Err(reason) => return next.request(Phase::Infeasible { reason }),
        }
    }
    next.request(Phase::Ramp { frame: 0 });
}

/// Travel of finger `index` until its undeformed pad is `clearance` (m) from the object at `pose`, m.
pub fn first_contact(model: &Model, index: usize, pose: &ObjectPose, clearance: f64) -> Result<f64, String> {
    let finger = &model.fingers[index];
    let met = approach(
        &finger.surface,
        &finger.body.rest,
        finger.placement.closing,
        model.object.distance.as_ref(),
        &model.features,
        pose.position,
        DMat3::from_quat(pose.rotation),
        model.stroke,
        clearance,
    );
    let name = pad_name(index);
    match met {
        Approach::Contact(travel) => Ok(travel),
        Approach::Overlap(depth) => Err(format!(
            "the {name} pad overlaps the object by {:.2} mm in the open hand; widen `opening` ({:.1} mm) or move the grasp",
            depth * 1e3,
            model.opening * 1e3
        )),
        Approach::Misses => Err(format!(
            "the {name} finger meets nothing within its stroke of {:.1} mm; move the grasp or lengthen `stroke`",
            model.stroke * 1e3
        )),
    }
}
