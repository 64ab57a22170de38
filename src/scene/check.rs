//! Checks of the consistency of several fields.

use super::bonding::{BondingPlane, BondingRule};
use super::expect::{Bounds, Expectation};
use super::grasps::Grasps;
use super::gripper::Fingers;
use super::leaf::PAD_FLOOR;
use super::loading::{Loading, Squeeze};
use super::motion;
use super::object::{ObjectMotion, ObjectShape, Revolve};
use super::pad::{BoxPad, DiscPad, GelSightMini, Pads};
use super::schema::{Scene, ScenePart};
use super::stepper::{Fem, Solver, StepperChoice};
use base::number::shown;
use glam::DVec3;
use std::collections::BTreeSet;

/// Error of a field that is inconsistent with the rest of the scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Problem {
    /// Path of the field, like `object.shape.inner`.
    pub path: String,
    /// Error message; further lines are the help.
    pub message: String,
}

/// Largest number of objects of a scene.
pub const OBJECTS: usize = 10_000;
/// Largest number of expected results of a scene.
pub const PROMISES: usize = 1_000;
/// Largest number of depths of a press, equal to the largest number of its frames.
pub const DEPTHS: usize = 10_000;
/// Largest product of the length of the text that all objects share and the number of objects, bytes: each object gets
/// a copy.
pub const SHARED: usize = 256 << 20;

/// Checks the lists of objects: unique names, only one of `object`, `objects` and `universe`, and object number and
/// text length within the limits. `shared` is the length of the text outside the list of objects, bytes.
pub(super) fn objects(part: &ScenePart, shared: usize) -> Result<(), Problem> {
    if let Some(universe) = &part.universe {
        if part.object.is_some() || part.objects.is_some() {
            return refuse("universe", "a universe and objects are both given\ngive one of them");
        }
        if !matches!(part.loading, Some(Loading::Squeeze(_)) | None) {
            return refuse(
                "loading",
                "a universe samples the force of a squeeze\nallowed: Squeeze(force: ..., frames: ...)",
            );
        }
        if part.gripper.as_ref().is_some_and(|gripper| gripper.right.is_some()) {
            return refuse("gripper.right", "a universe needs two identical pads\nleave it out");
        }
        return universe.problem().map_or(Ok(()), |(path, message)| refuse(path, message));
    }
    let Some(objects) = &part.objects else { return Ok(()) };
    if part.object.is_some() {
        return refuse("objects", "object and objects are both given\ngive one of them");
    }
    if objects.is_empty() {
        return refuse("objects", "an empty list of objects");
    }
    if objects.len() > OBJECTS {
        let message = format!("{} objects\nallowed: at most {OBJECTS} in one scene", objects.len());
        return refuse("objects", message);
    }
    if shared.saturating_mul(objects.len()) > SHARED {
        let message = format!(
            "{} objects with {shared} bytes of common scene text exceed the limit\n\
             put long lists into files, or the objects into several scenes",
            objects.len()
        );
        return refuse("objects", message);
    }
    let mut names = BTreeSet::new();
    for (i, entry) in objects.iter().enumerate() {
        if !names.insert(&entry.name) {
            let message = format!("two objects are named {:?}", entry.name.as_str());
            return refuse(format!("objects[{i}].name"), message);
        }
    }
    Ok(())
}

/// Returns the first problem of the scene as an error.
pub(super) fn check(scene: &Scene) -> Result<(), Problem> {
    shape(&scene.object.shape)?;
    if scene.object.repair && !matches!(scene.object.shape, ObjectShape::Mesh(_)) {
        return refuse(
            "object.repair",
            "only a surface from a file can be repaired\nleave it out, or give `shape: Mesh(\"file\")`",
        );
    }
    gripper(scene)?;
    if scene.finer_mesh().is_some() && [0, 1].iter().any(|side| matches!(scene.gripper.like(*side).pads, Pads::File(_)))
    {
        return refuse("stepper.mesh", "the mesh of a pad from a file is fixed\nleave it out");
    }
    grasps(&scene.grasps)?;
    loading(scene)?;
    dynamic(scene)?;
    super::task::problem(scene).map_or(Ok(()), |(path, message)| refuse(path, message))?;
    super::output::problem(scene).map_or(Ok(()), |(path, message)| refuse(path, message))?;
    promises(scene)
}

/// Checks the expected results of the scene, separately for each backend.
fn promises(scene: &Scene) -> Result<(), Problem> {
    for (field, list) in scene.promise_lists() {
        if list.len() > PROMISES {
            return refuse(field, format!("{} expectations\nallowed: at most {PROMISES}", list.len()));
        }
        for (i, one) in list.iter().enumerate() {
            expectation(scene, one).or_else(|message| refuse(format!("{field}[{i}]"), message))?;
        }
    }
    Ok(())
}

fn refuse<T>(path: impl Into<String>, message: impl Into<String>) -> Result<T, Problem> {
    Err(Problem { path: path.into(), message: message.into() })
}

fn shape(shape: &ObjectShape) -> Result<(), Problem> {
    let rounding = |edge: f64, most: f64| {
        if edge <= most {
            return Ok(());
        }
        refuse(
            "object.shape.edge_radius",
            format!("edge radius {} m is too large\nallowed here: at most {}", shown(edge), shown(most)),
        )
    };
    match shape {
        ObjectShape::Cuboid(c) => rounding(c.edge_radius.get(), c.size.size().min_element() / 2.0),
        ObjectShape::Annulus(a) if a.inner.get() >= a.outer.get() => refuse(
            "object.shape.inner",
            format!("the hole ({} m) must be narrower than outer ({} m)", shown(a.inner.get()), shown(a.outer.get())),
        ),
        ObjectShape::Cup(c) if c.wall.get() >= c.radius.get().min(c.height.get()) => refuse(
            "object.shape.wall",
            format!("wall {} m leaves no cavity\nallowed: below radius and height", shown(c.wall.get())),
        ),
        ObjectShape::Banana(b) if !(1.0..=170.0).contains(&b.bend_deg.get()) => refuse(
            "object.shape.bend_deg",
            format!("a banana bends by 1 to 170 degrees, found {}", shown(b.bend_deg.get())),
        ),
        ObjectShape::Potato(p) if p.roughness.get() > 0.3 => refuse(
            "object.shape.roughness",
            format!("roughness must be at most 0.3, found {}", shown(p.roughness.get())),
        ),
        ObjectShape::Revolve(r) => profile(r),
        ObjectShape::Sweep(s) => {
            if s.path.len() < 2 {
                return refuse("object.shape.path", "a sweep needs at least two points");
            }
            if s.radii.len() != 1 && s.radii.len() != s.path.len() {
                let message = format!(
                    "{} radii for {} points\nallowed: one radius for all, or one per point",
                    s.radii.len(),
                    s.path.len()
                );
                return refuse("object.shape.radii", message);
            }
            Ok(())
        }
        _ => Ok(()),
    }
}

fn profile(r: &Revolve) -> Result<(), Problem> {
    let (last, fewest) = (r.profile.len().saturating_sub(1), if r.closed { 3 } else { 2 });
    if r.profile.len() < fewest {
        return refuse("object.shape.profile", format!("a profile of points (r, z) needs at least {fewest} of them"));
    }
    for (i, p) in r.profile.iter().enumerate() {
        let (radius, end) = (p.pair()[0], !r.closed && (i == 0 || i == last));
        let wanted = match () {
            () if end && radius != 0.0 => "a profile starts and ends on the axis: r = 0",
            () if !end && radius <= 0.0 => "a profile stays off the axis between its ends: r > 0",
            () => continue,
        };
        let message = format!(
            "{wanted}, found ({}, {})\na ring is a loop of points off the axis with closed: true",
            shown(radius),
            shown(p.pair()[1])
        );
        return refuse(format!("object.shape.profile[{i}]"), message);
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
        return refuse("gripper.right", "there is no right finger\nleave it out, or use fingers: Both");
    }
    if !gripper.alike() && !scene.record.tactile.is_empty() {
        return refuse(
            "record.tactile",
            "tactile images need two identical pads\nleave it out, or leave out `right` in gripper",
        );
    }
    Ok(())
}

fn pads(pads: &Pads, at: &str) -> Result<(), Problem> {
    let too_small = |field: &str, length: f64| {
        let message = format!("{} m is too small for a pad\nallowed: at least {} m", shown(length), shown(PAD_FLOOR));
        refuse(format!("{at}.{field}"), message)
    };
    match pads {
        Pads::Box(b) if b.size.size().min_element() < PAD_FLOOR => too_small("size", b.size.size().min_element()),
        Pads::Disc(d) if d.radius.get() < PAD_FLOOR => too_small("radius", d.radius.get()),
        Pads::Disc(d) if d.thickness.get() < PAD_FLOOR => too_small("thickness", d.thickness.get()),
        Pads::Box(b) if b.cells.is_some() && b.spacing.is_some() => {
            refuse(format!("{at}.cells"), "cells and spacing are both given\ngive one of them")
        }
        Pads::GelSightMini(GelSightMini { spacing: Some(_), accuracy: Some(_), .. })
        | Pads::Box(BoxPad { spacing: Some(_), accuracy: Some(_), .. })
        | Pads::Disc(DiscPad { spacing: Some(_), accuracy: Some(_), .. }) => {
            refuse(format!("{at}.accuracy"), "accuracy and spacing are both given\ngive one of them")
        }
        Pads::Box(BoxPad { cells: Some(_), accuracy: Some(_), .. }) => {
            refuse(format!("{at}.accuracy"), "accuracy and cells are both given\ngive one of them")
        }
        Pads::File(f) if f.outward.dvec3().length() < 1e-9 => {
            refuse(format!("{at}.outward"), "a direction of length zero\n(0, 0, 1) is along +z of the file")
        }
        Pads::File(f) => match &f.bonded {
            BondingRule::Plane(BondingPlane { normal: Some(normal), .. }) if normal.dvec3().length() < 1e-9 => refuse(
                "gripper.pads.bonded.normal",
                "a direction of length zero\nleave it out for the opposite of outward",
            ),
            _ => Ok(()),
        },
        _ => Ok(()),
    }
}

fn grasps(grasps: &Grasps) -> Result<(), Problem> {
    match grasps {
        Grasps::List(poses) if poses.is_empty() => {
            refuse("grasps", "an empty list of grasps\nleave `grasps` out for one grasp at the identity pose")
        }
        Grasps::List(poses) => match poses.iter().position(|p| p.position.is_some() == p.centre.is_some()) {
            Some(i) => refuse(
                format!("grasps[{i}]"),
                "a pose needs `position`, the origin of the hand, or `centre`, the point midway between the pads, but \
                 not both\n`centre: (0, 0, 0)` places the origin of the object between the pads for any rotation of \
                 the hand",
            ),
            None => Ok(()),
        },
        Grasps::Antipodal(a) if a.tilt_deg.get() > 90.0 => {
            refuse("grasps.tilt_deg", format!("must be at most 90 degrees, found {}", shown(a.tilt_deg.get())))
        }
        Grasps::File(f) if !f.convention.is_right_angled() => refuse(
            "grasps.convention",
            "closing and approach are along the same axis\nthey must be perpendicular, such as X and Z",
        ),
        _ => Ok(()),
    }
}

/// Checks fingers, motion of the object and levels of a quasi-static loading.
fn loading(scene: &Scene) -> Result<(), Problem> {
    if matches!(scene.loading, Loading::Dynamic(_)) {
        return Ok(());
    }
    if scene.gripper.fingers == Fingers::None {
        return refuse("gripper.fingers", "this loading needs fingers\nuse Both or One, or loading: Dynamic");
    }
    if scene.gripper.fingers == Fingers::One && scene.object.motion == ObjectMotion::Free {
        return refuse(
            "gripper.fingers",
            "one finger cannot hold a free object\nuse motion: Fixed in object, or fingers: Both",
        );
    }
    let press = match &scene.loading {
        Loading::Press(press) => press,
        Loading::Squeeze(s) if s.release.is_some_and(|release| release.get() > s.force.get()) => {
            let message =
                format!("the object would never be released\nallowed: at most force, {} N", shown(s.force.get()));
            return refuse("loading.release", message);
        }
        Loading::Squeeze(Squeeze { push: Some(_), .. }) if scene.object.motion == ObjectMotion::Fixed => {
            return refuse(
                "loading.push",
                "a push has no effect on a fixed object\nuse motion: Free in object, or leave it out",
            );
        }
        Loading::Squeeze(Squeeze { push: Some(push), .. })
            if push.force.dvec3() == DVec3::ZERO && push.torque.dvec3() == DVec3::ZERO =>
        {
            return refuse(
                "loading.push",
                "a push without force and torque\ngive `force` or `torque`, or leave it out",
            );
        }
        Loading::Squeeze(s) => match s.from.map(|f| f.get()) {
            Some(from) if from >= s.force.get() => {
                let message = format!(
                    "the first frame is at {} N, the last at {} N\nallowed: below force",
                    shown(from),
                    shown(s.force.get())
                );
                return refuse("loading.from", message);
            }
            _ => return Ok(()),
        },
        Loading::Dynamic(_) => return Ok(()),
    };
    match (&press.depth, &press.depths) {
        (None, None) => refuse("loading", "a press needs `depth` or `depths`"),
        (Some(_), Some(_)) => refuse("loading.depths", "depth and depths are both given\ngive one of them"),
        (None, Some(_)) if press.frames.is_some() => {
            refuse("loading.frames", "`depths` already defines the frames\nuse `depth` with `frames`")
        }
        (None, Some(depths)) if depths.is_empty() => refuse("loading.depths", "an empty list of depths"),
        (None, Some(depths)) if depths.len() > DEPTHS => {
            refuse("loading.depths", format!("{} depths\nallowed: at most {DEPTHS}", depths.len()))
        }
        (None, Some(depths)) => match depths.windows(2).position(|w| w[1].get() <= w[0].get()) {
            Some(i) => refuse(format!("loading.depths[{}]", i + 1), "depths must increase"),
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
    refuse("loading", format!("a press of {} m is longer than the finger's stroke ({} m)", shown(last), shown(stroke)))
}

/// Checks the fields that a dynamic loading excludes and those that require it.
fn dynamic(scene: &Scene) -> Result<(), Problem> {
    let Loading::Dynamic(dynamic) = &scene.loading else {
        let moving = [
            ("ground", scene.ground.is_some()),
            ("object.velocity", scene.object.velocity.is_some()),
            ("object.spin", scene.object.spin.is_some()),
        ];
        if let Some((path, _)) = moving.into_iter().find(|(_, given)| *given) {
            return refuse(path, "only a dynamic scene has this field\nuse loading: Dynamic(motions: [...])");
        }
        return Ok(());
    };
    if let StepperChoice::Fem(Fem { solver: Solver::Condensed(_), .. }) = scene.stepper {
        return refuse("stepper.solver", "condensed pads have no inertia\nuse solver: Full in a dynamic scene");
    }
    let moves = scene.object.velocity.is_some() || scene.object.spin.is_some();
    if moves && scene.object.motion == ObjectMotion::Fixed {
        return refuse("object.motion", "a fixed object has neither velocity nor spin");
    }
    if dynamic.motions.is_empty() {
        return refuse("loading.motions", "an empty list of motions\nHold(duration: 0.5) waits for half a second");
    }
    let no_gravity = scene.gravity.is_none_or(|g| g.dvec3() == glam::DVec3::ZERO);
    for (i, motion) in dynamic.motions.iter().enumerate() {
        if motion.play().duration() == 0.0 {
            return refuse(format!("loading.motions[{i}]"), "repeats an empty list of motions");
        }
        if motion.play().needs_gravity() && no_gravity {
            let message = "a lift needs gravity, and the scene has none\nset gravity, or use Move(by: (x, y, z), ...)";
            return refuse(format!("loading.motions[{i}]"), message);
        }
    }
    if scene.gripper.fingers == Fingers::None && !motion::squeezes(&dynamic.motions).is_empty() {
        return refuse("loading.motions", "this motion needs fingers\nuse fingers: Both in gripper");
    }
    Ok(())
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
