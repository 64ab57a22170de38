//! Plausibility checks of loads and computing times: they detect wrong units or digits before a run.

use base::number::{format_number, round_significant};
use geometry::Aabb;
use geometry::Pose;
use indicatif::HumanDuration;
use model::Model;
use model::accuracy::indentation;
use record::pad_name;
use scene::{Loading, Scene};
use std::time::Duration;
use world::run::expected_time::{ExpectedTime, steps};

/// Processor time of a grasp above which an input error is assumed, s: one day.
const MAX_GRASP_TIME: f64 = 86_400.0;

/// Indentation of a pad over its thickness above which an input error of the force is assumed: twice the limit at which
/// a press is refused, because springs do not stiffen as gel does.
const MAX_INDENTATION_RATIO: f64 = 2.0;

/// Returns a sentence for each implausible property of a scene: a force that presses the object through a pad in the
/// grasp at `pose`, and a grasp that takes more than a day.
pub(super) fn implausible(scene: &Scene, model: &Model, pose: &Pose, expected: &ExpectedTime) -> Vec<String> {
    let sides = if model.has_equal_pads() { 1 } else { model.fingers.len() };
    let mut all: Vec<String> = (0..sides).filter_map(|side| excessive_indentation(scene, model, side, pose)).collect();
    if expected.grasp_s > MAX_GRASP_TIME {
        let steps = steps(model).zip(model.dynamics.as_ref()).map_or_else(String::new, |(steps, dynamics)| {
            let (steps, step) = (format_number(round_significant(steps, 2)), format_number(dynamics.time_step));
            format!(": it has {steps} time steps; is `time_step` = {step} s intended?")
        });
        let long = HumanDuration(Duration::from_secs_f64(expected.grasp_s.min(1e12)));
        all.push(format!("a grasp takes about {long} of processor time{steps}"));
    }
    all
}

/// Returns a sentence if the largest force indents pad `side`, as a bed of springs, by more than
/// [`MAX_INDENTATION_RATIO`] thicknesses.
fn excessive_indentation(scene: &Scene, model: &Model, side: usize, pose: &Pose) -> Option<String> {
    let force = match &scene.loading {
        Loading::Squeeze(squeeze) => squeeze.force.get(),
        Loading::Dynamic(_) => model.dynamics.as_ref()?.rated_force,
        Loading::Press(_) => return None,
    };
    let force = force / model.fingers.len() as f64;
    let topology = &model.fingers.get(side)?.topology;
    let (thickness, size) = (topology.thickness(), Aabb::from_points(topology.rest.iter().copied()).size().to_array());
    let depth = indentation(scene, &model.object, side, size, pose)
        .filter(|depth| *depth > MAX_INDENTATION_RATIO * thickness)?;
    let young = scene.gripper.with_equal_fingers(side).material.spec().young;
    let two = |value: f64| format_number(round_significant(value, 2));
    Some(format!(
        "a force of {} N on the {} pad would press the object {} mm deep into a gel of {} mm thickness (the force is \
         {} E t^2): is `young` = {} Pa given in pascals, and the force in newtons?",
        format_number(force),
        pad_name(side),
        two(depth * 1e3),
        two(thickness * 1e3),
        two(force / (young * thickness * thickness)),
        format_number(young),
    ))
}
