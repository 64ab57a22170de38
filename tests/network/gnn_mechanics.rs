//! Mechanics underlying the network: rigid equilibrium, linear pad response, projected contact, force balance.

use glam::{DQuat, DVec3};
use std::sync::{Arc, LazyLock};
use tactus::base::random::Random;
use tactus::geometry::Pose;
use tactus::geometry::Wrench;
use tactus::model::Model;
use tactus::model::grasp::grasp_poses;
use tactus::model::part::FingerModel;
use tactus::net::features::GraspFeatures;
use tactus::net::linear_response::GraspLoad;
use tactus::net::linear_response::contact_point::ContactPoint;
use tactus::net::linear_response::first_contact::GeometricContact;
use tactus::net::linear_response::pad_graph::{Layout, PadGraph};
use tactus::net::linear_response::projected_gradient::{ContactNode, projected_contact};
use tactus::scene::from_ron;

const SCENE: &str = r#"Scene(
    object: (shape: Ellipsoid(radii: (0.02, 0.025, 0.03))),
    gripper: (pads: GelSightMini(spacing: 6e-3)),
    grasps: List([(position: (0, 0, -0.1))]),
    loading: Squeeze(force: 8.0, frames: 2),
)"#;

/// Model of [`SCENE`] and graph of its pads, shared by tests.
static MADE: LazyLock<(Arc<Model>, Arc<PadGraph>)> = LazyLock::new(|| {
    let model = Model::build(&from_ron(SCENE).unwrap()).unwrap();
    let graph = Arc::new(graph(&model));
    (model, graph)
});

fn graph(model: &Model) -> PadGraph {
    PadGraph::new(&model.fingers[0], Layout::Face { depths: 3 }).unwrap()
}

/// Returns the features of a rotated, off-centre grasp without any symmetry, of a model with the pads of [`SCENE`].
fn features(model: &Arc<Model>) -> GraspFeatures {
    let turn = DQuat::from_scaled_axis(DVec3::new(0.1, 0.2, 0.15));
    let pose = Pose { position: turn * DVec3::new(0.0, 0.003, -0.102), rotation: turn };
    GraspFeatures::new(model, &MADE.1, &GeometricContact::find(model, pose).unwrap())
}

#[test]
fn the_grip_carries_the_force_of_each_finger_and_holds_the_object_still() {
    let model = &MADE.0;
    let features = features(model);
    let (equilibrium, basis) = (&features.equilibrium, &features.graph.basis);
    for force in [0.03, 0.1, 0.5] {
        let rest = equilibrium.equilibrium(&force.into());
        let (mut sum, mut torque) = (DVec3::ZERO, DVec3::ZERO);
        for (p, finger) in model.fingers.iter().enumerate() {
            let turn = finger.placement.rotation;
            let mut carried = 0.0;
            for ((x, u), push) in basis.centers.iter().zip(&rest.displacement[p]).zip(&rest.force[p]) {
                let push = turn * *push;
                carried -= push.dot(finger.placement.closing);
                (sum, torque) =
                    (sum + push, torque + (equilibrium.hand_position(p, *x, *u, &rest) - rest.translation).cross(push));
            }
            torque += finger.placement.closing * rest.twist[p];
            assert!((carried - force).abs() < 1e-2 * force, "a finger closed by {force} E t2 is held by {carried}");
        }
        assert!(sum.length() < 1e-2 * force, "the object feels {sum} E t2 in all, closed by {force}");
        // The lever arms are those of the previous step.
        assert!(torque.length() < 5e-2 * force, "the object is turned by {torque} E t3, closed by {force}");
        assert!(rest.rotation.to_scaled_axis().length() > 0.0, "an oblique grasp turns the object");
        assert!(rest.travel[0] == rest.travel[1], "fingers around a free object are geared");
    }
}

/// A held object does not move: its support carries the difference of the two finger forces, whose sum is the applied
/// force to 1 % of one finger's.
#[test]
fn an_object_that_is_held_stays_where_it_is() {
    let model = &MADE.0;
    let features = features(model);
    let force = 0.01;
    let rest = features.equilibrium.equilibrium(&force.into());
    let pressed = |(p, finger): (usize, &FingerModel)| -> f64 {
        let closing = finger.placement.rotation.transpose() * finger.placement.closing;
        rest.force[p].iter().map(|push| -push.dot(closing)).sum()
    };
    let both: f64 = model.fingers.iter().enumerate().map(pressed).sum();
    assert!((both - 2.0 * force).abs() < 1e-2 * force, "two fingers closed by {force} E t2 press with {both}");
    assert!(
        rest.translation == DVec3::ZERO && rest.rotation == DQuat::IDENTITY,
        "{} {}",
        rest.translation,
        rest.rotation
    );
}

/// A block held askew by 12 degrees and released under load rotates back: by 9.05 degrees with condensed finite
/// elements (`tactus run --backend condensed` with this scene), and to within 1 degree of that with linear pads.
#[test]
fn a_block_that_is_let_go_under_load_turns_between_the_pads() {
    let scene = r#"Scene(
        object: (shape: Cuboid(size: (0.03, 0.04, 0.06), edge_radius: 0.005)),
        gripper: (pads: GelSightMini(spacing: 4e-3), friction: 0.8),
        grasps: List([(position: (0, 0, -0.1))]),
        loading: Squeeze(force: 15.0, release: 9.0, frames: 5),
    )"#;
    let model = Model::build(&from_ron(scene).unwrap()).unwrap();
    let turn = DQuat::from_rotation_y(12_f64.to_radians());
    let pose = Pose { position: turn * DVec3::new(0.0, 0.0, -0.1), rotation: turn };
    let graph = Arc::new(graph(&model));
    let features = GraspFeatures::new(&model, &graph, &GeometricContact::find(&model, pose).unwrap());
    let turned = |force: f64| {
        let rest = features.equilibrium.equilibrium(&(0.5 * force / features.unit_force()).into());
        rest.rotation.to_scaled_axis().length().to_degrees()
    };
    assert!(turned(8.0) < 1e-9, "held: {} degrees", turned(8.0));
    assert!((turned(15.0) - 9.05).abs() < 1.0, "let go: {} degrees", turned(15.0));
}

/// Capsules released askew tilt between the pads but hardly spin about the closing direction: rotations agree to a
/// third, spins to 0.5 degrees, with condensed finite elements (`tactus run --backend condensed` with this scene).
#[test]
fn friction_within_a_small_contact_resists_spinning() {
    let scene = r#"Scene(
        object: (shape: Capsule(radius: 0.018, height: 0.04)),
        gripper: (pads: GelSightMini(spacing: 2.6e-3), friction: 0.8),
        grasps: Antipodal(count: 11, seed: 5),
        loading: Squeeze(force: 3.0, frames: 1),
    )"#;
    let scene = from_ron(scene).unwrap();
    let (model, poses) = (Model::build(&scene).unwrap(), grasp_poses(&scene).unwrap());
    let graph = Arc::new(graph(&model));
    for (grasp, turned) in [(1, [-0.159, -0.432, -2.902]), (9, [0.190, -0.278, 4.976]), (10, [-0.229, -0.261, 2.914])] {
        let features = GraspFeatures::new(&model, &graph, &GeometricContact::find(&model, poses[grasp]).unwrap());
        let rest = features.equilibrium.equilibrium(&(1.5 / features.unit_force()).into());
        let off = rest.rotation.to_scaled_axis() * 1_f64.to_degrees() - DVec3::from_array(turned);
        assert!(off.x.abs() < 0.5, "grasp {grasp} spins by {} degrees more than it should", off.x);
        let all = DVec3::from_array(turned).length();
        assert!(off.length() < all / 3.0, "grasp {grasp} turns otherwise by {} of {all} degrees", off.length());
    }
}

/// For any predicted pressure, friction balances the object and its weight to 1e-4 of the force, and the pressure keeps
/// its bits. Below half of the force, 2 N per finger, the heavy object is still held and friction is unchanged.
#[test]
fn friction_takes_up_what_pressure_leaves_over() {
    let heavy =
        SCENE.replace("0.03)))", "0.03)), density: 2000.0)").replace("loading", "gravity: (1.0, 2.0, -9.0), loading");
    for scene in [SCENE, heavy.as_str()] {
        let model = Model::build(&from_ron(scene).unwrap()).unwrap();
        let features = features(&model);
        let loads = features.loads(&[0.5, 2.0, 4.0].map(GraspLoad::from));
        assert_eq!(loads.held, [scene != SCENE, false, false]);
        let face = features.graph.face.len();
        for (level, balance) in loads.balance.iter().enumerate() {
            let mut random = Random::new(1);
            let mut contact: Vec<f64> = (0..6 * face).map(|_| random.uniform() / face as f64).collect();
            for pad in contact.chunks_exact_mut(3 * face) {
                let whole: f64 = pad.iter().step_by(3).sum();
                pad.iter_mut().step_by(3).for_each(|c| *c /= whole);
            }
            let before = contact.clone();
            balance.balance(&mut contact, [1.0; 2]);
            if loads.held[level] {
                assert_eq!(before, contact, "the support carries what the pads leave over");
                continue;
            }
            let pressure = |c: &[f64]| c.iter().step_by(3).copied().collect::<Vec<_>>();
            assert_eq!(pressure(&before), pressure(&contact));
            let (mut sum, mut moment) = (DVec3::ZERO, DVec3::ZERO);
            for (i, c) in contact.as_chunks::<3>().0.iter().enumerate() {
                for (w, c) in balance.wrenches(i).map(|w| w.map(f64::from)).iter().zip(c) {
                    sum += DVec3::new(w[0], w[1], w[2]) * *c;
                    moment += DVec3::new(w[3], w[4], w[5]) * *c;
                }
            }
            let (load, force) = (loads.load[level], loads.load[level].force);
            let Wrench { force: weight, torque } =
                features.equilibrium.load_about_midpoint(&features.equilibrium.equilibrium(&load), &load);
            assert_eq!(weight != DVec3::ZERO, scene != SCENE);
            assert!((sum - weight).length() < 1e-4 * force, "the pads carry {sum} E t2 of {weight}, closed by {force}");
            // Torsional friction about the closing axis is limited.
            let off = (moment - torque).reject_from(DVec3::X).length();
            assert!(off < 1e-4 * force, "the object is turned by {off} E t3, closed by {force}");
        }
        assert_eq!(loads.balance.len(), 3);
    }
}

#[test]
fn hats_share_out_their_force_and_give_alike_to_each_other() {
    let graph = &MADE.1;
    let basis = &graph.basis;
    assert!(basis.count() < graph.face.len(), "basis stand on corners, not in the middle of edges");
    for part in &basis.node_weights {
        assert!((part.iter().map(|p| p.1).sum::<f64>() - 1.0).abs() < 1e-12, "a function spreads all of its force");
    }
    let forces: Vec<DVec3> = graph.rest.iter().map(|x| DVec3::new(x.x, 1e-3, -x.y)).collect();
    let [nodes, corners] = [&forces, &basis.corner_forces(&forces)].map(|all| all.iter().sum::<DVec3>());
    assert!(nodes.distance(corners) < 1e-12, "corners carry {corners} N of {nodes} N");
    for (a, b) in [(0, 1), (0, basis.count() / 2), (basis.count() / 3, basis.count() - 1)] {
        for (k, c) in [(0, 0), (2, 2), (0, 2), (1, 2)] {
            let (there, back) = (basis.row(a, k)[3 * b + c], basis.row(b, c)[3 * a + k]);
            // Reciprocity theorem of Betti (1872).
            assert_eq!(there.to_bits(), back.to_bits(), "basis {a} and {b}: {there} and {back} t per E t2");
        }
    }
}

/// Under uniform pressure the work of the basis functions equals that of the linear response to 1e-4; a single basis
/// function is more compliant by over 10 %.
#[test]
fn basis_functions_that_press_evenly_give_as_the_response_does() {
    for (element, (_, graph)) in ["Linear", "Quadratic"].into_iter().zip(&*BOXES) {
        let basis = &graph.basis;
        // Force of each function under uniform pressure, from half of the area of its first node and its weight there.
        let even: Vec<DVec3> = basis
            .node_weights
            .iter()
            .map(|part| DVec3::Z * (0.5 * graph.area[part[0].0 as usize] / part[0].1))
            .collect();
        let mut alone = vec![DVec3::ZERO; basis.count()];
        let middle = basis.count() / 2;
        alone[middle] = even[middle];
        // Work of the forces in the basis relative to that in the response itself, minus one; the work does not depend
        // on the skew part.
        let softer = |forces: &[DVec3]| {
            let nodes = graph
                .compliance
                .face_displacements(&graph.face, &[basis.face_forces(forces, graph.face.len())])
                .remove(0);
            let mean = |part: &Vec<(u32, f64)>| part.iter().map(|(i, w)| nodes[*i as usize] * *w).sum::<DVec3>();
            let work = |moved: &[DVec3]| forces.iter().zip(moved).map(|(f, u)| f.dot(*u)).sum::<f64>();
            work(&basis.displacements(forces)) / work(&basis.node_weights.iter().map(mean).collect::<Vec<_>>()) - 1.0
        };
        assert!(softer(&even).abs() < 1e-4, "{element}: softer by {} under an even pressure", softer(&even));
        assert!(softer(&alone) > 0.1, "{element}: softer by {} under one function", softer(&alone));
    }
}

#[test]
fn the_linear_response_is_in_equilibrium_with_its_force() {
    // For 4-node tetrahedra the response is computed on the same mesh.
    let (model, graph) = &BOXES[0];
    let finger = &model.fingers[0];
    let (body, thickness) = (&finger.body, graph.thickness);
    let compliance = &graph.compliance;
    let unit = body.material.moduli().young * thickness * thickness;
    let small = 1e-5;
    for component in [0, 1, 2] {
        let row = 3 * (graph.face.len() / 2) + component;
        let at = |r: usize| f64::from(compliance.response[r * compliance.forces + row]);
        let given = |slot: u32| DVec3::from_array([0, 1, 2].map(|c| at(3 * slot as usize + c)));
        let turn = finger.placement.rotation;
        let moved = body
            .rest
            .iter()
            .zip(&compliance.slot)
            .map(|(x, slot)| *x + turn * slot.map_or(DVec3::ZERO, given) * (small * thickness));
        let mut gradient = vec![DVec3::ZERO; body.rest.len()];
        body.add_gradient(&moved.collect::<Vec<_>>(), &mut gradient);
        let on_face = |i: usize| graph.face.binary_search(&(i as u32)).is_ok();
        let (mut sum, mut elsewhere) = (DVec3::ZERO, 0.0_f64);
        for (i, g) in gradient.iter().enumerate().filter(|(i, _)| !body.fixed[*i]) {
            if on_face(i) { sum += *g } else { elsewhere = elsewhere.max(g.length()) }
        }
        let force = turn.col(component) * (small * unit);
        assert!(sum.distance(force) < 1e-3 * force.length(), "{sum} N against {force} N");
        assert!(elsewhere < 1e-3 * force.length(), "{elsewhere} N where nothing pushes");
    }
}

/// Models with box pads of 4-node and of 10-node tetrahedra, and graphs of their pads, shared by tests.
static BOXES: LazyLock<[(Arc<Model>, PadGraph); 2]> = LazyLock::new(|| {
    ["Linear", "Quadratic"].map(|element| {
        let scene = from_ron(&format!(
            "(object: (shape: Sphere(radius: 0.02)), loading: Squeeze(force: 4.0), stepper: Fem(element: {element}),
              gripper: (pads: Box(size: (0.016, 0.016, 0.004), spacing: 2e-3)))",
        ));
        let model = Model::build(&scene.unwrap()).unwrap();
        let graph = graph(&model);
        (model, graph)
    })
});

/// 4-node tetrahedra lock: the refined mesh of 10-node tetrahedra is 1 to 8 times as compliant under a nodal force.
#[test]
fn the_response_of_the_refined_pad_is_softer_under_its_force() {
    let [stiff, soft] = BOXES.each_ref().map(|(_, graph)| {
        let middle = |i: &usize| graph.rest[*i].length();
        let node = (0..graph.face.len()).min_by(|a, b| middle(a).total_cmp(&middle(b))).unwrap();
        [0, 1, 2].map(|axis| graph.compliance.row(graph.face[node], axis).unwrap()[3 * node + axis])
    });
    for (axis, (stiff, soft)) in stiff.into_iter().zip(soft).enumerate() {
        assert!((1.0..8.0).contains(&(soft / stiff)), "{} times as soft along axis {axis}", soft / stiff);
    }
}

/// Returns the contact of a ball pressed into the centre of a pad and dragged sideways, with a tangential force of
/// `slip` times Coulomb's limit.
fn dragged(graph: &PadGraph, slip: f64) -> Vec<ContactNode> {
    let t = graph.thickness;
    let touching = |(i, (at, area)): (usize, (&DVec3, &f64))| {
        let (x, area) = (*at / t, area / (t * t));
        let prescribed_depth = 0.2 - x.truncate().length_squared() / (2.0 * 5.0);
        let prescribed_sliding = if prescribed_depth > 0.0 { DVec3::X * 0.02 } else { DVec3::ZERO };
        let push = 2.0 * prescribed_depth.max(0.0);
        let force = (DVec3::NEG_Z * push + DVec3::X * FRICTION * slip * push) * area;
        ContactNode {
            point: ContactPoint::at_node(i as u32, *at, 1.0),
            normal: DVec3::NEG_Z,
            prescribed_depth,
            prescribed_sliding,
            force,
        }
    };
    graph.rest.iter().zip(&graph.area).enumerate().map(touching).collect()
}

const FRICTION: f64 = 0.8;

#[test]
fn projected_forces_push_only_and_keep_their_sum() {
    let graph = &MADE.1;
    let compliance = &graph.compliance;
    let face = dragged(graph, 0.1);
    let (forces, _) = projected_contact(compliance, &graph.face, std::slice::from_ref(&face), FRICTION).remove(0);
    let before: DVec3 = face.iter().map(|n| n.force).sum();
    let after: DVec3 = forces.iter().sum();
    assert!(before.distance(after) < 1e-6 * before.length(), "{before} became {after}, E t2");
    assert!(forces.iter().all(|f| f.z <= 0.0), "a pad never pulls");
    // Along the normal, nodes in contact conform to the object better than at the start.
    let lacks = |forces: &[DVec3]| {
        let u = compliance.face_displacements(&graph.face, &[forces.to_vec()]).remove(0);
        let touching: Vec<f64> =
            (0..face.len()).filter(|i| forces[*i].z < 0.0).map(|i| face[i].prescribed_depth + u[i].z).collect();
        let mean = touching.iter().sum::<f64>() / touching.len() as f64;
        (touching.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / touching.len() as f64).sqrt()
    };
    let start: Vec<DVec3> = face.iter().map(|n| n.force).collect();
    assert!(lacks(&forces) < 0.5 * lacks(&start), "{} of {} thicknesses", lacks(&forces), lacks(&start));
}

/// The iteration converges, also in full sliding and with inclined object normals: repetitions change the forces by
/// less than 0.3 %.
#[test]
fn projected_forces_converge_where_the_contact_slips() {
    let graph = &MADE.1;
    for (slip, lean) in [(0.5, 0.0), (1.2, 0.0), (0.5, 0.5), (1.2, 0.5)] {
        let mut face = dragged(graph, slip);
        for (node, x) in face.iter_mut().zip(&graph.rest) {
            node.normal = (node.normal + lean * x.truncate().extend(0.0) / graph.thickness).normalize();
        }
        let mut change = 0.0;
        for _ in 0..20 {
            let (forces, _) =
                projected_contact(&graph.compliance, &graph.face, std::slice::from_ref(&face), FRICTION).remove(0);
            let whole: f64 = face.iter().map(|node| node.force.length()).sum();
            change = face.iter().zip(&forces).map(|(node, f)| node.force.distance(*f)).sum::<f64>() / whole;
            face.iter_mut().zip(&forces).for_each(|(node, force)| node.force = *force);
        }
        assert!(change < 3e-3, "slip {slip}, lean {lean}: ten more steps change the forces by {change} of all");
    }
}

/// A flat face sinks in less the wider it is, and steadily, wherever its edges lie between the nodes: nine widths from 9.8
/// to 12.6 mm, a quarter of the distance of the nodes apart, change the depth by -7 to 3 % each, and by -10 to -25 %
/// together.
#[test]
fn a_flat_face_sinks_in_steadily_less_with_its_width() {
    let depth = |width: f64| {
        let scene = format!(
            "Scene(object: (shape: Cuboid(size: (0.03, {width}, 0.04))), gripper: (pads: GelSightMini(shape: Flat, spacing: 2.8e-3)),
             grasps: List([(position: (0, 0, -0.1))]), loading: Squeeze(force: 8.0, frames: 2))"
        );
        let model = Model::build(&from_ron(&scene).unwrap()).unwrap();
        static GRAPH: LazyLock<std::sync::Mutex<Option<Arc<PadGraph>>>> = LazyLock::new(Default::default);
        let graph = GRAPH.lock().unwrap().get_or_insert_with(|| Arc::new(graph(&model))).clone();
        let pose = grasp_poses(&from_ron(&scene).unwrap()).unwrap()[0];
        let features = GraspFeatures::new(&model, &graph, &GeometricContact::find(&model, pose).unwrap());
        let loads = features.loads(&[GraspLoad::from(4.0)]);
        let middle = (0..graph.rest.len()).min_by(|a, b| {
            let away = |i: &usize| graph.rest[*i].truncate().length();
            away(a).total_cmp(&away(b))
        });
        let columns = loads.node.len() / (2 * graph.face.len());
        -f64::from(loads.node[middle.unwrap() * columns + 11]) * loads.depth[0]
    };
    let depths: Vec<f64> = (0..9).map(|k| depth(9.8e-3 + 0.35e-3 * f64::from(k))).collect();
    for pair in depths.windows(2) {
        let change = pair[1] / pair[0] - 1.0;
        assert!((-0.07..0.03).contains(&change), "{change}: {depths:?} m");
    }
    assert!((-0.25..-0.1).contains(&(depths[8] / depths[0] - 1.0)), "{depths:?} m");
}
