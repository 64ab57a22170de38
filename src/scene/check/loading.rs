//! Checks of the loading against fingers, object and solver.

use super::problem::{Problem, problem_at};
use crate::gripper::Fingers;
use crate::loading::{Loading, Squeeze};
use crate::motion;
use crate::object::ObjectMotion;
use crate::schema::Scene;
use crate::stepper::{Fem, Solver, StepperChoice};
use base::number::format_number;
use glam::DVec3;

/// Largest number of depths of a press, equal to the largest number of its frames.
const DEPTHS: usize = 10_000;

/// Checks fingers, motion of the object and levels of a quasi-static loading.
pub(super) fn loading(scene: &Scene) -> Result<(), Problem> {
    if matches!(scene.loading, Loading::Dynamic(_)) {
        return Ok(());
    }
    if scene.gripper.fingers == Fingers::None {
        return problem_at("gripper.fingers", "this loading needs fingers\nuse Both or One, or loading: Dynamic");
    }
    if scene.gripper.fingers == Fingers::One && scene.object.motion == ObjectMotion::Free {
        return problem_at(
            "gripper.fingers",
            "one finger cannot hold a free object\nuse motion: Fixed in object, or fingers: Both",
        );
    }
    let press = match &scene.loading {
        Loading::Press(press) => press,
        Loading::Squeeze(s) if s.release.is_some_and(|release| release.get() > s.force.get()) => {
            let message = format!(
                "the object would never be released\nallowed: at most force, {} N",
                format_number(s.force.get())
            );
            return problem_at("loading.release", message);
        }
        Loading::Squeeze(Squeeze { push: Some(_), .. }) if scene.object.motion == ObjectMotion::Fixed => {
            return problem_at(
                "loading.push",
                "a push has no effect on a fixed object\nuse motion: Free in object, or leave it out",
            );
        }
        Loading::Squeeze(Squeeze { push: Some(push), .. })
            if push.force.dvec3() == DVec3::ZERO && push.torque.dvec3() == DVec3::ZERO =>
        {
            return problem_at(
                "loading.push",
                "a push without force and torque\ngive `force` or `torque`, or leave it out",
            );
        }
        Loading::Squeeze(s) => match s.from.map(|f| f.get()) {
            Some(from) if from >= s.force.get() => {
                let message = format!(
                    "the first frame is at {} N, the last at {} N\nallowed: below force",
                    format_number(from),
                    format_number(s.force.get())
                );
                return problem_at("loading.from", message);
            }
            _ => return Ok(()),
        },
        Loading::Dynamic(_) => return Ok(()),
    };
    match (&press.depth, &press.depths) {
        (None, None) => problem_at("loading", "a press needs `depth` or `depths`"),
        (Some(_), Some(_)) => problem_at("loading.depths", "depth and depths are both given\ngive one of them"),
        (None, Some(_)) if press.frames.is_some() => {
            problem_at("loading.frames", "`depths` already defines the frames\nuse `depth` with `frames`")
        }
        (None, Some(depths)) if depths.is_empty() => problem_at("loading.depths", "an empty list of depths"),
        (None, Some(depths)) if depths.len() > DEPTHS => {
            problem_at("loading.depths", format!("{} depths\nallowed: at most {DEPTHS}", depths.len()))
        }
        (None, Some(depths)) => match depths.windows(2).position(|w| w[1].get() <= w[0].get()) {
            Some(i) => problem_at(format!("loading.depths[{}]", i + 1), "depths must increase"),
            None => travel(scene, press.levels()),
        },
        (Some(_), None) => travel(scene, press.levels()),
    }
}

/// Checks that a press does not exceed the stroke of a finger.
fn travel(scene: &Scene, levels: Vec<f64>) -> Result<(), Problem> {
    let (last, stroke) = (levels.last().copied().unwrap_or(0.0), scene.gripper.stroke.get());
    if last <= stroke {
        return Ok(());
    }
    problem_at(
        "loading",
        format!(
            "a press of {} m is longer than the finger's stroke ({} m)",
            format_number(last),
            format_number(stroke)
        ),
    )
}

/// Checks the fields that a dynamic loading excludes and those that require it.
pub(super) fn dynamic(scene: &Scene) -> Result<(), Problem> {
    let Loading::Dynamic(dynamic) = &scene.loading else {
        let moving = [
            ("ground", scene.ground.is_some()),
            ("object.velocity", scene.object.velocity.is_some()),
            ("object.spin", scene.object.spin.is_some()),
        ];
        if let Some((path, _)) = moving.into_iter().find(|(_, given)| *given) {
            return problem_at(path, "only a dynamic scene has this field\nuse loading: Dynamic(motions: [...])");
        }
        return Ok(());
    };
    if let StepperChoice::Fem(Fem { solver: Solver::Condensed(_), .. }) = scene.stepper {
        return problem_at("stepper.solver", "condensed pads have no inertia\nuse solver: Full in a dynamic scene");
    }
    let moves = scene.object.velocity.is_some() || scene.object.spin.is_some();
    if moves && scene.object.motion == ObjectMotion::Fixed {
        return problem_at("object.motion", "a fixed object has neither velocity nor spin");
    }
    if dynamic.motions.is_empty() {
        return problem_at("loading.motions", "an empty list of motions\nHold(duration: 0.5) waits for half a second");
    }
    let no_gravity = scene.gravity.is_none_or(|g| g.dvec3() == glam::DVec3::ZERO);
    for (i, motion) in dynamic.motions.iter().enumerate() {
        if motion.as_profile().duration() == 0.0 {
            return problem_at(format!("loading.motions[{i}]"), "repeats an empty list of motions");
        }
        if motion.as_profile().needs_gravity() && no_gravity {
            let message = "a lift needs gravity, and the scene has none\nset gravity, or use Move(by: (x, y, z), ...)";
            return problem_at(format!("loading.motions[{i}]"), message);
        }
    }
    if scene.gripper.fingers == Fingers::None && !motion::squeezes(&dynamic.motions).is_empty() {
        return problem_at("loading.motions", "this motion needs fingers\nuse fingers: Both in gripper");
    }
    Ok(())
}
