//! The mesh files of the torture scenes are generated meshes with added defects. After a change of a generator,
//! regenerate them with `TACTUS_WRITE_MESHES=1 cargo test --release --test scenes torture_meshes::`.

use std::path::Path;
use tactus::geometry::mesh::io::{read_tet_mesh, read_tet_mesh_raw, write_tet};
use tactus::geometry::mesh::quality::quality;
use tactus::geometry::mesh::{TetMesh, grid};
use tactus::geometry::pad::{Resolution, box_pad};

const SIZE: [f64; 3] = [0.02525, 0.02075, 0.004];

/// A grid with one pair of lines 0.05 mm apart in each direction.
fn slivers() -> TetMesh {
    let across = |n: usize, size: f64| -> Vec<f64> {
        let line = |i: usize| size * (i as f64 / n as f64 - 0.5);
        (0..=n).flat_map(|i| if i == n / 2 { vec![line(i), line(i) + 5e-5] } else { vec![line(i)] }).collect()
    };
    let depth = [-SIZE[2], -0.5 * SIZE[2], -0.5 * SIZE[2] + 5e-5, 0.0];
    grid::structured([&across(6, SIZE[0]), &across(5, SIZE[1]), &depth]).unwrap()
}

fn plain() -> TetMesh {
    box_pad(SIZE[0], SIZE[1], SIZE[2], &Resolution::cells([6, 5, 2])).unwrap().mesh
}

fn wrong_winding() -> TetMesh {
    let mut mesh = plain();
    mesh.tets.iter_mut().step_by(2).for_each(|t| t.swap(1, 2));
    mesh
}

fn duplicates() -> TetMesh {
    let mesh = plain();
    let nodes: Vec<_> = (0..mesh.tets.len()).flat_map(|t| mesh.corners(t)).collect();
    let tets = (0..mesh.tets.len() as u32).map(|t| [0, 1, 2, 3].map(|k| 4 * t + k)).collect();
    TetMesh { nodes, tets }
}

#[test]
fn the_files_are_what_the_generators_make() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/torture/meshes");
    for (name, mesh) in [("slivers", slivers()), ("wrong_winding", wrong_winding()), ("duplicates", duplicates())] {
        let path = folder.join(name).with_extension("tet");
        if std::env::var_os("TACTUS_WRITE_MESHES").is_some() {
            write_tet(&path, &mesh).unwrap();
        }
        assert_eq!(read_tet_mesh_raw(&path).unwrap().0, mesh, "{name}");
        let (repaired, notices) = read_tet_mesh(&path).unwrap();
        match name {
            "slivers" => assert!(quality(&repaired).unwrap().worst < 0.1, "the worst tetrahedron is a sliver"),
            _ => {
                assert!(!notices.is_empty(), "{name}: the repair is told");
                assert_eq!(
                    (repaired.nodes.len(), repaired.tets.len()),
                    (plain().nodes.len(), plain().tets.len()),
                    "{name}"
                );
            }
        }
    }
}
