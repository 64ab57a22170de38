//! Structured grids, element quality, repair, topology, mass properties and mid-edge nodes of meshes.

use approx::assert_relative_eq;
use glam::DVec3;
use proptest::prelude::*;
use tactus::geometry::mesh::shells::{self, Oriented};
use tactus::geometry::mesh::{TetMesh, TriMesh, clean, grid, quadratic, quality, surface, topology};
use tactus::geometry::shape::Shape;

fn corner_tet() -> TetMesh {
    TetMesh { nodes: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z], tets: vec![[0, 1, 2, 3]] }
}

/// Returns a grid on a box of 2 x 3 x 1 m with the given numbers of cells, symmetric in x and y.
fn cells(nx: usize, ny: usize, nz: usize) -> TetMesh {
    let line =
        |n: usize, half: f64| -> Vec<f64> { (0..=n).map(|i| half * (2.0 * i as f64 - n as f64) / n as f64).collect() };
    let z: Vec<f64> = (0..=nz).map(|i| i as f64 / nz as f64).collect();
    grid::structured([&line(nx, 1.0), &line(ny, 1.5), &z]).expect("grid")
}

#[test]
fn a_grid_fills_its_box_with_positive_tetrahedra_and_a_closed_surface() {
    for (nx, ny, nz) in [(1, 1, 1), (2, 2, 2), (3, 2, 1), (4, 6, 3), (5, 5, 5)] {
        let mut mesh = cells(nx, ny, nz);
        let q = quality::quality(&mesh).expect("tets");
        assert!(q.min_volume > 0.0);
        assert_relative_eq!(q.total_volume, 6.0, max_relative = 1e-13);
        assert!(clean::repair(&mut mesh).expect("sound").is_empty(), "a grid needs no repair");
        // A mismatch of face diagonals between cells would leave interior faces on the boundary.
        assert_eq!(surface::boundary(&mesh).len(), 4 * (nx * ny + ny * nz + nz * nx));
        let report = topology::check_edges(&surface::boundary_mesh(&mesh).0);
        assert!(report.is_solid() && report.components == 1, "{report:?}");
        assert_relative_eq!(report.signed_volume, 6.0, max_relative = 1e-13);
    }
}

#[test]
fn an_even_grid_is_its_own_mirror_image() {
    let mesh = cells(4, 6, 3);
    let key = |sign: DVec3| {
        let mut all: Vec<[[i64; 3]; 4]> = (0..mesh.tets.len())
            .map(|t| {
                let mut c = mesh.corners(t).map(|p| (p * sign * 1e6).round().to_array().map(|x| x as i64));
                c.sort_unstable();
                c
            })
            .collect();
        all.sort_unstable();
        all
    };
    assert_eq!(key(DVec3::ONE), key(DVec3::new(-1.0, 1.0, 1.0)));
    assert_eq!(key(DVec3::ONE), key(DVec3::new(1.0, -1.0, 1.0)));
}

#[test]
fn bad_grids_are_refused() {
    let message = |l: [&[f64]; 3]| grid::structured(l).expect_err("refused").to_string();
    assert!(message([&[0.0], &[0.0, 1.0], &[0.0, 1.0]]).contains("at least 2 lines along x"));
    assert!(message([&[0.0, 1.0], &[1.0, 0.0], &[0.0, 1.0]]).contains("lines along y"));
    assert!(message([&[0.0, 1.0], &[0.0, 1.0], &[0.0, f64::NAN]]).contains("lines along z"));
    assert!(grid::check_cells([usize::MAX, 2, 2]).is_err());
}

#[test]
fn quality_is_one_for_a_regular_tetrahedron_and_zero_for_a_flat_one() {
    let regular = [[1.0, 1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0], [-1.0, -1.0, 1.0]].map(DVec3::from_array);
    assert_relative_eq!(quality::mean_ratio(regular).abs(), 1.0, max_relative = 1e-14);
    assert_eq!(quality::mean_ratio([DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.0)]), 0.0);
    // Corner tetrahedron: V = 1/6, squared edges 1+1+1+2+2+2.
    let corner = quality::quality(&corner_tet()).expect("tets");
    assert_relative_eq!(corner.worst, 12.0 * 0.5_f64.powf(2.0 / 3.0) / 9.0, max_relative = 1e-14);
    assert_eq!((corner.histogram[8], corner.min_edge, corner.max_edge), (1, 1.0, 2.0_f64.sqrt()));
    assert!(quality::quality(&TetMesh::default()).is_none());
}

#[test]
fn repair_tells_what_it_changed() {
    let mut mesh = corner_tet();
    mesh.nodes.extend([DVec3::new(0.0, -0.0, 0.0), DVec3::splat(9.0), DVec3::new(0.0, 0.0, -1.0)]);
    mesh.tets.push([4, 1, 2, 6]); // its first corner doubles node 0, and its volume is negative
    let fixed = clean::repair_mapped(&mut mesh).expect("repairable");
    assert_eq!(fixed.node_map, [Some(0), Some(1), Some(2), Some(3), Some(0), None, Some(4)]);
    assert_eq!((mesh.nodes.len(), mesh.tets[1]), (5, [0, 1, 4, 2]));
    let expected = ["welded 1 duplicate node (", "removed 1 node that", "reoriented 1 of 2 tetrahedra"];
    assert_eq!(fixed.notices.len(), 3);
    assert!(fixed.notices.iter().zip(expected).all(|(n, e)| n.starts_with(e)), "{:?}", fixed.notices);
    assert_eq!(surface::boundary(&mesh).len(), 6, "the two share the welded face");
    assert!(clean::repair(&mut mesh).expect("sound").is_empty(), "repairing twice changes nothing");
}

#[test]
fn boundary_faces_of_one_tetrahedron_look_outwards() {
    let mesh = corner_tet();
    for face in surface::boundary(&mesh) {
        let [a, b, c] = face.nodes.map(|i| mesh.nodes[i as usize]);
        assert!((b - a).cross(c - a).dot(a - DVec3::splat(0.25)) > 0.0);
    }
}

#[test]
fn quadratic_nodes_are_the_edge_middles_in_the_order_of_vtk() {
    let mesh = cells(2, 2, 2);
    let (ten, edges) = (quadratic::to_quadratic(&mesh), quadratic::midpoint_edges(&mesh));
    assert_eq!(ten.nodes.len(), 5_usize.pow(3), "27 grid points and all points half way");
    assert_eq!(ten.nodes.len(), mesh.nodes.len() + edges.len());
    assert_eq!(ten.nodes[..mesh.nodes.len()], mesh.nodes);
    for tet in &ten.tets {
        let p = tet.map(|i| ten.nodes[i as usize]);
        for (k, (a, b)) in [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)].into_iter().enumerate() {
            assert_eq!(p[4 + k], 0.5 * (p[a] + p[b]));
            let mut ends = [tet[a], tet[b]];
            ends.sort_unstable();
            assert_eq!(edges[tet[4 + k] as usize - mesh.nodes.len()], ends);
        }
    }
}

#[test]
fn mass_of_a_box_far_from_the_origin() {
    let (a, b, c) = (2.0, 3.0, 1.0);
    let mut hull = surface::boundary_mesh(&cells(2, 1, 3)).0;
    let shift = DVec3::new(10.0, -20.0, 5.0);
    hull.vertices.iter_mut().for_each(|p| *p += shift);
    let m = Shape::from_mesh(hull).expect("solid").mass;
    assert_relative_eq!(m.volume, a * b * c, max_relative = 1e-13);
    assert!((m.center - shift - DVec3::new(0.0, 0.0, 0.5)).length() < 1e-13, "{}", m.center);
    let expected = DVec3::new(b * b + c * c, a * a + c * c, a * a + b * b) * (a * b * c / 12.0);
    for (i, col) in [m.inertia.x_axis, m.inertia.y_axis, m.inertia.z_axis].into_iter().enumerate() {
        for j in 0..3 {
            let value = if i == j { expected[i] } else { 0.0 };
            assert!((col[j] - value).abs() < 1e-12, "inertia {i}{j}: {} m^5", col[j]);
        }
    }
}

#[test]
fn holes_fins_and_inside_out_surfaces_are_reported() {
    let solid = surface::boundary_mesh(&cells(1, 1, 1)).0;
    let mut open = solid.clone();
    open.triangles.pop();
    let report = topology::check_edges(&open);
    assert!(!report.is_solid() && report.boundary.count == 3 && report.boundary.first.is_some());
    let message = Shape::from_mesh(open).expect_err("open").to_string();
    assert!(message.contains("the surface is open: 3 edges with one triangle only, the first from ("), "{message}");

    let mut fin = solid.clone();
    fin.triangles.push(solid.triangles[0]);
    assert_eq!(topology::check_edges(&fin).non_manifold.count, 3);

    let mut one_turned = solid.clone();
    one_turned.triangles[0].swap(0, 1);
    assert!(
        topology::check_edges(&one_turned).defect_message().is_some_and(|c| c.contains("not oriented consistently"))
    );

    let mut inside_out = solid.clone();
    inside_out.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    assert!(topology::check_edges(&inside_out).defect_message().is_some_and(|c| c.contains("inside out")));
    assert_eq!(shells::orient(&mut inside_out), Oriented { outward: 1, inward: 0 });
    assert!(topology::check_edges(&inside_out).is_solid());
    assert!(!shells::orient(&mut inside_out).any());

    let mut two = solid.clone();
    two.vertices.extend(solid.vertices.iter().map(|p| *p + 9.0 * DVec3::X));
    two.triangles.extend(solid.triangles.iter().map(|t| t.map(|i| i + solid.vertices.len() as u32)));
    assert_eq!(topology::check_edges(&two).components, 2);
    assert!(topology::check_edges(&TriMesh::default()).defect_message().is_some());
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// Repair of arbitrary meshes does not panic, and accepted meshes have positive volumes and valid indices.
    #[test]
    fn repair_never_panics(
        nodes in prop::collection::vec(prop::array::uniform3(-2_i8..3), 0..12),
        tets in prop::collection::vec(prop::array::uniform4(0_u32..13), 0..6),
    ) {
        let nodes = nodes.into_iter().map(|p| DVec3::from_array(p.map(f64::from))).collect();
        let mut mesh = TetMesh { nodes, tets };
        if clean::repair(&mut mesh).is_ok() {
            prop_assert!(quality::volumes(&mesh).iter().all(|v| *v > 0.0));
            prop_assert!(clean::check_indices(&mesh).is_ok());
            prop_assert_eq!(clean::repair(&mut mesh).expect("sound"), Vec::<String>::new());
        }
    }
}
