//! Valid mesh files: round trips are lossless, dialects are read, and real files have the counts of their sources.

use crate::skipped::data;
use std::fs;

use approx::assert_relative_eq;
use glam::DVec3;
use tactus::geometry::mesh::{TetMesh, grid, io, quality, surface, topology};
use tactus::geometry::shape::Shape;

fn corner_tet() -> TetMesh {
    TetMesh { nodes: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z], tets: vec![[0, 1, 2, 3]] }
}

#[test]
fn files_read_back_what_was_written() {
    let dir = tempfile::tempdir().expect("temporary folder");
    let line = [-1.0 / 3.0, 1e-9, 0.7];
    let mesh = grid::structured([&line, &line, &line]).expect("grid"); // digits that need all of an f64
    let path = dir.path().join("m.tet");
    io::write_tet(&path, &mesh).expect("written");
    assert_eq!(io::read_tet_mesh(&path).expect("read"), (mesh.clone(), vec![]));

    let hull = surface::boundary_mesh(&mesh).0;
    let path = dir.path().join("m.obj");
    io::write_obj(&path, &hull).expect("written");
    assert_eq!(io::read_tri_mesh(&path).expect("read"), (hull.clone(), vec![]));

    let path = dir.path().join("m.stl");
    io::write_stl(&path, &hull).expect("written");
    let (back, notices) = io::read_tri_mesh(&path).expect("read");
    assert!(notices.is_empty() && back.vertices.len() == hull.vertices.len(), "{notices:?}");
    for t in 0..hull.triangles.len() {
        for (p, q) in hull.corners(t).into_iter().zip(back.corners(t)) {
            assert!((p - q).length() < 1e-7, "f32 keeps 1e-7 m of a metre");
        }
    }
    assert_eq!(fs::read_dir(dir.path()).expect("folder").count(), 3, "no temporary files stay behind");
}

#[test]
fn polygons_negative_indices_and_binary_files_called_solid_are_read() {
    let dir = tempfile::tempdir().expect("temporary folder");
    let path = dir.path().join("q.obj");
    let text = "mtllib no.mtl\no a\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0 # c\nvt 0 0\ng b\nf -4/1 -3/1 -2/1 -1/1\n";
    fs::write(&path, text).expect("write");
    let (mesh, notices) = io::read_tri_mesh(&path).expect("read");
    assert_eq!((mesh.triangles, notices.len()), (vec![[0, 1, 2], [0, 2, 3]], 1));

    // Vertex weights and colours are ignored, groups are merged into one mesh, and coordinates keep double precision.
    let text = "g a\nv 0.1234567890123456 0 0 2\nv 1 0 0 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//9 2//9 3//9\n\
                g b\nusemtl m\nf 3/7 2/7 1/7\n";
    fs::write(&path, text).expect("write");
    let (mesh, notices) = io::read_tri_mesh(&path).expect("read");
    assert_eq!((mesh.triangles, notices.len()), (vec![[0, 1, 2], [2, 1, 0]], 0));
    assert_eq!(mesh.vertices[0].x, 0.123_456_789_012_345_6);

    let path = dir.path().join("s.stl");
    io::write_stl(&path, &surface::boundary_mesh(&corner_tet()).0).expect("written");
    let mut bytes = fs::read(&path).expect("read");
    bytes[..6].copy_from_slice(b"solid ");
    fs::write(&path, bytes).expect("write");
    assert_eq!(io::read_tri_mesh(&path).expect("read").0.triangles.len(), 4);
}

#[test]
fn sparse_tags_and_other_elements_of_gmsh_2_are_read() {
    let dir = tempfile::tempdir().expect("temporary folder");
    let path = dir.path().join("g.msh");
    let text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"gel pad\"\n$EndPhysicalNames\n$Nodes\n5\n\
                10 0 0 0\n7 1 0 0\n900 0 1 0\n3 0 0 1\n1 5 5 5\n$EndNodes\n$Elements\n2\n1 15 2 0 1 1\n\
                2 4 2 1 1 10 7 900 3\n$EndElements\n";
    fs::write(&path, text).expect("write");
    let (mesh, notices) = io::read_tet_mesh(&path).expect("read");
    assert_eq!(mesh, corner_tet());
    assert!(notices[0].contains("ignored elements 1 of type 15"), "{notices:?}");
    assert!(notices[1].contains("removed 1 node that"), "{notices:?}");
}

/// Node and tetrahedron counts are those stated by the sources of the files; the boundary is closed and encloses the
/// total volume of the elements to a relative 1e-10.
#[test]
fn real_tetrahedral_files() {
    let files = [
        ("pads/round_pad/round_pad.tet", 782, 2942),
        ("pads/biotac/int_ext_skin_combined_ftw.tet", 4246, 15410),
        ("pads/gelsight_mini_e430/tet.msh", 167, 430),
        ("pads/gelsight_mini_875/tet.msh", 340, 875),
        ("tet_format_samples/banana.mesh", 413, 1341),
        ("tet_format_samples/icosphere.tet", 162, 427),
        ("objects/dgn/sphere01/sphere01.tet", 1393, 6096),
        ("objects/dgn/lemon01/lemon01.tet", 1309, 5163),
    ];
    for (name, nodes, tets) in files {
        let Some(path) = data(name) else { continue };
        let (mesh, notices) = io::read_tet_mesh(&path).expect(name);
        let q = quality::quality(&mesh).expect("tets");
        eprintln!("{name}: worst {:.4}, mean {:.3}, notices {notices:?}", q.worst, q.mean);
        assert_eq!((mesh.nodes.len(), mesh.tets.len()), (nodes, tets), "{name}");
        assert!(q.min_volume > 0.0, "{name}");
        let report = topology::check_edges(&surface::boundary_mesh(&mesh).0);
        assert!(report.boundary.count == 0, "{name}: {report:?}");
        assert_relative_eq!(report.signed_volume, q.total_volume, max_relative = 1e-10);
    }
}

#[test]
fn real_surface_files_are_solids() {
    let files = [
        ("objects/dgn/sphere01/sphere01_processed.stl", 642, 1280),
        ("objects/dgn/lemon01/lemon01_processed.stl", 794, 1584),
        ("objects/dgn/annulus02/annulus02_processed.stl", 128, 256),
        ("objects/dgn/cup04/cup04_processed.stl", 234, 464),
        ("objects/dgn/cuboid02/cuboid02_processed.stl", 8, 12),
        ("indenters/sphere_7mm.obj", 292, 580),
        ("indenters/cube_14mm.obj", 120, 236),
        ("pads/round_pad/round_pad.obj", 42, 80),
    ];
    for (name, vertices, triangles) in files {
        let Some(path) = data(name) else { continue };
        let (mesh, notices) = io::read_tri_mesh(&path).expect(name);
        let report = topology::check_edges(&mesh);
        eprintln!("{name}: {} components, {notices:?}", report.components);
        assert!(report.is_solid(), "{name}: {report:?}");
        assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (vertices, triangles), "{name}");
    }
    if let Some(path) = data("objects/dgn/sphere01/sphere01_processed.stl") {
        // Diameter 20 mm; 1280 facets enclose up to 2 % less than the sphere.
        let m = Shape::from_mesh(io::read_tri_mesh(path).expect("read").0).expect("solid").mass;
        let sphere = 4.0 / 3.0 * std::f64::consts::PI * 0.01_f64.powi(3);
        assert!((0.98..1.0).contains(&(m.volume / sphere)), "{} m^3", m.volume);
        assert_relative_eq!(m.inertia.x_axis.x, 0.4 * m.volume * 1e-4, max_relative = 0.02);
    }
}
