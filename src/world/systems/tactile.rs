//! Arrays of the tactile sensors in the frame of a step.

use crate::schedule::{RecordedFrame, SharedModel};
use bevy_ecs::prelude::*;
use model::sensors::SensorInput;

/// Adds the arrays of the tactile sensors that the scene records to the frame.
pub fn record_tactile(shared: Res<SharedModel>, mut recorded: ResMut<RecordedFrame>) {
    let Some(frame) = &mut recorded.0 else { return };
    let model = &shared.0;
    let now = SensorInput { fingers: &model.fingers, object: &model.object, frame };
    frame.tactile = model.sensors.iter().map(|sensor| sensor.record(&now)).collect();
}
