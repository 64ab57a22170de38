//! Checks of the consistency of several fields.

mod loading;
mod problem;
mod record;
mod shape;
mod task;

pub(super) use problem::Problem;

use super::bonding::{BondingPlane, BondingRule};
use super::expect::{Bounds, Expectation};
use super::grasps::Grasps;
use super::gripper::Fingers;
use super::leaf::MIN_PAD_SIDE;
use super::loading::Loading;
use super::object::ObjectShape;
use super::pad::{BoxPad, DiscPad, GelSightMini, Pads};
use super::schema::{Scene, ScenePart};
use base::number::format_number;
use loading::{dynamic, loading};
use problem::problem_at;
use shape::shape;
use std::collections::BTreeSet;

/// Largest number of objects of a scene.
pub const MAX_OBJECTS: usize = 10_000;
/// Largest number of expected results of a scene.
pub const MAX_EXPECTATIONS: usize = 1_000;
/// Largest product of the length of the text that all objects share and the number of objects, bytes: each object gets
/// a copy.
pub const MAX_SHARED_BYTES: usize = 256 << 20;

/// Checks the lists of objects: unique names, only one of `object`, `objects` and `universe`, and object number and
/// text length within the limits. `shared` is the length of the text outside the list of objects, bytes.
pub(super) fn objects(part: &ScenePart, shared: usize) -> Result<(), Problem> {
    if let Some(universe) = &part.universe {
        if part.object.is_some() || part.objects.is_some() {
            return problem_at("universe", "a universe and objects are both given\ngive one of them");
        }
        if !matches!(part.loading, Some(Loading::Squeeze(_)) | None) {
            return problem_at(
                "loading",
                "a universe samples the force of a squeeze\nallowed: Squeeze(force: ..., frames: ...)",
            );
        }
        if part.gripper.as_ref().is_some_and(|gripper| gripper.right.is_some()) {
            return problem_at("gripper.right", "a universe needs two identical pads\nleave it out");
        }
        return universe.problem().map_or(Ok(()), |(path, message)| problem_at(path, message));
    }
    let Some(objects) = &part.objects else { return Ok(()) };
    if part.object.is_some() {
        return problem_at("objects", "object and objects are both given\ngive one of them");
    }
    if objects.is_empty() {
        return problem_at("objects", "an empty list of objects");
    }
    if objects.len() > MAX_OBJECTS {
        let message = format!("{} objects\nallowed: at most {MAX_OBJECTS} in one scene", objects.len());
        return problem_at("objects", message);
    }
    if shared.saturating_mul(objects.len()) > MAX_SHARED_BYTES {
        let message = format!(
            "{} objects with {shared} bytes of common scene text exceed the limit\n\
             put long lists into files, or the objects into several scenes",
            objects.len()
        );
        return problem_at("objects", message);
    }
    let mut names = BTreeSet::new();
    for (i, entry) in objects.iter().enumerate() {
        if !names.insert(&entry.name) {
            let message = format!("two objects are named {:?}", entry.name.as_str());
            return problem_at(format!("objects[{i}].name"), message);
        }
    }
    Ok(())
}

/// Returns the first problem of the scene as an error.
pub(super) fn check(scene: &Scene) -> Result<(), Problem> {
    shape(&scene.object.shape)?;
    if scene.object.repair && !matches!(scene.object.shape, ObjectShape::Mesh(_)) {
        return problem_at(
            "object.repair",
            "only a surface from a file can be repaired\nleave it out, or give `shape: Mesh(\"file\")`",
        );
    }
    gripper(scene)?;
    grasps(&scene.grasps)?;
    loading(scene)?;
    dynamic(scene)?;
    task::problem(scene).map_or(Ok(()), |(path, message)| problem_at(path, message))?;
    record::problem(scene).map_or(Ok(()), |(path, message)| problem_at(path, message))?;
    check_expectations(scene)
}

/// Checks the expected results of the scene, separately for each backend.
fn check_expectations(scene: &Scene) -> Result<(), Problem> {
    for (field, list) in scene.expectation_lists() {
        if list.len() > MAX_EXPECTATIONS {
            return problem_at(field, format!("{} expectations\nallowed: at most {MAX_EXPECTATIONS}", list.len()));
        }
        for (i, one) in list.iter().enumerate() {
            expectation(scene, one).or_else(|message| problem_at(format!("{field}[{i}]"), message))?;
        }
    }
    Ok(())
}

/// Checks the pads of both fingers, and that fields which require equal pads are not used with different pads.
fn gripper(scene: &Scene) -> Result<(), Problem> {
    let gripper = &scene.gripper;
    pads(&gripper.pads, "gripper.pads")?;
    let Some(right) = &gripper.right else { return Ok(()) };
    right.pads.as_ref().map_or(Ok(()), |own| pads(own, "gripper.right.pads"))?;
    if gripper.fingers != Fingers::Both {
        return problem_at("gripper.right", "there is no right finger\nleave it out, or use fingers: Both");
    }
    if !gripper.has_equal_fingers() && !scene.record.tactile.is_empty() {
        return problem_at(
            "record.tactile",
            "tactile images need two identical pads\nleave it out, or leave out `right` in gripper",
        );
    }
    Ok(())
}

fn pads(pads: &Pads, at: &str) -> Result<(), Problem> {
    let too_small = |field: &str, length: f64| {
        let message = format!(
            "{} m is too small for a pad\nallowed: at least {} m",
            format_number(length),
            format_number(MIN_PAD_SIDE)
        );
        problem_at(format!("{at}.{field}"), message)
    };
    match pads {
        Pads::Box(b) if b.size.size().min_element() < MIN_PAD_SIDE => too_small("size", b.size.size().min_element()),
        Pads::Disc(d) if d.radius.get() < MIN_PAD_SIDE => too_small("radius", d.radius.get()),
        Pads::Disc(d) if d.thickness.get() < MIN_PAD_SIDE => too_small("thickness", d.thickness.get()),
        Pads::Box(b) if b.cells.is_some() && b.spacing.is_some() => {
            problem_at(format!("{at}.cells"), "cells and spacing are both given\ngive one of them")
        }
        Pads::GelSightMini(GelSightMini { spacing: Some(_), accuracy: Some(_), .. })
        | Pads::Box(BoxPad { spacing: Some(_), accuracy: Some(_), .. })
        | Pads::Disc(DiscPad { spacing: Some(_), accuracy: Some(_), .. }) => {
            problem_at(format!("{at}.accuracy"), "accuracy and spacing are both given\ngive one of them")
        }
        Pads::Box(BoxPad { cells: Some(_), accuracy: Some(_), .. }) => {
            problem_at(format!("{at}.accuracy"), "accuracy and cells are both given\ngive one of them")
        }
        Pads::File(f) if f.outward.dvec3().length() < 1e-9 => {
            problem_at(format!("{at}.outward"), "a direction of length zero\n(0, 0, 1) is along +z of the file")
        }
        Pads::File(f) => match &f.bonded {
            BondingRule::Plane(BondingPlane { normal: Some(normal), .. }) if normal.dvec3().length() < 1e-9 => {
                problem_at(
                    "gripper.pads.bonded.normal",
                    "a direction of length zero\nleave it out for the opposite of outward",
                )
            }
            _ => Ok(()),
        },
        _ => Ok(()),
    }
}

fn grasps(grasps: &Grasps) -> Result<(), Problem> {
    match grasps {
        Grasps::List(poses) if poses.is_empty() => {
            problem_at("grasps", "an empty list of grasps\nleave `grasps` out for one grasp at the identity pose")
        }
        Grasps::List(poses) => match poses.iter().position(|p| p.position.is_some() == p.centre.is_some()) {
            Some(i) => problem_at(
                format!("grasps[{i}]"),
                "a pose needs `position`, the origin of the hand, or `centre`, the point midway between the pads, but \
                 not both\n`centre: (0, 0, 0)` places the origin of the object between the pads for any rotation of \
                 the hand",
            ),
            None => Ok(()),
        },
        Grasps::Antipodal(a) if a.tilt_deg.get() > 90.0 => problem_at(
            "grasps.tilt_deg",
            format!("must be at most 90 degrees, found {}", format_number(a.tilt_deg.get())),
        ),
        Grasps::File(f) if !f.convention.is_right_angled() => problem_at(
            "grasps.convention",
            "closing and approach are along the same axis\nthey must be perpendicular, such as X and Z",
        ),
        _ => Ok(()),
    }
}

/// Checks that an expected result applies to this scene; the error is the message.
fn expectation(scene: &Scene, expectation: &Expectation) -> Result<(), String> {
    match (&scene.loading, expectation) {
        (Loading::Dynamic(_), Expectation::Converged(_)) => {
            return Err(
                "Converged checks forces without inertia\nuse ForceBalance(relative: ...) in a dynamic scene".into()
            );
        }
        (Loading::Squeeze(_) | Loading::Press(_), e) if e.is_dynamic() => {
            return Err(format!("{} needs loading: Dynamic(motions: [...])", e.name()));
        }
        _ => {}
    }
    let (Expectation::Travel(Bounds { at_least, at_most })
    | Expectation::Force(Bounds { at_least, at_most })
    | Expectation::Penetration(Bounds { at_least, at_most })
    | Expectation::MaxStress(Bounds { at_least, at_most })
    | Expectation::ObjectSlides(Bounds { at_least, at_most })
    | Expectation::ObjectSpeed(Bounds { at_least, at_most })
    | Expectation::GroundForce(Bounds { at_least, at_most })
    | Expectation::Torque(Bounds { at_least, at_most })) = expectation
    else {
        return Ok(());
    };
    match (at_least, at_most) {
        (None, None) => Err(format!("{} needs at_least, at_most or both", expectation.name())),
        (Some(low), Some(high)) if low.get() > high.get() => {
            Err("at_least is above at_most: no value satisfies both".into())
        }
        _ => Ok(()),
    }
}
