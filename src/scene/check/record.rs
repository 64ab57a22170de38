//! Checks of the recorded output against the rest of the scene.

use crate::gripper::Fingers;
use crate::schema::Scene;

/// Returns the first invalid value, as field and message.
pub(super) fn problem(scene: &Scene) -> Option<(String, String)> {
    let tactile = &scene.record.tactile;
    let field = |message: String| Some(("record.tactile".to_string(), message));
    if let Some(other) = tactile.iter().find(|observe| !observe.is_tactile()) {
        return field(format!(
            "`{}` is not an observation of a tactile sensor\nruns and data sets contain such values in any case",
            other.name()
        ));
    }
    if (1..tactile.len()).any(|i| tactile[..i].iter().any(|o| o.name() == tactile[i].name())) {
        return field("two observations have the same name".into());
    }
    (!tactile.is_empty() && scene.gripper.fingers == Fingers::None)
        .then(|| ("record.tactile".into(), "the scene has no pads with tactile observations\nuse fingers: Both".into()))
}
