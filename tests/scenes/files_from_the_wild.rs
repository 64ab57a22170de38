//! Tetrahedral meshes and grasp files as other programs write them are read correctly, or refused with a remedy.

use crate::skipped::skipped;
use glam::{DMat3, DQuat, DVec3};
use hdf5_pure::FileBuilder;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::mpsc;
use std::time::Duration;
use tactus::base::random::Random;
use tactus::geometry::Pose;
use tactus::geometry::mesh::{TetMesh, io, quadratic, signed_volume};
use tactus::geometry::pad::{Resolution, box_pad};
use tactus::model::Model;
use tactus::model::grasp::{grasp_poses, read_grasps_h5, write_grasps_h5};
use tactus::net::network::card::StoredModel;
use tactus::scene::{Convention, HandAxis, QuaternionOrder, load};

/// Size of the block of gel in all mesh files, m.
const SIZE: [f64; 3] = [0.02, 0.016, 0.004];
/// Time limit of a reader, longer than any of them takes.
const HANG: Duration = Duration::from_secs(20);

/// The block: 4 x 4 x 2 cells of six tetrahedra.
fn block() -> TetMesh {
    box_pad(SIZE[0], SIZE[1], SIZE[2], &Resolution::cells([4, 4, 2])).unwrap().mesh
}

/// Asserts that `mesh` is the block: its numbers of nodes and tetrahedra, its volume to a relative 1e-12, its nodes to
/// 1e-9 m.
#[track_caller]
fn is_block(mesh: &TetMesh) {
    let whole = block();
    assert_eq!((mesh.nodes.len(), mesh.tets.len()), (whole.nodes.len(), whole.tets.len()), "nodes and tetrahedra");
    let volume: f64 = (0..mesh.tets.len()).map(|t| signed_volume(mesh.corners(t))).sum();
    let expected: f64 = SIZE.iter().product();
    assert!((volume / expected - 1.0).abs() < 1e-12, "volume {volume} m3, expected {expected} m3");
    for (a, b) in mesh.nodes.iter().zip(&whole.nodes) {
        assert!((*a - *b).length() < 1e-9, "{a} is not {b}");
    }
}

/// Writes `bytes` under `name` and reads them as a tetrahedral mesh.
fn read(name: &str, bytes: &[u8]) -> Result<(TetMesh, Vec<String>), String> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    io::read_tet_mesh(&path).map_err(|e| e.to_string())
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    Text,
    Little,
    Big,
}

/// Writer of a gmsh file: form, and the bytes written so far.
struct Out(Form, Vec<u8>);

impl Out {
    fn text(&mut self, text: &str) {
        self.1.extend(text.as_bytes());
    }
    fn word(&mut self, text: String, little: &[u8]) {
        match self.0 {
            Form::Text => self.text(&format!("{text} ")),
            Form::Little => self.1.extend(little),
            Form::Big => self.1.extend(little.iter().rev()),
        }
    }
    fn int(&mut self, v: usize) {
        self.word(v.to_string(), &(v as i32).to_le_bytes());
    }
    fn size(&mut self, v: usize) {
        self.word(v.to_string(), &(v as u64).to_le_bytes());
    }
    fn real(&mut self, v: f64) {
        self.word(format!("{v:.17e}"), &v.to_le_bytes());
    }
    fn point(&mut self, p: DVec3) {
        p.to_array().into_iter().for_each(|x| self.real(x));
    }
    /// Ends a line in a text file; writes nothing in a binary one.
    fn end(&mut self) {
        if self.0 == Form::Text {
            self.text("\n");
        }
    }
}

/// A gmsh file: sections that the reader skips, the nodes, a triangle, which it ignores, and tetrahedra of 4 or 10
/// nodes. Node tags are 10, 13, 16 ...
fn gmsh(version: &str, form: Form, nodes: &[DVec3], cells: &[Vec<u32>]) -> Vec<u8> {
    let tag = |i: usize| 10 + 3 * i;
    let kind = if cells[0].len() == 10 { 11 } else { 4 };
    let (v2, v41) = (version.starts_with('2'), version == "4.1");
    let mut o = Out(form, Vec::new());
    o.text(&format!("$MeshFormat\n{version} {} 8\n", i32::from(form != Form::Text)));
    if form != Form::Text {
        o.int(1);
        o.text("\n");
    }
    o.text("$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"gel\"\n$EndPhysicalNames\n");
    if !v2 {
        // Skipped by the reader; in a binary file its bytes include line feeds and `$`.
        o.text("$Entities\n");
        (0..40).for_each(|k| o.int(if form == Form::Text { k } else { 0x0a24_0a00 + k }));
        o.end();
        o.text("\n$EndEntities\n");
    }
    let size = |o: &mut Out, v| if v41 { o.size(v) } else { o.int(v) };
    o.text("$Nodes\n");
    if v2 {
        o.text(&format!("{}\n", nodes.len()));
        for (i, p) in nodes.iter().enumerate() {
            o.int(tag(i));
            o.point(*p);
            o.end();
        }
    } else {
        // Two blocks: one on a surface without parameters, one on a curve with one for each node.
        o.size(2);
        o.size(nodes.len());
        if v41 {
            o.size(tag(0));
            o.size(tag(nodes.len() - 1));
        }
        o.end();
        for (dim, range) in [(2, 0..5), (1, 5..nodes.len())] {
            let parametric = dim == 1;
            if v41 {
                o.int(dim);
                o.int(7);
            } else {
                o.int(7);
                o.int(dim);
            }
            o.int(usize::from(parametric));
            o.size(range.len());
            o.end();
            if v41 {
                for i in range.clone() {
                    o.size(tag(i));
                    o.end();
                }
            }
            for i in range {
                if !v41 {
                    o.int(tag(i));
                }
                o.point(nodes[i]);
                if parametric {
                    o.real(0.5);
                }
                o.end();
            }
        }
    }
    o.text(if form == Form::Text { "$EndNodes\n$Elements\n" } else { "\n$EndNodes\n$Elements\n" });
    let triangle = vec![0, 1, 2];
    let groups = [(2, std::slice::from_ref(&triangle)), (kind, cells)];
    let mut id = 1;
    if v2 {
        o.text(&format!("{}\n", cells.len() + 1));
    } else {
        o.size(2);
        o.size(cells.len() + 1);
        if v41 {
            o.size(1);
            o.size(cells.len() + 1);
        }
        o.end();
    }
    for (kind, group) in groups {
        if v2 && form != Form::Text {
            [kind, group.len(), 2].into_iter().for_each(|v| o.int(v));
        } else if !v2 {
            [3, 1, kind].into_iter().for_each(|v| o.int(v));
            o.size(group.len());
            o.end();
        }
        for cell in group {
            size(&mut o, id);
            id += 1;
            if v2 {
                if form == Form::Text {
                    [kind, 2].into_iter().for_each(|v| o.int(v));
                }
                [1, 1].into_iter().for_each(|v| o.int(v));
            }
            cell.iter().for_each(|n| size(&mut o, tag(*n as usize)));
            o.end();
        }
    }
    o.text(if form == Form::Text { "$EndElements\n" } else { "\n$EndElements\n" });
    o.1
}

/// The tetrahedra of the block as lists of nodes.
fn linear() -> (Vec<DVec3>, Vec<Vec<u32>>) {
    let mesh = block();
    (mesh.nodes, mesh.tets.iter().map(|t| t.to_vec()).collect())
}

/// The block with mid-edge nodes, in the order of gmsh: the last two nodes are swapped.
fn with_middles() -> (Vec<DVec3>, Vec<Vec<u32>>) {
    let ten = quadratic::to_quadratic(&block());
    let gmsh = |t: &[u32; 10]| {
        let mut t = t.to_vec();
        t.swap(8, 9);
        t
    };
    (ten.nodes, ten.tets.iter().map(gmsh).collect())
}

const FORMS: [(&str, Form); 9] = [
    ("2.2", Form::Text),
    ("2.2", Form::Little),
    ("2.2", Form::Big),
    ("4", Form::Text),
    ("4", Form::Little),
    ("4", Form::Big),
    ("4.1", Form::Text),
    ("4.1", Form::Little),
    ("4.1", Form::Big),
];

#[test]
fn gmsh_files_of_every_version_and_form_hold_the_same_block() {
    for (version, form) in FORMS {
        for second_order in [false, true] {
            let (nodes, cells) = if second_order { with_middles() } else { linear() };
            let (mesh, notices) = read("a.msh", &gmsh(version, form, &nodes, &cells))
                .unwrap_or_else(|e| panic!("gmsh {version} {form:?} of second order {second_order}: {e}"));
            is_block(&mesh);
            let told = notices.join("\n");
            assert!(told.contains("ignored elements 1 of type 2"), "{version} {form:?}: {told}");
            let straight =
                "only the 4 corners of 192 tetrahedra of 10 nodes are read; their mid-edge nodes are at the midpoints";
            assert_eq!(told.contains(straight), second_order, "{version} {form:?}: {told}");
        }
    }
}

/// A gmsh file of the block as two physical volumes: the gel in the upper half, a soft backing in the lower.
fn two_volumes(version: &str, form: Form) -> Vec<u8> {
    let mesh = block();
    let middle = |t: usize| mesh.corners(t).into_iter().sum::<DVec3>().z / 4.0;
    let parts =
        [true, false].map(|above| (0..mesh.tets.len()).filter(|t| (middle(*t) > -2e-3) == above).collect::<Vec<_>>());
    let (v2, v41, n) = (version.starts_with('2'), version == "4.1", mesh.nodes.len());
    let mut o = Out(form, Vec::new());
    o.text(&format!("$MeshFormat\n{version} {} 8\n", i32::from(form != Form::Text)));
    if form != Form::Text {
        o.int(1);
        o.text("\n");
    }
    o.text("$EndMeshFormat\n$PhysicalNames\n3\n2 9 \"skin\"\n3 7 \"gel\"\n3 8 \"soft backing\"\n$EndPhysicalNames\n");
    if !v2 {
        // One point in a group, and two volumes without boundary surfaces.
        o.text("$Entities\n");
        [1, 0, 0, 2].into_iter().for_each(|count| o.size(count));
        o.end();
        o.int(5);
        (0..if v41 { 3 } else { 6 }).for_each(|_| o.real(0.5));
        o.size(1);
        o.int(3);
        o.end();
        for (volume, group) in [(1, 7), (2, 8)] {
            o.int(volume);
            (0..6).for_each(|k| o.real(f64::from(k)));
            o.size(1);
            o.int(group);
            o.size(0);
            o.end();
        }
        o.text("\n$EndEntities\n");
    }
    o.text("$Nodes\n");
    if v2 {
        o.text(&format!("{n}\n"));
    } else {
        o.size(1);
        o.size(n);
        if v41 {
            o.size(1);
            o.size(n);
        }
        o.end();
        [3, 1, 0].into_iter().for_each(|v| o.int(v));
        o.size(n);
        o.end();
        (0..if v41 { n } else { 0 }).for_each(|i| {
            o.size(i + 1);
            o.end();
        });
    }
    for (i, p) in mesh.nodes.iter().enumerate() {
        if !v41 {
            o.int(i + 1);
        }
        o.point(*p);
        o.end();
    }
    o.text("\n$EndNodes\n$Elements\n");
    if v2 {
        o.text(&format!("{}\n", mesh.tets.len()));
    } else {
        o.size(2);
        o.size(mesh.tets.len());
        if v41 {
            o.size(1);
            o.size(mesh.tets.len());
        }
        o.end();
    }
    for (part, tets) in parts.iter().enumerate() {
        if !v2 {
            // The dimension comes first since version 4.1.
            if v41 { [3, part + 1] } else { [part + 1, 3] }.into_iter().for_each(|v| o.int(v));
            o.int(4);
            o.size(tets.len());
            o.end();
        } else if form != Form::Text {
            [4, tets.len(), 2].into_iter().for_each(|v| o.int(v));
        }
        for t in tets {
            let tag = |o: &mut Out, v| if v41 { o.size(v) } else { o.int(v) };
            tag(&mut o, t + 1);
            match (v2, form) {
                (true, Form::Text) => [4, 2, 7 + part, part + 1].into_iter().for_each(|v| o.int(v)),
                (true, _) => [7 + part, part + 1].into_iter().for_each(|v| o.int(v)),
                (false, _) => {}
            }
            mesh.tets[*t].into_iter().for_each(|i| tag(&mut o, i as usize + 1));
            o.end();
        }
    }
    o.text("\n$EndElements\n");
    o.1
}

#[test]
fn a_group_of_a_gmsh_file_is_chosen_by_its_name() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("two.msh");
    for version in ["2.2", "4.0", "4.1"] {
        for form in [Form::Text, Form::Little, Form::Big] {
            std::fs::write(&path, two_volumes(version, form)).unwrap();
            let (all, notices) = io::read_tet_mesh(&path).unwrap_or_else(|e| panic!("{version} {form:?}: {e}"));
            is_block(&all);
            let notices = notices.join("\n");
            let says = "the volumes \"gel\" of 96 tetrahedra, \"soft backing\" of 96 tetrahedra are combined";
            assert!(notices.contains(says) && notices.contains("`group: \"gel\"`"), "{version} {form:?}: {notices}");
            for (group, low, high) in [("gel", -2e-3, 0.0), ("soft backing", -4e-3, -2e-3), ("8", -4e-3, -2e-3)] {
                if group == "8" && version != "2.2" {
                    continue;
                }
                let Ok((part, notices)) = io::read_tet_group(&path, Some(group)) else {
                    assert_eq!(group, "8", "a group with a name is not called by its tag");
                    continue;
                };
                let heights = part.tets.iter().flatten().map(|i| part.nodes[*i as usize].z);
                let (least, most) = heights.fold((1.0, -1.0), |(l, h), z| (f64::min(l, z), f64::max(h, z)));
                assert!((least - low).abs() < 1e-9 && (most - high).abs() < 1e-9, "{group}: {least} to {most} m");
                assert!(part.tets.len() == 96 && notices.is_empty(), "{} {notices:?}", part.tets.len());
            }
            let error = io::read_tet_group(&path, Some("glue")).unwrap_err().to_string();
            assert!(error.contains("has no physical volume \"glue\"") && error.contains("\"gel\" of 96"), "{error}");
        }
    }
    // The pad of the upper half has half the thickness.
    let text = "(object: (shape: Sphere(radius: 0.02)), gripper: (pads: File(path: \"two.msh\", group: \"gel\")), \
                loading: Squeeze(force: 1, frames: 1))";
    let scene = dir.path().join("s.ron");
    std::fs::write(&scene, text).unwrap();
    let built =
        |scene: &Path| tactus::model::part::pad::build(&load(scene).unwrap().scene.gripper.pads, &mut Vec::new());
    let (pad, _) = built(&scene).unwrap();
    assert!((pad.thickness() - 2e-3).abs() < 1e-9, "{} m", pad.thickness());
    // A wrong scale gives a pad outside the range of valid sizes.
    for (scale, size) in [("1e-6", "2e-8 x 1.6e-8 x 2e-9 m"), ("1000", "20 x 16 x 2 m")] {
        std::fs::write(&scene, text.replace("\"gel\"", &format!("\"gel\", scale: {scale}"))).unwrap();
        let error = built(&scene).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains(&format!("the pad is {size}")) && error.contains("from 1e-5 to 2 m"), "{error}");
    }
    let error = io::read_tet_group("a.vtk", Some("gel")).unwrap_err().to_string();
    assert!(error.contains("convert it to gmsh"), "{error}");
}

#[test]
fn curved_edges_are_told_and_a_foreign_order_of_nodes_is_refused() {
    let (mut nodes, cells) = with_middles();
    let corners = block().nodes.len();
    let sound = nodes.clone();
    // The mid-edge nodes of the upper face are raised by 0.1 mm, 2 to 3 % of the distance of the corners.
    nodes[corners..].iter_mut().filter(|p| p.z > -1e-9).for_each(|p| p.z += 1e-4);
    let (mesh, notices) = read("a.msh", &gmsh("4.1", Form::Little, &nodes, &cells)).unwrap();
    is_block(&mesh);
    let told = notices.join("\n");
    assert!(told.contains("are up to 1.00e-4 m") && told.contains("edges are treated as straight"), "{told}");
    // A gmsh file with the mid-edge nodes in the order of VTK.
    let vtk: Vec<Vec<u32>> = quadratic::to_quadratic(&block()).tets.iter().map(|t| t.to_vec()).collect();
    let error = read("a.msh", &gmsh("2.2", Form::Text, &sound, &vtk)).unwrap_err();
    assert!(error.contains("not in the order of gmsh") && error.contains("line "), "{error}");
}

#[test]
fn damaged_binary_gmsh_files_say_where() {
    let (nodes, cells) = linear();
    let whole = gmsh("4.1", Form::Little, &nodes, &cells);
    let refused = |bytes: &[u8], says: &str| {
        let error = read("a.msh", bytes).unwrap_err();
        assert!(error.contains("a.msh: ") && error.contains(says), "expected {says:?} in: {error}");
    };
    refused(&whole[..whole.len() / 2], "the file ends where");
    let mut other = whole.clone();
    other[20..24].copy_from_slice(&[7, 7, 7, 7]);
    refused(&other, "byte 24: the byte order must be indicated by a 1, found the bytes [7, 7, 7, 7]");
    refused(b"$MeshFormat\n3.0 1 8\n", "gmsh format `3.0`; allowed: 2.2, 4.0 or 4.1");
    let mut huge = b"$MeshFormat\n4.1 1 8\n\x01\0\0\0\n$EndMeshFormat\n$Nodes\n".to_vec();
    huge.extend([1_u64, 1 << 60, 1, 2].iter().flat_map(|v| v.to_le_bytes()));
    refused(&huge, "the number of nodes 1152921504606846976 is above the 5000000 allowed");
}

/// A Medit file of the block with sections that mmg writes before and after the tetrahedra.
fn medit() -> String {
    let mesh = block();
    let mut text = "MeshVersionFormatted 2\n\nDimension 3\n\nVertices\n".to_string();
    text += &format!("{}\n", mesh.nodes.len());
    mesh.nodes.iter().for_each(|p| text += &format!("{} {} {} 0\n", p.x, p.y, p.z));
    text += "\nCorners\n2\n1\n2\n\nRequiredVertices\n1\n1\n\nEdges\n2\n1 2 5\n2 3 5\n\nRidges\n1\n1\n\nRequiredEdges\n1\n2\n";
    text += &format!("\nTetrahedra\n{}\n", mesh.tets.len());
    mesh.tets.iter().for_each(|t| text += &format!("{} {} {} {} 1\n", t[0] + 1, t[1] + 1, t[2] + 1, t[3] + 1));
    text += "\nRequiredTetrahedra\n1\n3\nNormals\n2\n0 0 1\n-0.1 1.0e-3 -1\n\nNormalAtVertices\n2\n1 1\n2 2\n";
    text += "\nTangents\n1\n1 0 0\n\nTangentAtVertices\n1\n1 1\n\nNormalAtTriangleVertices\n1\n1 1 1\n\nEnd\n";
    text
}

#[test]
fn medit_files_of_mmg_hold_the_same_block() {
    let (mesh, notices) = read("a.mesh", medit().as_bytes()).unwrap();
    is_block(&mesh);
    let told = notices.join("\n");
    for section in ["2 `Normals`", "1 `RequiredEdges`", "2 `NormalAtVertices`", "1 `TangentAtVertices`"] {
        assert!(told.contains(section), "{section} is not in {told}");
    }
    let ten = quadratic::to_quadratic(&block());
    let mut second = format!("MeshVersionFormatted 2\nDimension 3\nVertices {}\n", ten.nodes.len());
    ten.nodes.iter().for_each(|p| second += &format!("{} {} {} 0\n", p.x, p.y, p.z));
    second += &format!("TetrahedraP2 {}\n", ten.tets.len());
    ten.tets.iter().for_each(|t| second += &format!("{} 1\n", t.map(|n| (n + 1).to_string()).join(" ")));
    is_block(&read("a.mesh", second.as_bytes()).unwrap().0);
    let error = read("a.meshb", b"\x01\0\0\0").unwrap_err();
    assert!(error.contains("`meshio convert -o gmsh22 a.meshb a.msh`"), "{error}");
    let error = read("a.mesh", b"\x01\0\0\0\x02\0\0\0").unwrap_err();
    assert!(error.contains("binary Medit") && error.contains("meshio convert"), "{error}");
}

/// A legacy VTK text file of the block, of version 3.0 (one list of cells) or 5.1 (offsets and connectivity).
fn vtk(five: bool) -> String {
    let mesh = block();
    let n = mesh.tets.len();
    let mut text =
        format!("# vtk DataFile Version {}\n\nASCII\nDATASET UNSTRUCTURED_GRID\n", if five { 5.1 } else { 3.0 });
    text += &format!("POINTS {} double\n", mesh.nodes.len());
    mesh.nodes.iter().for_each(|p| text += &format!("{} {} {}\n", p.x, p.y, p.z));
    if five {
        text += &format!("METADATA\nINFORMATION 0\n\nCELLS {} {}\nOFFSETS vtktypeint64\n0 3", n + 2, 4 * n + 3);
        (1..=n).for_each(|t| text += &format!(" {}", 3 + 4 * t));
        text += "\nCONNECTIVITY vtktypeint64\n0 1 2\n";
        mesh.tets.iter().for_each(|t| text += &format!("{} {} {} {}\n", t[0], t[1], t[2], t[3]));
    } else {
        text += &format!("CELLS {} {}\n3 0 1 2\n", n + 1, 5 * n + 4);
        mesh.tets.iter().for_each(|t| text += &format!("4 {} {} {} {}\n", t[0], t[1], t[2], t[3]));
    }
    text += &format!("CELL_TYPES {}\n5\n{}", n + 1, "10\n".repeat(n));
    text + "POINT_DATA 75\nSCALARS u float\n"
}

/// A binary VTK file of the block and a triangle as meshio writes it, of version 4.2 (one list of cells) or 5.1
/// (offsets and connectivity).
fn binary_vtk(five: bool) -> Vec<u8> {
    let mesh = block();
    let (n, mut out) = (mesh.tets.len(), Vec::new());
    let cells: Vec<Vec<u32>> = mesh.tets.iter().map(|t| t.to_vec()).chain([vec![0, 1, 2]]).collect();
    let version = if five { "5.1" } else { "4.2" };
    out.extend(
        format!("# vtk DataFile Version {version}\nwritten by meshio v5.3.5\nBINARY\nDATASET UNSTRUCTURED_GRID\n")
            .bytes(),
    );
    out.extend(format!("POINTS {} double\n", mesh.nodes.len()).bytes());
    mesh.nodes.iter().flat_map(|p| p.to_array()).for_each(|x| out.extend(x.to_be_bytes()));
    if five {
        out.extend(format!("\nCELLS {} {}\nOFFSETS vtktypeint64\n", n + 2, 4 * n + 3).bytes());
        (0..=n).map(|t| 4 * t as i64).chain([4 * n as i64 + 3]).for_each(|at| out.extend(at.to_be_bytes()));
        out.extend(b"\nCONNECTIVITY vtktypeint64\n");
        cells.iter().flatten().for_each(|i| out.extend(i64::from(*i).to_be_bytes()));
    } else {
        out.extend(format!("\nCELLS {} {}\n", n + 1, 5 * n + 4).bytes());
        let rows = cells.iter().flat_map(|cell| [cell.len() as u32].into_iter().chain(cell.iter().copied()));
        rows.for_each(|i| out.extend((i as i32).to_be_bytes()));
    }
    out.extend(format!("\nCELL_TYPES {}\n", n + 1).bytes());
    (0..=n).for_each(|t| out.extend(if t < n { 10_i32 } else { 5 }.to_be_bytes()));
    out.extend(b"\nPOINT_DATA 75\nFIELD FieldData 1\nt 1 1 double\n\0\0\0\0\0\0\0\0\n");
    out
}

/// The two files of TetGen, nodes counted from `first`.
fn tetgen(first: u32) -> (String, String) {
    let mesh = block();
    let mut node = format!("# Generated\n{} 3 0 1\n", mesh.nodes.len());
    let number = |i: usize| i as u32 + first;
    let points = mesh.nodes.iter().enumerate();
    points.for_each(|(i, p)| node += &format!("  {}  {} {} {}  0\n", number(i), p.x, p.y, p.z));
    let mut ele = format!("{} 4 0\n", mesh.tets.len());
    let tets = mesh.tets.iter().enumerate();
    tets.for_each(|(i, t)| {
        let [a, b, c, d] = t.map(|n| n + first);
        ele += &format!("{} {a} {b} {c} {d}\n", number(i));
    });
    (node, ele)
}

#[test]
fn vtk_and_tetgen_files_hold_the_same_block_and_others_say_how_to_convert() {
    for five in [false, true] {
        let (mesh, notices) = read("a.vtk", vtk(five).as_bytes()).unwrap();
        is_block(&mesh);
        assert!(notices.join("\n").contains("ignored 1 cell;"), "{notices:?}");
    }
    for five in [false, true] {
        let bytes = binary_vtk(five);
        let (mesh, notices) = read("a.vtk", &bytes).unwrap();
        is_block(&mesh);
        assert!(notices.join("\n").contains("ignored 1 cell;"), "{notices:?}");
        // The writers of VTK itself write field data before the points.
        let front = b"FIELD FieldData 1\ntime 1 1 double\n\x0a\x0a\0\0\0\0\0\0\nPOINTS";
        let at = bytes.windows(6).position(|w| w == b"POINTS").unwrap();
        let own = [&bytes[..at], front, &bytes[at + 6..]].concat();
        is_block(&read("a.vtk", &own).unwrap().0);
        for cut in (at..bytes.len() - 60).step_by(97) {
            let error = read("a.vtk", &bytes[..cut]).unwrap_err();
            assert!(error.contains("a.vtk"), "{error}");
        }
        let error = read("a.vtk", &bytes[..at + 200]).unwrap_err();
        assert!(error.contains("the file ends within an array of 225 numbers"), "{error}");
    }
    let dir = tempfile::tempdir().unwrap();
    for first in [0, 1] {
        let (node, ele) = tetgen(first);
        std::fs::write(dir.path().join("a.1.node"), node).unwrap();
        std::fs::write(dir.path().join("a.1.ele"), ele).unwrap();
        for name in ["a.1.node", "a.1.ele"] {
            is_block(&io::read_tet_mesh(dir.path().join(name)).unwrap().0);
        }
    }
    std::fs::remove_file(dir.path().join("a.1.node")).unwrap();
    let alone = io::read_tet_mesh(dir.path().join("a.1.ele")).unwrap_err().to_string();
    assert!(alone.contains("a.1.node is missing") && alone.contains("belong together"), "{alone}");
    for (name, says) in [
        ("a.vtu", "`meshio convert -o gmsh22 a.vtu a.msh`"),
        ("a.inp", "`meshio convert -o gmsh22 a.inp a.msh`"),
        ("part.step", "`gmsh -3 part.step -o part.msh`"),
        ("a.stl", "mesh its volume with tetrahedra"),
        // A `.msh` file of ANSYS.
        ("a.msh", "`meshio convert -o gmsh22 a.msh gmsh_a.msh`"),
    ] {
        let error = read(name, b"(1 x)\n").unwrap_err();
        assert!(error.contains(says), "{error}");
    }
}

#[test]
fn a_line_of_a_megabyte_is_read_in_the_time_of_its_length() {
    // 400,000 words in one line. Counting the column from the line start for each word is quadratic: 20 s.
    let long = format!("v 0 0 0\n{}\n", "1 ".repeat(400_000));
    within(HANG, "a long line", move || {
        let error = read("a.tet", long.as_bytes()).unwrap_err();
        assert!(error.contains("line 2, column 1"), "{error}");
    });
    let longer = format!("# {}\n", "1 ".repeat(4_000_000));
    let error = read("a.tet", longer.as_bytes()).unwrap_err();
    assert!(error.contains("line 1 has 8000002 bytes; at most 4194304 are allowed"), "{error}");
    let word = read("a.tet", "x".repeat(100_000).as_bytes()).unwrap_err();
    assert!(word.len() < 400, "a word of 100,000 letters is quoted in {} letters", word.len());
}

/// Runs `work` on a separate thread and panics if it takes longer than `limit`.
fn within(limit: Duration, what: &str, work: impl FnOnce() + Send + 'static) {
    let (done, wait) = mpsc::channel();
    let worker = std::thread::spawn(move || {
        work();
        let _ = done.send(());
    });
    if let Err(mpsc::RecvTimeoutError::Timeout) = wait.recv_timeout(limit) {
        panic!("{what} is not done after {limit:?}");
    }
    worker.join().unwrap();
}

/// Grasps centred on an object at the origin, from 20 directions.
fn around() -> Vec<Pose> {
    (0..20)
        .map(|i| {
            let a = f64::from(i);
            let rotation = DQuat::from_rotation_z(0.7 * a) * DQuat::from_rotation_x(0.3 + 0.11 * a);
            Pose { position: -(rotation * DVec3::new(0.0, 0.0, 0.1)), rotation }
        })
        .collect()
}

/// Scene of a ball and coarse pads with these grasps.
fn scene(dir: &Path, grasps: &str) -> PathBuf {
    let path = dir.join("s.ron");
    let text = format!(
        "(object: (shape: Sphere(radius: 0.02)), gripper: (pads: Box(size: (0.02, 0.02, 0.004), cells: (2, 2, 2))),\n\
         grasps: {grasps},\nloading: Squeeze(force: 1, frames: 1))"
    );
    std::fs::write(&path, text).unwrap();
    path
}

fn tactus(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_tactus")).args(args).output().unwrap()
}

fn both(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

#[track_caller]
fn alike(read: &[Pose], expected: &[Pose], slack: f64) {
    assert_eq!(read.len(), expected.len());
    for (a, b) in read.iter().zip(expected) {
        let off = (a.position - b.position).length().max(1.0 - a.rotation.dot(b.rotation).abs());
        assert!(off < slack, "{a:?} is not {b:?}: {off:e}");
    }
}

#[test]
fn grasps_of_other_conventions_are_the_same_grasps() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("g.h5");
    let wanted = around();
    let cases = [
        ("(quaternion: Xyzw)", Convention { quaternion: QuaternionOrder::Xyzw, ..Convention::default() }),
        (
            "(quaternion: Xyzw, closing: Y, approach: Z)",
            Convention { quaternion: QuaternionOrder::Xyzw, closing: HandAxis::Y, approach: HandAxis::Z },
        ),
        (
            "(closing: Y, approach: X)",
            Convention { closing: HandAxis::Y, approach: HandAxis::X, ..Convention::default() },
        ),
        ("(approach: MinusZ)", Convention { approach: HandAxis::MinusZ, ..Convention::default() }),
    ];
    for (text, convention) in cases {
        // In the hand frame F of the file, a point with hand coordinates x has the coordinates C x.
        let c = convention.from_hand();
        assert!((c.determinant() - 1.0).abs() < 1e-15, "{text} mirrors");
        assert_eq!((c * DVec3::X, c * DVec3::Z), (convention.closing.vector(), convention.approach.vector()));
        let theirs: Vec<DMat3> = wanted.iter().map(|p| DMat3::from_quat(p.rotation) * c.transpose()).collect();
        let rows = wanted.iter().zip(&theirs).flat_map(|(p, r)| {
            let (x, q) = (p.position, DQuat::from_mat3(r));
            match convention.quaternion {
                QuaternionOrder::Wxyz => [x.x, x.y, x.z, q.w, q.x, q.y, q.z],
                QuaternionOrder::Xyzw => [x.x, x.y, x.z, q.x, q.y, q.z, q.w],
            }
        });
        let matrices = wanted.iter().zip(&theirs).flat_map(|(p, r)| {
            let (x, row) = (p.position, |k: usize| r.row(k));
            let line = |k: usize, at: f64| [row(k).x, row(k).y, row(k).z, at];
            [line(0, x.x), line(1, x.y), line(2, x.z), [0.0, 0.0, 0.0, 1.0]].concat()
        });
        let n = wanted.len() as u64;
        for (values, shape) in [(rows.collect::<Vec<_>>(), vec![n, 7]), (matrices.collect(), vec![n, 4, 4])] {
            let mut builder = FileBuilder::new();
            builder.create_dataset("poses").with_f64_data(&values).with_shape(&shape);
            builder.write(&path).unwrap();
            let loaded = load(scene(dir.path(), &format!("File(path: \"g.h5\", convention: {text})"))).unwrap();
            alike(&grasp_poses(&loaded.scene).unwrap(), &wanted, 1e-12);
            // The complete scene that `check` prints loads as the same scene.
            let again = tactus::scene::from_ron(&tactus::scene::to_ron(&loaded.scene).unwrap()).unwrap();
            assert_eq!(again, loaded.scene);
        }
    }
}

/// ACRONYM files hold grasps of a scaled object: their scale applies, unless the scene gives one.
#[test]
fn the_scale_of_an_acronym_file_is_that_of_the_object() {
    let dir = tempfile::tempdir().unwrap();
    let matrix = |p: &Pose| {
        let (x, r) = (p.position, DMat3::from_quat(p.rotation));
        let line = |k: usize| [r.row(k).x, r.row(k).y, r.row(k).z, x[k]];
        [line(0), line(1), line(2), [0.0, 0.0, 0.0, 1.0]].concat()
    };
    let poses: Vec<f64> = around().iter().flat_map(matrix).collect();
    let write = |scale: &[f64], shape: &[u64]| {
        let mut builder = FileBuilder::new();
        let mut grasps = builder.create_group("grasps");
        grasps.create_dataset("transforms").with_f64_data(&poses).with_shape(&[around().len() as u64, 4, 4]);
        builder.add_group(grasps.finish());
        let mut object = builder.create_group("object");
        object.create_dataset("scale").with_f64_data(scale).with_shape(shape);
        builder.add_group(object.finish());
        builder.write(dir.path().join("g.h5")).unwrap();
    };
    let file = "File(path: \"g.h5\", dataset: \"grasps/transforms\")";
    let model = |object: &str| {
        let path = scene(dir.path(), file);
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, text.replace("radius: 0.02)", &format!("radius: 0.02){object}"))).unwrap();
        Model::build(&load(&path).unwrap().scene).map_err(|e| e.to_string())
    };
    write(&[0.5], &[]);
    for (object, radius, says) in [
        ("", 0.01, "the object is scaled by the file's `object/scale`, 0.5"),
        (", scale: 0.5", 0.01, ""),
        (", scale: 1", 0.02, "at `object/scale` 0.5, but the scene sets `scale: 1`"),
    ] {
        let model = model(object).unwrap();
        assert!((model.object.bounding_radius - radius).abs() < 1e-12, "{object}: {} m", model.object.bounding_radius);
        let notices = model.notices.join("\n");
        assert!(notices.contains(says) && notices.contains("object/scale") != says.is_empty(), "{object}: {notices}");
    }
    write(&[-0.5], &[1]);
    let error = model("").err().unwrap();
    assert!(error.contains("dataset `object/scale`") && error.contains("above zero"), "{error}");
    write(&[0.5, 0.5], &[2]);
    assert!(model("").err().unwrap().contains("one number is needed"));
}

#[test]
fn a_convention_that_is_none_is_refused_with_its_place() {
    let dir = tempfile::tempdir().unwrap();
    write_grasps_h5(dir.path().join("g.h5"), &around()).unwrap();
    for (text, says) in [
        ("(quaternion: Zyxw)", "allowed: Wxyz, Xyzw"),
        ("(closing: W)", "allowed: X, Y, Z, MinusX, MinusY, MinusZ"),
        ("(order: Xyzw)", "allowed: quaternion, closing, approach"),
        ("(closing: Z)", "closing and approach are along the same axis"),
    ] {
        let path = scene(dir.path(), &format!("File(path: \"g.h5\", convention: {text})"));
        let error = load(path).unwrap_err().to_string();
        assert!(error.contains("s.ron:2:") && error.contains(says), "expected {says:?} in: {error}");
    }
}

#[test]
fn matrices_that_are_no_poses_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("g.h5");
    let refused = |matrix: [f64; 16], says: &str| {
        let mut builder = FileBuilder::new();
        builder.create_dataset("poses").with_f64_data(&matrix).with_shape(&[1, 4, 4]);
        builder.write(&path).unwrap();
        let error = read_grasps_h5(&path).unwrap_err().to_string();
        assert!(error.contains("row 0") && error.contains(says), "expected {says:?} in: {error}");
    };
    let unit: [f64; 16] = std::array::from_fn(|k| f64::from(u8::from(k % 5 == 0)));
    let with = |k: usize, v: f64| {
        let mut m = unit;
        m[k] = v;
        m
    };
    refused(with(10, -1.0), "determinant -1");
    refused(with(0, 1.01), "not orthonormal: its error is 2.01e-2");
    refused(with(12, 0.1), "last row is [0.1, 0.0, 0.0, 1.0]");
    refused(with(3, f64::NAN), "column 3 is NaN");
}

#[test]
fn every_command_tells_of_grasps_that_miss() {
    let dir = tempfile::tempdir().unwrap();
    // Quaternions (x, y, z, w) in a file that is read as (w, x, y, z).
    let swapped: Vec<f64> = around()
        .iter()
        .flat_map(|p| {
            [p.position.x, p.position.y, p.position.z, p.rotation.x, p.rotation.y, p.rotation.z, p.rotation.w]
        })
        .collect();
    let mut builder = FileBuilder::new();
    builder.create_dataset("poses").with_f64_data(&swapped).with_shape(&[20, 7]);
    builder.write(dir.path().join("g.h5")).unwrap();
    let (out, notice) = (dir.path().join("out"), "miss the object");
    for (grasps, tells) in [("File(\"g.h5\")", true), ("File(path: \"g.h5\", convention: (quaternion: Xyzw))", false)] {
        let path = scene(dir.path(), grasps);
        let path = path.to_str().unwrap();
        let said = [
            both(&tactus(&["check", path])),
            both(&tactus(&["run", path, "--grasp", "0", "--no-pictures"])),
            both(&tactus(&["dataset", path, "-o", out.to_str().unwrap(), "--dry-run"])),
        ];
        for text in &said {
            let told = text.contains(notice) && text.contains("convention: (quaternion: Xyzw");
            assert_eq!(told, tells, "{grasps}: {text}");
        }
    }
}

/// Runs a Python script with h5py in `dir`. Without Python or h5py it reports a skipped test and returns false.
fn h5py(dir: &Path, script: &str) -> bool {
    let out = Command::new("python3").arg("-c").arg(script).current_dir(dir).output();
    match out {
        Ok(out) if out.status.success() => true,
        Ok(out) if String::from_utf8_lossy(&out.stderr).contains("ModuleNotFoundError") => {
            skipped("python3 has no h5py");
            false
        }
        Ok(out) => panic!("{}", String::from_utf8_lossy(&out.stderr)),
        Err(error) => {
            skipped(&format!("no python3 ({error})"));
            false
        }
    }
}

#[test]
fn files_of_h5py_are_read_or_say_how_to_write_them() {
    let dir = tempfile::tempdir().unwrap();
    let script = r#"
import h5py, numpy as np, math
n = 50
p = np.zeros((n, 7)); p[:, 0] = np.arange(n) * 1e-3; p[:, 2] = -0.1
p[:, 3] = np.cos(np.arange(n) * 0.1); p[:, 6] = np.sin(np.arange(n) * 0.1)
def write(name, make, **kw):
    with h5py.File(name, 'w', **kw) as f: make(f)
def data(name='poses', values=p, **kw): return lambda f: f.create_dataset(name, data=values, **kw)
packed = dict(compression='gzip', shuffle=True, chunks=(16, 7))
for bound in ['earliest', 'v108', 'v110', 'v112', 'v114', 'latest']:
    write(f'plain_{bound}.h5', data(), libver=bound)
    write(f'packed_{bound}.h5', data(**packed), libver=bound)
    write(f'grows_{bound}.h5', data(maxshape=(None, 7), chunks=(16, 7)), libver=bound)
    write(f'both_{bound}.h5', data(maxshape=(None, None), chunks=(16, 7)), libver=bound)
write('single.h5', data(values=p.astype('f4'), **packed))
write('big.h5', data(values=p.astype('>f8')))
write('half.h5', data(values=p.astype('f2')))
write('lzf.h5', data(compression='lzf'))
write('sums.h5', data(fletcher32=True))
def soft(f): data('grasps/data')(f); f['poses'] = h5py.SoftLink('/grasps/data')
write('soft.h5', soft)
write('soft_latest.h5', soft, libver='latest')
write('claims.h5', lambda f: f.create_dataset('poses', shape=(38_000_000, 7), dtype='f8', chunks=(100000, 7), compression='gzip'))
write('chunk.h5', lambda f: f.create_dataset('poses', shape=(10, 7), maxshape=(None, 7), dtype='f8', chunks=(60_000_000, 7), compression='gzip'))
"#;
    if !h5py(dir.path(), script) {
        return;
    }
    let expected: Vec<Pose> = (0..50)
        .map(|i| Pose {
            position: DVec3::new(f64::from(i) * 1e-3, 0.0, -0.1),
            rotation: DQuat::from_rotation_z(2.0 * f64::from(i) * 0.1),
        })
        .collect();
    let read = |name: &str| read_grasps_h5(dir.path().join(name)).map_err(|e| e.to_string());
    let (mut good, mut told) = (0, 0);
    for bound in ["earliest", "v108", "v110", "v112", "v114", "latest"] {
        for kind in ["plain", "packed", "grows", "both"] {
            match read(&format!("{kind}_{bound}.h5")) {
                Ok(poses) => {
                    alike(&poses, &expected, 1e-12);
                    good += 1;
                }
                Err(error) => {
                    assert!(error.contains("libver=\"earliest\""), "{kind} {bound}: {error}");
                    assert!(bound == "latest" || kind == "both", "{kind} {bound} is refused: {error}");
                    told += 1;
                }
            }
        }
    }
    eprintln!("{good} of {} files of h5py are read, the others say how to write them", good + told);
    assert!(good >= 17, "only {good} are read");
    alike(&read("single.h5").unwrap(), &expected, 1e-7);
    for name in ["big.h5", "lzf.h5", "sums.h5"] {
        alike(&read(name).unwrap(), &expected, 1e-12);
    }
    // Datasets cannot be listed in files of the old format that have a soft link.
    for (name, says) in [("soft.h5", "dataset: \"group/name\""), ("soft_latest.h5", "dataset: \"grasps/data\"")] {
        let error = read(name).unwrap_err();
        assert!(error.contains("links are not followed") && error.contains(says), "{error}");
    }
    let error = read("half.h5").unwrap_err();
    assert!(error.contains("allowed: float64, float32"), "{error}");
    std::fs::copy(dir.path().join("soft.h5"), dir.path().join("g.h5")).unwrap();
    let loaded = load(scene(dir.path(), "File(path: \"g.h5\", dataset: \"grasps/data\")")).unwrap();
    alike(&grasp_poses(&loaded.scene).unwrap(), &expected, 1e-12);
    let error = read("claims.h5").unwrap_err();
    assert!(error.contains("declares 38000000 grasps; at most 1000000 are allowed"), "{error}");
    let error = read("chunk.h5").unwrap_err();
    assert!(error.contains("chunks of 3204 MiB"), "{error}");
}

/// Damages `bytes` once: flipped bits, truncation, repeated bytes, an inserted huge number, bytes set to 0xff, or
/// deleted bytes.
fn damage(random: &mut Random, bytes: &mut Vec<u8>) {
    let at = random.uniform_below(bytes.len());
    match random.uniform_below(6) {
        0 => (0..1 + random.uniform_below(8)).for_each(|_| {
            let k = random.uniform_below(bytes.len());
            bytes[k] ^= 1 << random.uniform_below(8);
        }),
        1 => bytes.truncate(at),
        2 => {
            let end = (at + 1 + random.uniform_below(200)).min(bytes.len());
            let copy = bytes[at..end].to_vec();
            drop(bytes.splice(at..at, copy));
        }
        3 => {
            let digits = bytes.iter().skip(at).position(u8::is_ascii_digit).map_or(at, |k| at + k);
            drop(bytes.splice(digits..digits, *b"99999999999"));
        }
        4 => {
            let end = (at + 8).min(bytes.len());
            bytes[at..end].fill(0xff);
        }
        _ => {
            let end = (at + 1 + random.uniform_below(40)).min(bytes.len());
            bytes.drain(at..end);
        }
    }
    if bytes.is_empty() {
        bytes.push(b'0');
    }
}

/// Smallest files of the text formats and of grasps, whose every byte is damaged.
fn small(dir: &Path) -> Vec<(String, Vec<u8>)> {
    let tet = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nt 0 1 2 3\n";
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1 2//2 -1/1/1\n";
    let stl = "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n";
    let medit = "MeshVersionFormatted 1\nDimension 3\nVertices 4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\nTetrahedra\n1\n\
                 1 2 3 4 0\nEnd";
    let gmsh = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 4 1 4\n3 0 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n\
                $EndNodes\n$Elements\n1 1 1 1\n3 0 4 1\n1 1 2 3 4\n$EndElements\n";
    let text = [("x.tet", tet), ("x.obj", obj), ("x.stl", stl), ("x.mesh", medit), ("x.msh", gmsh)];
    let mut files: Vec<_> = text.iter().map(|(name, text)| (name.to_string(), text.as_bytes().to_vec())).collect();
    let grasps = dir.join("x.h5");
    write_grasps_h5(&grasps, &[Pose { position: DVec3::ZERO, rotation: DQuat::IDENTITY }; 3]).unwrap();
    files.push(("x.h5".into(), std::fs::read(grasps).unwrap()));
    files
}

/// Files of every format and form, of the size that programs write.
fn large(dir: &Path) -> Vec<(String, Vec<u8>)> {
    let (nodes, cells) = linear();
    let mut files: Vec<(String, Vec<u8>)> = FORMS
        .iter()
        .map(|(version, form)| (format!("{version}{form:?}.msh"), gmsh(version, *form, &nodes, &cells)))
        .collect();
    let (nodes, cells) = with_middles();
    files.push(("ten.msh".into(), gmsh("4.1", Form::Little, &nodes, &cells)));
    files.push(("a.mesh".into(), medit().into_bytes()));
    files.push(("old.vtk".into(), vtk(false).into_bytes()));
    files.push(("new.vtk".into(), vtk(true).into_bytes()));
    let (node, ele) = tetgen(1);
    std::fs::write(dir.join("a.node"), node).unwrap();
    files.push(("a.ele".into(), ele.into_bytes()));
    let grasps = dir.join("g.h5");
    write_grasps_h5(&grasps, &around()).unwrap();
    files.push(("g.h5".into(), std::fs::read(&grasps).unwrap()));
    let mut builder = FileBuilder::new();
    let values: Vec<f64> = around().iter().flat_map(|p| [p.position.x, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]).collect();
    builder.create_dataset("poses").with_f64_data(&values).with_shape(&[20, 7]).with_chunks(&[8, 7]).with_deflate(6);
    files.push(("packed.h5".into(), builder.finish().unwrap()));
    files
}

/// Every byte of a small file set to three values, and the file cut off before every fourth byte (of HDF5: every byte).
fn every_byte(name: &str, whole: &[u8]) -> Vec<Vec<u8>> {
    let binary = name.ends_with("h5");
    let mut all = Vec::new();
    for at in 0..whole.len() {
        let values = if binary { [0x00, 0xff, whole[at] ^ 0x10] } else { [b' ', b'9', 0xff] };
        for value in values {
            let mut bytes = whole.to_vec();
            bytes[at] = value;
            all.push(bytes);
        }
        if binary || at % 4 == 0 {
            all.push(whole[..at].to_vec());
        }
    }
    all
}

/// Reads a mesh or grasp file; returns the message of a refusal.
fn refusal(file: &Path) -> Option<String> {
    let read = match file.extension().and_then(|e| e.to_str()) {
        Some("h5") => read_grasps_h5(file).map(|_| ()),
        Some("obj" | "stl") => io::read_tri_mesh(file).map(|_| ()),
        _ => io::read_tet_mesh(file).map(|_| ()),
    };
    read.err().map(|error| error.to_string())
}

/// A damaged file is read or refused by name in a short message: it never hangs or panics. Small files are damaged at
/// every byte, large ones at random.
#[test]
fn damaged_meshes_and_grasp_files_are_read_or_refused_by_name() {
    let dir = tempfile::tempdir().unwrap();
    let mut random = Random::new(8);
    let each = 40;
    let mut cases: Vec<(String, Vec<Vec<u8>>)> = Vec::new();
    for (name, whole) in small(dir.path()) {
        let file = dir.path().join(&name);
        std::fs::write(&file, &whole).unwrap();
        assert_eq!(refusal(&file), None, "{name} itself is read");
        cases.push((name.clone(), every_byte(&name, &whole)));
    }
    let large = large(dir.path());
    for (name, whole) in &large {
        let damaged = (0..each).map(|k| {
            let mut bytes = whole.clone();
            (0..1 + k % 3).for_each(|_| damage(&mut random, &mut bytes));
            bytes
        });
        cases.push((name.clone(), damaged.collect()));
    }
    let (mut refused, all) = (0, each * large.len());
    for (name, damaged) in cases {
        let (count, file) = (damaged.len(), dir.path().join(&name));
        let (tell, answers) = mpsc::channel();
        std::thread::spawn(move || {
            for bytes in damaged {
                std::fs::write(&file, bytes).unwrap();
                let _ = tell.send(refusal(&file));
            }
        });
        for k in 0..count {
            match answers.recv_timeout(HANG) {
                Ok(None) => {}
                Ok(Some(error)) => {
                    refused += usize::from(!name.starts_with("x."));
                    assert!(error.contains(dir.path().to_str().unwrap()), "{name}, damage {k}: no file in {error}");
                    assert!(error.len() < 1000, "{name}, damage {k}: {} letters", error.len());
                }
                Err(mpsc::RecvTimeoutError::Timeout) => panic!("{name}, damage {k}: not done after {HANG:?}"),
                Err(mpsc::RecvTimeoutError::Disconnected) => panic!("{name}, damage {k}: panics"),
            }
        }
    }
    assert!(all >= 500 && refused > all / 3, "{refused} of {all} damages of large files are refused");
}

/// Models of version 0.1 are refused with a message that names their replacement.
#[test]
fn models_of_former_versions_name_their_successor() {
    let dir = tempfile::tempdir().unwrap();
    let model = dir.path().join("old");
    std::fs::create_dir(&model).unwrap();
    std::fs::write(model.join("weights.safetensors"), [0; 8]).unwrap();
    std::fs::write(
        model.join("card.ron"),
        "(tactus: \"0.1.0\", features: 2, spec: (layers: 3), data: \"x\", best: true)",
    )
    .unwrap();
    let error = StoredModel::read(&model).unwrap_err().to_string();
    for says in ["trained by tactus 0.1.0", "feature version 2", "`tactus train`", "built-in network: universe"] {
        assert!(error.contains(says), "`{says}` is not in: {error}");
    }
    let error = StoredModel::read(&dir.path().join("gelsight_mini")).unwrap_err().to_string();
    assert!(error.contains("is a network of version 0.1") && error.contains("universe"), "{error}");
}
