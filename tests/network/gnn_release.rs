//! Frames before the release of a free object: the network holds the object fixed, as finite elements do.

use crate::keep::Keep;
use glam::DVec3;
use tactus::backend::choose;
use tactus::model::Model;
use tactus::model::grasp::grasp_poses;
use tactus::net::linear_response::first_contact::GeometricContact;
use tactus::record::{Frame, Status};
use tactus::scene::from_ron;
use tactus::world::run::run_grasps;

/// Returns the frames of a squeeze of a heavy ball (`density` in kg/m3) under `gravity` (m/s2) and the ball's position
/// at first contact. The pads carry its weight from half of the force on, the second of the three frames.
fn frames(density: f64, gravity: &str, stepper: &str) -> (Vec<Frame>, DVec3) {
    let scene = from_ron(&format!(
        "(object: (shape: Sphere(radius: 0.02), density: {density}), gravity: {gravity}, loading: Squeeze(force: 10, frames: 3),
          gripper: (pads: GelSightMini(spacing: 2.6e-3), opening: 0.14, stroke: 0.07, friction: 0.8), stepper: {stepper},
          record: (fields: [Displacement, ContactForce, ObjectPose]))"
    ))
    .unwrap();
    let (model, stepper) = (Model::build(&scene).unwrap(), choose(&scene).unwrap());
    let poses: Vec<_> = grasp_poses(&scene).unwrap().into_iter().enumerate().collect();
    let keep = Keep::default();
    let end = run_grasps(&model, stepper.as_ref(), &poses, 2, &keep).unwrap().remove(0).summary;
    assert_eq!((end.status, end.frames), (Status::Reached, 3), "{:?}", end.reason);
    (keep.0.into_inner().unwrap(), GeometricContact::find(&model, poses[0].1).unwrap().object.position)
}

/// Returns the relative difference of a field in the L2 norm.
fn apart(a: &Frame, b: &Frame, field: fn(&tactus::record::PadFrame) -> &Vec<DVec3>) -> f64 {
    let norm = |v: &mut dyn Iterator<Item = DVec3>| v.map(|v| v.length_squared()).sum::<f64>().sqrt();
    let pairs = || a.pads.iter().flat_map(field).zip(b.pads.iter().flat_map(field));
    norm(&mut pairs().map(|(a, b)| *a - *b)) / norm(&mut pairs().map(|(_, b)| *b))
}

/// Before the release the displacement is within 15 % of finite elements, the contact forces sum to zero within 2 % of
/// the applied force (the weight is half of it and more), and the object moves by less than 1 um.
#[test]
fn a_network_has_the_object_held_until_it_is_let_go() {
    let (truth, _) = frames(15000.0, "(9.81, 0, 0)", "Fem(solver: Condensed())");
    assert_eq!(truth.iter().map(|frame| frame.object_fixed).collect::<Vec<_>>(), [true, false, false]);
    for (density, gravity) in [(5000.0, "(9.81, 0, 0)"), (15000.0, "(9.81, 0, 0)"), (5000.0, "(0, 9.81, 0)")] {
        let (own, start) = frames(density, gravity, "Gnn(model: \"universe\")");
        let held = &own[0];
        assert!(held.object_fixed && !own[1].object_fixed && !own[2].object_fixed, "let go where finite elements do");
        assert!(
            held.object_position.distance(start) < 1e-6,
            "held, it moved by {} m",
            held.object_position.distance(start)
        );
        let off = apart(held, &truth[0], |pad| &pad.displacement);
        assert!(off < 0.15, "{density} kg/m3, {gravity}: displacement off by {off} before the release");
        let carried: DVec3 = held.pads.iter().map(|pad| pad.wrench.force).sum();
        assert!(carried.length() < 0.02 * held.applied_force, "the pads carry {carried} N of an object that is held");
        assert!(held.force_balance < 1e-5, "{} of the force is out of balance", held.force_balance);
        assert!(held.min_gap > -50e-6, "an overlap of {} m", -held.min_gap);
    }
}
