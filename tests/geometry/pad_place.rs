//! Pads from files are placed in the pad frame with the correct nodes bonded.

use crate::skipped::data;
use std::fs;
use std::sync::Arc;

use glam::DVec3;
use tactus::geometry::mesh::{TetMesh, TriMesh, io};
use tactus::geometry::pad::{self, Bonding, PadMesh, PadPlacement, Resolution};
use tactus::geometry::shape::ShapeKind;

fn placement(outward: DVec3, attach_distance: f64) -> PadPlacement {
    PadPlacement { outward, across: None, bonding: Bonding::back(attach_distance) }
}

fn count(pad: &PadMesh) -> usize {
    pad.bonded.iter().filter(|b| **b).count()
}

fn small() -> PadMesh {
    pad::box_pad(0.03, 0.02, 0.004, &Resolution::cells([4, 2, 2])).expect("pad")
}

/// Placement inverts the export frame of the paper's data, pad (x, y, z) -> (x, z, -y) with the gel outwards along +y,
/// to 1e-15 m.
#[test]
fn a_pad_moved_elsewhere_comes_back() {
    let original = small();
    let moved = TetMesh {
        nodes: original.mesh.nodes.iter().map(|p| DVec3::new(p.x, p.z, -p.y) + DVec3::new(0.5, 1.0, -2.0)).collect(),
        tets: original.mesh.tets.clone(),
    };
    let back = pad::from_mesh(moved, &placement(DVec3::Y, 0.0)).expect("placed");
    assert_eq!(back.bonded, original.bonded);
    for (p, q) in back.mesh.nodes.iter().zip(&original.mesh.nodes) {
        assert!((*p - *q).length() < 1e-15, "{p} m instead of {q} m");
    }
}

#[test]
fn any_outward_direction_gives_a_right_handed_frame() {
    let original = small();
    for outward in [DVec3::X, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z, DVec3::new(0.6, 0.0, 0.8)] {
        let turn = glam::DQuat::from_rotation_arc(DVec3::Z, outward);
        let nodes = original.mesh.nodes.iter().map(|p| turn * *p).collect();
        let moved = TetMesh { nodes, tets: original.mesh.tets.clone() };
        let across = Some(turn * DVec3::X);
        let back = pad::from_mesh(moved, &PadPlacement { across, ..placement(outward, 1e-6) }).expect("placed");
        assert_eq!(back.bonded, original.bonded);
        for (p, q) in back.mesh.nodes.iter().zip(&original.mesh.nodes) {
            assert!((*p - *q).length() < 1e-14, "{outward}: {p} m instead of {q} m");
        }
    }
}

#[test]
fn unusable_placements_are_refused() {
    let message = |p: PadPlacement| pad::from_mesh(small().mesh, &p).expect_err("refused").to_string();
    assert!(message(placement(DVec3::Z, 1.0)).contains("all 45 nodes of the pad are bonded"));
    assert!(message(placement(DVec3::Z, f64::NAN)).contains("attach distance is NaN"));
    assert!(message(placement(DVec3::ZERO, 0.0)).contains("must be a unit vector"));
    assert!(message(placement(DVec3::NAN, 0.0)).contains("must be a unit vector"));
    let along = PadPlacement { across: Some(DVec3::Z), ..placement(DVec3::Z, 0.0) };
    assert!(message(along).contains("along outward"));
    let nodes = |list: Vec<usize>| PadPlacement { bonding: Bonding::Nodes(list), ..placement(DVec3::Z, 0.0) };
    assert!(message(nodes(vec![])).contains("no node of the pad is bonded"));
    assert!(message(nodes(vec![45])).contains("allowed: 0..=44"));
    assert!(message(nodes((30..45).collect())).contains("no free face of the pad faces along outward"));
    assert!(pad::from_mesh(TetMesh::default(), &placement(DVec3::Z, 0.0)).is_err());
}

/// Parts of a pad with rigid-body modes (not bonded, or hinged) and parts that overlap others, which would stiffen the
/// gel, are refused.
#[test]
fn every_part_of_a_pad_is_held_and_none_overlaps_another() {
    let pad = small();
    let with = |nodes: &[DVec3], tets: &[[u32; 4]]| {
        let mut mesh = pad.mesh.clone();
        mesh.nodes.extend(nodes);
        mesh.tets.extend(tets);
        mesh
    };
    let refused = |mesh: TetMesh, bonding: Bonding, says: &[&str]| {
        let placement = PadPlacement { bonding, ..placement(DVec3::Z, 0.0) };
        let message = pad::from_mesh(mesh, &placement).expect_err("refused").to_string();
        says.iter().for_each(|text| assert!(message.contains(text), "`{text}` is not in: {message}"));
    };
    let back = || Bonding::back(0.0);
    let n = pad.mesh.nodes.len() as u32;
    let millimetre = |i: usize| 1e-3 * DVec3::AXES[i];
    let corner = pad.mesh.nodes[n as usize - 1];
    let beside = [corner, corner + millimetre(0), corner + millimetre(1), corner + millimetre(2)];
    // A tetrahedron apart from the pad, one attached at a corner, and one attached along an edge.
    let loose = with(&beside.map(|p| p + 0.01), &[[n, n + 1, n + 2, n + 3]]);
    refused(loose, back(), &["a part of 1 tetrahedron of 97 about", "is not connected to the finger"]);
    let hung = with(&beside[1..], &[[n - 1, n, n + 1, n + 2]]);
    refused(hung, back(), &["a part of 1 tetrahedron of 97 about", "is held at one node"]);
    let hinged = with(&beside[2..], &[[n - 2, n - 1, n, n + 1]]);
    refused(hinged, back(), &["a part of 1 tetrahedron of 97 about", "is held along a line"]);
    // The pad itself bonded at one node, and at the five nodes of an edge of its back.
    refused(pad.mesh.clone(), Bonding::Nodes(vec![0]), &["the pad of 96 tetrahedra about", "is held at one node"]);
    refused(pad.mesh.clone(), Bonding::Nodes((0..5).collect()), &["is held along a line", "off that line"]);
    let three = PadPlacement { bonding: Bonding::Nodes(vec![0, 4, 10]), ..placement(DVec3::Z, 0.0) };
    assert_eq!(count(&pad::from_mesh(pad.mesh.clone(), &three).expect("held at three nodes")), 3);
    // A second copy of the pad, shifted or inside the first.
    let copies: [fn(DVec3) -> DVec3; 3] =
        [|p| p + DVec3::new(3e-3, 1e-3, 0.0), |p| 0.5 * p - 2e-3 * DVec3::Z, |p| 0.5 * p - 1e-3 * DVec3::Z];
    for copy in copies {
        let nodes: Vec<DVec3> = pad.mesh.nodes.iter().map(|p| copy(*p)).collect();
        let tets: Vec<[u32; 4]> = pad.mesh.tets.iter().map(|t| t.map(|i| i + n)).collect();
        let both = pad.bonded.iter().chain(&pad.bonded).enumerate().filter(|(_, b)| **b).map(|(i, _)| i).collect();
        refused(with(&nodes, &tets), Bonding::Nodes(both), &["the pad overlaps itself", "remove duplicates"]);
    }
}

/// A plane, the surface of the gel's carrier, and a list of nodes select the same bonded nodes.
#[test]
fn every_rule_bonds_the_back() {
    let pad = small();
    // An open plate 1 mm behind the back face at z = -4 mm.
    let corners = [(-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), (-0.1, 0.1)].map(|(x, y)| DVec3::new(x, y, -5e-3));
    let plate = Arc::new(TriMesh { vertices: corners.to_vec(), triangles: vec![[0, 1, 2], [0, 2, 3]] });
    // A closed slab around the whole pad.
    let slab =
        ShapeKind::Cuboid { size: DVec3::new(0.2, 0.2, 10e-3), edge_radius: 0.0 }.build(8).expect("slab").surface;
    let bonded = |bonding: Bonding| {
        pad::from_mesh(pad.mesh.clone(), &PadPlacement { bonding, ..placement(DVec3::Z, 0.0) }).map(|pad| pad.bonded)
    };
    let plane = |offset: f64, within: f64| Bonding::Plane { normal: Some(DVec3::NEG_Z), offset: Some(offset), within };
    let back: Vec<usize> = (0..45).filter(|i| pad.bonded[*i]).collect();
    for (name, rule) in [
        ("behind a plane", plane(3e-3, 0.0)),
        ("in front of a plane", plane(5e-3, 1e-3)),
        ("near an open surface", Bonding::Surface { surface: plate.clone(), within: 1e-3 }),
        ("listed", Bonding::Nodes(back)),
    ] {
        assert_eq!(bonded(rule).expect(name), pad.bonded, "{name}");
    }
    let message = |rule: Bonding| bonded(rule).expect_err("refused").to_string();
    let far = message(Bonding::Surface { surface: plate, within: 0.5e-3 });
    assert!(far.contains("the nearest of its 45 nodes is 0.001 m from the surface"), "{far}");
    let far = message(plane(6e-3, 0.0));
    assert!(far.contains("the nearest of its 45 nodes is 0.002 m from the plane"), "{far}");
    let inside = message(Bonding::Surface { surface: slab, within: 0.0 });
    assert!(inside.contains("all 45 nodes of the pad are bonded"), "{inside}");
}

#[test]
fn lists_of_nodes_are_indices_or_a_mask() {
    let dir = tempfile::tempdir().expect("temporary folder");
    let path = dir.path().join("list.txt");
    let read = |text: &str| {
        fs::write(&path, text).expect("write");
        pad::place::read_nodes(&path, 4).map_err(|e| e.to_string())
    };
    assert_eq!(read("# glued\n3 1\n"), Ok(vec![1, 3]));
    assert_eq!(read("1\n0\n0\n1\n"), Ok(vec![0, 3]));
    let message = |text: &str| read(text).expect_err("refused");
    assert!(message("0\n4\n").contains("line 2, column 1: node index 4, but the mesh has 4 nodes; allowed: 0..=3"));
    assert!(message("2 2\n").contains("line 1, column 3: node index 2 occurs twice"));
    assert!(message("x\n").contains("line 1, column 1: node index `x`"));
    assert!(message("").contains("the list of bonded nodes is empty"));
}

/// Node lists refer to the numbering of the file, also if repair removes or welds nodes.
#[test]
fn lists_survive_the_repair_of_the_mesh() {
    let dir = tempfile::tempdir().expect("temporary folder");
    let (mesh, list) = (dir.path().join("m.tet"), dir.path().join("l.txt"));
    fs::write(&mesh, "v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nt 1 2 3 4\n").expect("write");
    fs::write(&list, "0 1 2 3").expect("write");
    let (pad, notices) = pad::read_pad(&mesh, &placement(DVec3::Z, 0.0), Some(&list)).expect("pad");
    assert_eq!((pad.bonded, notices.len()), (vec![true, true, true, false], 2));
    assert!(notices[1].contains("the pad is 1 m long") && notices[1].contains("is it in mm?"), "{notices:?}");
    let listed = PadPlacement { bonding: Bonding::Nodes(vec![5]), ..placement(DVec3::Z, 0.0) };
    let message = pad::read_pad(&mesh, &listed, None).expect_err("refused").to_string();
    assert!(message.contains("bonded node index 5, but the mesh has 5 nodes; allowed: 0..=4"), "{message}");
    let message = pad::read_pad(&mesh, &placement(DVec3::Z, 7.0), None).expect_err("refused").to_string();
    assert!(message.contains("m.tet: all 4 nodes"), "{message}");
}

#[test]
fn real_pads() {
    if let (Some(mesh), Some(list)) =
        (data("pads/gelsight_mini_e430/tet.msh"), data("pads/gelsight_mini_e430/active.txt"))
    {
        let (pad, _) = pad::read_pad(&mesh, &placement(DVec3::Z, 0.0), Some(&list)).expect("pad");
        for (p, bonded) in pad.mesh.nodes.iter().zip(&pad.bonded) {
            assert!(p.z < 1e-9 && p.z > -4e-3 - 1e-9);
            assert_eq!(*bonded, p.z < -4e-3 + 1e-6, "the list glues the back face, 4 mm below the sensing face: {p} m");
        }
        let by_distance = pad::read_pad(&mesh, &placement(DVec3::Z, 1e-6), None).expect("pad").0;
        assert_eq!(by_distance.bonded, pad.bonded);
    }
    if let Some(mesh) = data("pads/round_pad/round_pad.tet") {
        let (pad, _) = pad::read_pad(&mesh, &placement(DVec3::Z, 1e-6), None).expect("pad");
        let low = pad.mesh.nodes.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = pad.mesh.nodes.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        eprintln!("round pad: {low} .. {high}, {} of {} glued", count(&pad), pad.bonded.len());
        assert!((low.z + 3e-3).abs() < 1e-9 && high.z == 0.0);
        assert!((low.x + high.x).abs() < 1e-9, "centred");
        // One node of this file, at mid-height of the side wall, is off by 18 um.
        assert!((low.y + high.y).abs() < 2e-5, "centred on the sensing face");
    }
    if let Some(mesh) = data("pads/biotac/int_ext_skin_combined_ftw.tet") {
        let (mesh, _) = io::read_tet_mesh(&mesh).expect("mesh");
        let pad = pad::from_mesh(mesh.clone(), &placement(DVec3::Z, 1e-3)).expect("pad");
        assert!(count(&pad) > 0 && !pad::sensing_faces(&pad).is_empty());
        // The fingertip faces -y and is bonded to a core 6 mm from its back: both rules select the same nodes.
        let back = mesh.nodes.iter().map(|p| p.y).fold(f64::NEG_INFINITY, f64::max);
        let mut core =
            (*ShapeKind::Cuboid { size: DVec3::splat(0.1), edge_radius: 0.0 }.build(8).expect("box").surface).clone();
        core.vertices.iter_mut().for_each(|p| p.y += back - 6e-3 + 0.05);
        let held = PadPlacement {
            bonding: Bonding::Surface { surface: Arc::new(core), within: 0.0 },
            ..placement(DVec3::NEG_Y, 0.0)
        };
        let [by_core, by_plane] =
            [held, placement(DVec3::NEG_Y, 6e-3)].map(|p| pad::from_mesh(mesh.clone(), &p).expect("pad"));
        assert_eq!(by_core.bonded, by_plane.bonded, "{} and {} nodes", count(&by_core), count(&by_plane));
    }
}
