//! Audit as a system, which exists only if an expectation of the scene requires it.

use crate::schedule::{GraspPose, RecordedFrame, SharedModel, Timings};
use bevy_ecs::prelude::*;
use glam::DVec3;
use model::evaluation::Findings;
use std::time::Instant;

/// Findings on the last recorded frame.
#[derive(Resource, Debug, Default)]
pub struct AuditFindings(pub Option<Findings>);

/// Audits the frame of this step.
pub fn audit_frame(
    shared: Res<SharedModel>,
    grasp: Res<GraspPose>,
    recorded: Res<RecordedFrame>,
    mut audited: ResMut<AuditFindings>,
    mut timings: ResMut<Timings>,
) {
    let model = &shared.0;
    let (Some(auditor), Some(frame)) = (&model.auditor, &recorded.0) else { return };
    let clock = Instant::now();
    let gravity = model.gravity.map_or(DVec3::ZERO, |g| grasp.0.inverse().rotation * g);
    audited.0 = Some(auditor.audit(&model.fingers, frame, gravity));
    *timings.stages.entry("audit").or_insert(0.0) += clock.elapsed().as_secs_f64();
}
