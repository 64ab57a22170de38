//! Imperfect object files of users: hollow, overlapping, in millimetres, in single precision, with polygons, in upper
//! case, open. Each is read correctly, with notices, or refused with the location and a remedy.

use crate::skipped::data;
use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use approx::assert_relative_eq;
use glam::DVec3;
use tactus::backend::choose;
use tactus::base::error::Result;
use tactus::geometry::mesh::{TriMesh, weld};
use tactus::geometry::shape::ShapeKind;
use tactus::model::Model;
use tactus::model::grasp::grasp_poses;
use tactus::record::Status;
use tactus::scene::load;
use tactus::world::environment::Environment;
use tactus::world::run::run_grasps;
use tactus::world::schedule::Phase;

/// Returns the vertices and triangles (0-based, oriented outwards) of a cube.
fn cube(center: [f64; 3], size: f64) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let corner = |i: u32| DVec3::new(f64::from(i >> 2 & 1), f64::from(i >> 1 & 1), f64::from(i & 1)) - 0.5;
    let vertices = (0..8).map(|i| corner(i) * size + DVec3::from_array(center)).collect();
    let faces = [
        [0, 1, 3],
        [0, 3, 2],
        [4, 6, 7],
        [4, 7, 5],
        [0, 4, 5],
        [0, 5, 1],
        [2, 3, 7],
        [2, 7, 6],
        [0, 2, 6],
        [0, 6, 4],
        [1, 5, 7],
        [1, 7, 3],
    ];
    (vertices, faces.to_vec())
}

fn inside_out((vertices, faces): (Vec<DVec3>, Vec<[u32; 3]>)) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    (vertices, faces.into_iter().map(|[a, b, c]| [a, c, b]).collect())
}

/// Returns the text of an OBJ file of several parts.
fn obj(parts: &[(Vec<DVec3>, Vec<[u32; 3]>)]) -> String {
    let (mut text, mut first) = (String::new(), 1);
    for (vertices, faces) in parts {
        vertices.iter().for_each(|p| writeln!(text, "v {} {} {}", p.x, p.y, p.z).unwrap());
        faces.iter().for_each(|f| writeln!(text, "f {} {} {}", f[0] + first, f[1] + first, f[2] + first).unwrap());
        first += vertices.len() as u32;
    }
    text
}

/// Returns the facets of a part.
fn facets((vertices, faces): &(Vec<DVec3>, Vec<[u32; 3]>)) -> Vec<[DVec3; 3]> {
    faces.iter().map(|f| f.map(|v| vertices[v as usize])).collect()
}

fn ascii_stl(facets: &[[DVec3; 3]]) -> String {
    let mut text = "solid part\n".to_string();
    for f in facets {
        text += " facet normal 0 0 0\n  outer loop\n";
        f.iter().for_each(|p| writeln!(text, "   vertex {:e} {:e} {:e}", p.x, p.y, p.z).unwrap());
        text += "  endloop\n endfacet\n";
    }
    text + "endsolid part\n"
}

fn binary_stl(facets: &[[DVec3; 3]], count: u32, trailing: &[u8]) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend(count.to_le_bytes());
    for f in facets {
        bytes.extend([0; 12]);
        f.iter().flat_map(|p| p.to_array()).for_each(|x| bytes.extend((x as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes.extend(trailing);
    bytes
}

/// Builds the model of a scene with the file as its object and `more` fields of the object.
fn build(name: &str, content: impl AsRef<[u8]>, more: &str) -> Result<Arc<Model>> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, content).unwrap();
    model(&path, more)
}

fn model(object: &Path, more: &str) -> Result<Arc<Model>> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ron");
    let text = format!(
        "(object: (shape: Mesh({object:?}), {more}), gripper: (pads: GelSightMini(spacing: 5e-3)), \
         loading: Squeeze(force: 2.0, frames: 1))"
    );
    std::fs::write(&path, text).unwrap();
    Model::build(&load(&path)?.scene)
}

/// Reads a file as an object; returns its volume, cm3, and the notices.
fn volume(name: &str, content: impl AsRef<[u8]>, more: &str) -> (f64, String) {
    let model = build(name, content, more).unwrap_or_else(|e| panic!("{name}: {e}"));
    (model.object.mass.volume * 1e6, model.notices.join("\n"))
}

/// Asserts that a file is refused with a message that contains its name and all `parts`.
fn refused(name: &str, content: impl AsRef<[u8]>, more: &str, parts: &[&str]) {
    let message = match build(name, content, more) {
        Ok(model) => panic!("{name} was read, with {:e} m3", model.object.mass.volume),
        Err(error) => error.to_string(),
    };
    assert!(message.contains(name), "no file name in: {message}");
    parts.iter().for_each(|part| assert!(message.contains(part), "`{part}` is not in: {message}"));
}

/// Relative tolerance for the rounding of sums over a dozen triangles.
const EXACT: f64 = 1e-12;

#[test]
fn shells_are_turned_by_where_they_lie() {
    let (hollow, said) = volume("hollow.obj", obj(&[cube([0.0; 3], 0.03), cube([0.0; 3], 0.02)]), "");
    assert_relative_eq!(hollow, 19.0, max_relative = EXACT);
    assert!(said.contains("oriented 1 of 2 closed parts of the surface inward: they are inside others"), "{said}");
    let right = obj(&[cube([0.0; 3], 0.03), inside_out(cube([0.0; 3], 0.02))]);
    let (same, said) = volume("hollow.obj", right, "");
    assert_relative_eq!(same, 19.0, max_relative = EXACT);
    assert!(!said.contains("closed parts of the surface"), "{said}");
    // A solid inside the cavity is oriented outwards.
    let nested = [cube([0.0; 3], 0.03), cube([0.0; 3], 0.02), inside_out(cube([0.0; 3], 0.01))];
    assert_relative_eq!(volume("nested.obj", obj(&nested), "").0, 20.0, max_relative = EXACT);
    let apart = obj(&[cube([0.0; 3], 0.02), inside_out(cube([0.0, 0.03, 0.0], 0.02))]);
    let (two, said) = volume("apart.obj", apart, "");
    assert_relative_eq!(two, 16.0, max_relative = EXACT);
    assert!(said.contains("reversed 1 of 2 closed parts of the surface, which were oriented inward"), "{said}");
    let mut odd = cube([0.0; 3], 0.03);
    odd.1[4].swap(0, 1);
    let (one, said) = volume("odd.obj", obj(&[odd]), "");
    assert_relative_eq!(one, 27.0, max_relative = EXACT);
    assert!(said.contains("reversed 1 triangle that disagreed with its neighbours"), "{said}");
}

#[test]
fn overlaps_are_refused_with_their_place() {
    let cross = ["two parts of the surface overlap: its triangles ", " cross near (", "or set `repair: true`"];
    // Coplanar faces; general position; a corner on a diagonal.
    for shift in [[0.0, 0.01, 0.0], [0.003, 0.007, 0.004], [0.01, 0.01, 0.01]] {
        refused("overlap.obj", obj(&[cube([0.0; 3], 0.02), cube(shift, 0.02)]), "", &cross);
    }
    // A cube through the wall of another, and one that penetrates it by a tenth of a millimetre.
    refused("through.obj", obj(&[cube([0.0; 3], 0.03), cube([0.015, 0.001, 0.002], 0.01)]), "", &cross);
    refused("dent.obj", obj(&[cube([0.0; 3], 0.02), cube([0.0149, 0.001, 0.002], 0.01)]), "", &cross);
    // Touching parts do not overlap: face on face, edge on edge, corner on corner.
    for shift in [[0.0, 0.0, 0.02], [0.0, 0.02, 0.007], [0.02, 0.02, 0.007], [0.02, 0.02, 0.02]] {
        let (both, _) = volume("touch.obj", obj(&[cube([0.0; 3], 0.02), cube(shift, 0.02)]), "");
        assert_relative_eq!(both, 16.0, max_relative = 1e-9);
    }
    // A self-intersecting surface: one corner of a cube displaced through the opposite face.
    let mut pushed = cube([0.0; 3], 0.02);
    pushed.0[7] = DVec3::new(-0.02, -0.004, -0.003);
    refused("pushed.obj", obj(&[pushed]), "", &["the surface passes through itself: its triangles "]);
    // An overlap of a micrometre in a part of 20 mm is accepted with a notice.
    let (folded, said) = volume("folded.obj", obj(&[cube([0.0; 3], 0.02), cube([0.014999, 0.001, 0.002], 0.01)]), "");
    assert_relative_eq!(folded, 9.0, max_relative = 1e-4);
    assert!(said.contains("pairs of triangles cross, none by more than"), "{said}");
}

/// Returns an OBJ of an L-shaped prism with a cross-section of five 10 mm squares, 30 mm high. Its two caps are concave
/// hexagons that begin at corner `first`; `points` adds a vertex on a straight side.
fn l_prism(first: usize, points: bool) -> String {
    let mut outline = vec![(0.0, 0.0), (0.03, 0.0), (0.03, 0.01), (0.01, 0.01), (0.01, 0.03), (0.0, 0.03)];
    if points {
        outline.insert(1, (0.017, 0.0));
    }
    outline.rotate_left(first);
    let (n, mut text) = (outline.len(), String::new());
    for z in [-0.015, 0.015] {
        outline.iter().for_each(|(x, y)| writeln!(text, "v {} {} {z}", x - 0.01, y - 0.01).unwrap());
    }
    let numbers = |list: &[usize]| list.iter().map(|i| format!(" {}", i + 1)).collect::<String>();
    writeln!(text, "f{}", numbers(&(0..n).rev().collect::<Vec<_>>())).unwrap();
    writeln!(text, "f{}", numbers(&(n..2 * n).collect::<Vec<_>>())).unwrap();
    for i in 0..n {
        let j = (i + 1) % n;
        writeln!(text, "f{}", numbers(&[i, j, j + n, i + n])).unwrap();
    }
    text
}

#[test]
fn concave_polygons_keep_their_outline() {
    for first in 0..6 {
        let (l, _) = volume("l.obj", l_prism(first, false), "");
        assert_relative_eq!(l, 15.0, max_relative = EXACT);
        assert_relative_eq!(volume("l.obj", l_prism(first, true), "").0, 15.0, max_relative = EXACT);
    }
    // A frame of 20 mm around a hole of 10 mm, 10 mm thick: each cap is one polygon, with a slit to its hole.
    let mut text = String::new();
    for z in [0.0, 0.01] {
        for r in [0.01, 0.005] {
            for (x, y) in [(-r, -r), (r, -r), (r, r), (-r, r)] {
                writeln!(text, "v {x} {y} {z}").unwrap();
            }
        }
    }
    text += "f 9 10 11 12 9 13 16 15 14 13\nf 4 3 2 1 5 6 7 8 5 1\n";
    for (i, j) in [(1, 2), (2, 3), (3, 4), (4, 1)] {
        writeln!(text, "f {i} {j} {} {}\nf {} {} {} {}", j + 8, i + 8, j + 4, i + 4, i + 12, j + 12).unwrap();
    }
    assert_relative_eq!(volume("frame.obj", text, "").0, 3.0, max_relative = EXACT);
}

#[test]
fn an_l_prism_can_be_squeezed() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = folder.path().join("l.obj");
    std::fs::write(&mesh, l_prism(5, false)).unwrap();
    let (status, reason) = squeeze(&mesh, "");
    assert_eq!(status, Status::Reached, "{reason}");
}

/// Squeezes an object with 2 N between coarse pads; returns the status and its reason.
fn squeeze(mesh: &Path, more: &str) -> (Status, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ron");
    let text = format!(
        "(object: (shape: Mesh({mesh:?})), gripper: (pads: GelSightMini(spacing: 5e-3), opening: 0.1, stroke: 0.05), {more} \
         loading: Squeeze(force: 2.0, frames: 1))"
    );
    std::fs::write(&path, text).unwrap();
    let scene = load(&path).unwrap().scene;
    let model = Model::build(&scene).unwrap();
    let poses = grasp_poses(&scene).unwrap();
    let outcome = run_grasps(&model, choose(&scene).unwrap().as_ref(), &[(0, poses[0])], 1, &()).unwrap();
    let summary = &outcome[0].summary;
    (summary.status, summary.reason.clone().unwrap_or_default())
}

#[test]
fn units_are_asked_for() {
    let millimetres = obj(&[cube([0.0; 3], 30.0)]);
    refused(
        "mm.obj",
        &millimetres,
        "",
        &["the object is 30 m wide", "if the file is in millimetres, write `scale: 1e-3`"],
    );
    assert_relative_eq!(volume("mm.obj", &millimetres, "scale: 1e-3").0, 27.0, max_relative = EXACT);
    // The limits apply to the scaled object.
    assert_relative_eq!(volume("um.obj", obj(&[cube([0.0; 3], 3e4)]), "scale: 1e-6").0, 27.0, max_relative = EXACT);
    refused("far.obj", obj(&[cube([2e3, 0.0, 0.0], 0.03)]), "", &["from the origin of its file", "within 1000 m"]);
    // The number of contact vertices grows with the length of edges; too many are refused before they are created.
    let large = build("ok.obj", obj(&[cube([0.0; 3], 1.9)]), "").expect("12 edges of 1.9 m");
    assert!(large.features.len() < 100_000, "{} points", large.features.len());
    let rod = |i: i32| {
        let (vertices, faces) = cube([0.0; 3], 0.01);
        (
            vertices.into_iter().map(|p| DVec3::new(p.x + 0.03 * f64::from(i), p.y, 190.0 * p.z)).collect::<Vec<_>>(),
            faces,
        )
    };
    let message =
        build("rods.obj", obj(&(0..60).map(rod).collect::<Vec<_>>()), "").map(|_| ()).unwrap_err().to_string();
    assert!(message.contains("the rods has 1") && message.contains("at most 1000000 are allowed"), "{message}");
}

#[test]
fn what_rounding_pulled_apart_is_welded() {
    let mut near = facets(&cube([0.0; 3], 0.03));
    near[0][0].x += 1e-9;
    near[7][2].y -= 2e-9;
    for (name, content) in [("near.stl", ascii_stl(&near).into_bytes()), ("near32.stl", binary_stl(&near, 12, &[]))] {
        let (volume, said) = volume(name, content, "");
        assert_relative_eq!(volume, 27.0, max_relative = 1e-6);
        assert!(
            said.contains("at open edges with others within 4.57") && said.contains("e-8 m (1e-6 of the object's size"),
            "{said}"
        );
    }
    // A gap of a micrometre is above the tolerance and is refused.
    near[0][0].x += 1e-6;
    refused("gap.stl", ascii_stl(&near), "", &["is open: ", "`repair: true`"]);
    // The same part ten times larger: the tolerance scales with the size.
    let large: Vec<_> = near.iter().map(|f| f.map(|p| 10.0 * p)).collect();
    refused("gap.stl", ascii_stl(&large), "", &["is open: "]);
}

/// A stray facet far away, as in scans, is refused and does not change the welding tolerance, which derives from the
/// edges of the mesh.
#[test]
fn a_facet_far_away_changes_nothing_and_is_refused() {
    // A sphere of radius 20 mm as unconnected triangles whose corners are up to 1e-9 m apart.
    let ball = ShapeKind::Sphere { radius: 0.02 }.build(32).unwrap().surface;
    let corners = ball.triangles.iter().flatten().enumerate();
    let mut soup = TriMesh {
        vertices: corners
            .map(|(k, v)| ball.vertices[*v as usize] + 1e-9 * DVec3::new((k % 2) as f64, 0.0, 0.0))
            .collect(),
        triangles: (0..ball.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
    };
    let tolerance = weld::tolerance(&soup);
    assert!((0.5..2.0).contains(&(tolerance / 0.05e-6)), "1e-6 of 40 mm and the rounding, not {tolerance:e} m");
    let text = |mesh: &TriMesh| obj(&[(mesh.vertices.clone(), mesh.triangles.clone())]);
    let (whole, _) = volume("ball.obj", text(&soup), "");
    assert_relative_eq!(whole, 33.5, max_relative = 0.02);
    for (away, says) in [(1e4, "its vertex"), (1e30, "within 1e9")] {
        let mut stray = soup.clone();
        let n = stray.vertices.len() as u32;
        stray.vertices.extend([DVec3::ZERO, 1e-6 * DVec3::Y, 1e-6 * DVec3::Z].map(|p| p + away * DVec3::X));
        stray.triangles.push([n, n + 1, n + 2]);
        assert_relative_eq!(weld::tolerance(&stray), tolerance, max_relative = 0.1);
        refused("stray.obj", text(&stray), "", &[says]);
        refused("stray.obj", text(&stray), "repair: true", &[says]);
    }
    // A vertex of the surface itself.
    soup.vertices[0].x = 1e4;
    refused(
        "spike.obj",
        text(&soup),
        "repair: true",
        &["its vertex 0 (0-based)", "from the middle of the others: remove it"],
    );
}

/// A one-sided surface has no inside, so that no repair can be correct; it is refused.
#[test]
fn a_moebius_strip_is_refused() {
    let turns = 40;
    let mut strip = (Vec::new(), Vec::new());
    for i in 0..turns {
        let about = TAU * f64::from(i) / f64::from(turns);
        let out = DVec3::new(about.cos(), about.sin(), 0.0);
        let across = (0.5 * about).cos() * out + (0.5 * about).sin() * DVec3::Z;
        strip.0.extend([0.02 * out - 0.005 * across, 0.02 * out + 0.005 * across]);
        let (a, b) = (2 * i, 2 * i + 1);
        let (c, d) = if i + 1 < turns { (a + 2, b + 2) } else { (1, 0) };
        strip.1.extend([[a, c, b], [b, c, d]].map(|t: [i32; 3]| t.map(|v| v as u32)));
    }
    refused("moebius.obj", obj(&[strip.clone()]), "", &["is open"]);
    refused("moebius.obj", obj(&[strip]), "repair: true", &["is one-sided", "it encloses no volume"]);
}

#[test]
fn other_spellings_of_stl_are_read() {
    let part = facets(&cube([0.0; 3], 0.03));
    let text = ascii_stl(&part);
    let bom = [b"\xef\xbb\xbf".as_slice(), text.as_bytes()].concat();
    let cases: [(Vec<u8>, &str); 7] = [
        (text.to_uppercase().into_bytes(), ""),
        (bom, ""),
        (binary_stl(&part, 12, &[]), ""),
        (binary_stl(&part, 12, &[0, 0]), "ignored 2 bytes after the 12 facets"),
        (binary_stl(&part, 12, &[7; 1234]), "ignored 1234 bytes after the 12 facets"),
        (binary_stl(&part, 13, &[]), "the header counts 13 facets, but the file contains 12"),
        (binary_stl(&part, 10, &[]), "the header counts 10 facets, but the file contains 12"),
    ];
    for (content, news) in cases {
        let (volume, said) = volume("part.stl", content, "");
        assert_relative_eq!(volume, 27.0, max_relative = 1e-6);
        assert!(said.contains(news) && (!news.is_empty() || !said.contains("part.stl:")), "{said}");
    }
    refused(
        "lie.stl",
        binary_stl(&part, 4_000_000_000, &[]),
        "",
        &["truncated: its binary header declares 4000000000 facets"],
    );
}

#[test]
fn what_adds_nothing_is_dropped() {
    let (vertices, faces) = cube([0.0; 3], 0.03);
    let with = |more: &[[u32; 3]]| obj(&[(vertices.clone(), [faces.clone(), more.to_vec()].concat())]);
    let cases = [
        (with(&[faces[0]]), "dropped 1 repeated triangle"),
        (with(&[[faces[3][1], faces[3][2], faces[3][0]]]), "dropped 1 repeated triangle"),
        (with(&[[0, 0, 1]]), "dropped 1 triangle with a repeated vertex"),
        (format!("{}v 1 1 1\n", with(&[])), "welded 1 duplicate or unused vertex"),
        // Three collinear corners.
        (format!("{}v 0.2 0 0\nv 0.3 0 0\nv 0.4 0 0\nf 9 10 11\n", with(&[])), "removed 1 triangle without area"),
    ];
    for (text, news) in cases {
        let (volume, said) = volume("part.obj", text, "");
        assert_relative_eq!(volume, 27.0, max_relative = EXACT);
        assert!(said.contains(news), "`{news}` is not in: {said}");
    }
    // A vertex on an edge of one face (T-junction), connected to the other face by a triangle of zero area.
    let split = "v 0 0 0\nv 0.03 0 0\nv 0 0.03 0\nv 0 0 0.03\nv 0.01 0 0\nf 1 3 5\nf 5 3 2\nf 1 2 4\nf 1 5 2\nf 1 4 3\nf 2 3 4\n";
    let (tetrahedron, said) = volume("split.obj", split, "");
    assert_relative_eq!(tetrahedron, 4.5, max_relative = EXACT);
    assert!(said.contains("removed 1 triangle without area"), "{said}");
}

#[test]
fn sheets_are_refused_by_name() {
    let sheet = "v -0.02 -0.02 0\nv 0.02 -0.02 0\nv 0.02 0.02 0\nv -0.02 0.02 0\nf 1 2 3\nf 1 3 4\nf 1 3 2\nf 1 4 3\n";
    refused("sheet.obj", sheet, "", &["it is a sheet, which encloses no volume; give it a thickness"]);
    let beside =
        format!("{}v 0.1 0 0\nv 0.1 0.01 0\nv 0.1 0 0.01\nf 9 10 11\nf 9 11 10\n", obj(&[cube([0.0; 3], 0.03)]));
    let (cube_alone, said) = volume("beside.obj", beside, "");
    assert_relative_eq!(cube_alone, 27.0, max_relative = EXACT);
    assert!(said.contains("dropped 1 pair of coincident triangles"), "{said}");
    // Two pyramids of zero height on one base.
    let flat = "v 0 0 0\nv 0.03 0 0\nv 0 0.03 0\nv 0.01 0.01 0\nv 0.005 0.01 0\nf 1 2 4\nf 2 3 4\nf 3 1 4\nf 2 1 5\nf 3 2 5\nf 1 3 5\n";
    refused("flat.obj", flat, "", &["it is closed but encloses no volume, about (0.015"]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flat.ron");
    std::fs::write(
        &path,
        "(object: (shape: Revolve(profile: [(0, 0), (0.02, 0), (0, 0)])), loading: Squeeze(force: 4.0, frames: 3))",
    )
    .unwrap();
    let message = load(&path).and_then(|l| Model::build(&l.scene)).unwrap_err().to_string();
    assert!(message.contains("encloses no volume"), "{message}");
}

#[test]
fn every_keyword_of_obj_is_known() {
    let mut text =
        "mg 1 0.5\nbevel on\nc_interp off\nd_interp off\nlod 2\ncstype bspline\ndeg 2\nparm u 0 1 \\\n 2\nend\n"
            .to_string();
    text += &obj(&[cube([0.0; 3], 0.03)])
        .replace("f 1 2 4\n", "f 1 2 \\\n  4\n")
        .replace("f 1 4 3\n", "f 1/1 4/2\\\n 3/3\n");
    text += "curv 0 1 1 2\nsurf 0 1 0 1 1 2 3 4\ntrim 0 1 1\n";
    let (volume, said) = volume("words.obj", text, "");
    assert_relative_eq!(volume, 27.0, max_relative = EXACT);
    assert!(
        said.contains("ignored 12 lines that do not describe flat faces: bevel, c_interp, cstype, curv, d_interp"),
        "{said}"
    );
    refused("call.obj", "call other.obj\n", "", &["line 1, column 1: unknown keyword `call`"]);
}

/// Returns a PLY file of the cube with quadrilaterals and a colour per vertex.
fn ply(format: &str) -> Vec<u8> {
    let (vertices, _) = cube([0.0; 3], 0.03);
    let quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3_u32]];
    let mut bytes = format!(
        "ply\nformat {format} 1.0\ncomment made here\nelement vertex 8\nproperty float x\nproperty float y\nproperty double z\n\
         property uchar red\nelement face 6\nproperty list uchar int vertex_indices\nend_header\n"
    )
    .into_bytes();
    let little = format == "binary_little_endian";
    let put = |bytes: &mut Vec<u8>, mut number: Vec<u8>| {
        if !little {
            number.reverse();
        }
        bytes.extend(number);
    };
    for p in vertices {
        if format == "ascii" {
            bytes.extend(format!("{} {} {} 255\n", p.x, p.y, p.z).bytes());
            continue;
        }
        [p.x, p.y].iter().for_each(|x| put(&mut bytes, (*x as f32).to_le_bytes().to_vec()));
        put(&mut bytes, p.z.to_le_bytes().to_vec());
        bytes.push(255);
    }
    for q in quads {
        if format == "ascii" {
            bytes.extend(format!("4 {} {} {} {}\n", q[0], q[1], q[2], q[3]).bytes());
            continue;
        }
        bytes.push(4);
        q.iter().for_each(|i| put(&mut bytes, i.to_le_bytes().to_vec()));
    }
    bytes
}

#[test]
fn ply_is_read_in_all_three_forms() {
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        let (volume, said) = volume("part.ply", ply(format), "");
        assert_relative_eq!(volume, 27.0, max_relative = 1e-6);
        assert!(said.contains("split 6 polygons into triangles"), "{said}");
        let mut cut = ply(format);
        cut.truncate(cut.len() - 9);
        refused("cut.ply", cut, "", &["the PLY file cannot be read"]);
    }
    let cloud = String::from_utf8(ply("ascii")).unwrap();
    let cloud = cloud.split("4 0 1 3 2").next().unwrap().replace("element face 6", "element face 0");
    refused("cloud.ply", cloud, "", &["8 vertices and no faces; create a surface from the point cloud first"]);
    refused(
        "wrong.ply",
        String::from_utf8(ply("ascii")).unwrap().replace("4 0 1 3 2", "4 0 1 3 9"),
        "",
        &["refers to vertex 9"],
    );
    refused("none.ply", "no ply", "", &["the PLY file cannot be read"]);
    refused(
        "huge.ply",
        "ply\nformat ascii 1.0\nelement vertex 99999999999\nproperty float x\nend_header\n",
        "",
        &["at most 5000000"],
    );
    refused("part.step", "ISO-10303-21;", "", &["allowed: .obj, .stl, .ply", "export it as STL"]);
}

#[test]
fn repair_makes_a_solid_and_says_how_far_it_moved() {
    let overlap = obj(&[cube([0.0; 3], 0.02), cube([0.0, 0.01, 0.0], 0.02)]);
    let (union, said) = volume("overlap.obj", overlap, "repair: true");
    eprintln!("{union} cm3\n{said}");
    assert_relative_eq!(union, 12.0, max_relative = 0.02);
    assert!(
        said.contains("repaired: two parts of the surface overlap") && said.contains("the surface moved by at most"),
        "{said}"
    );
    // The hole of an open cube is filled without moving any vertex.
    let mut open = cube([0.0; 3], 0.03);
    open.1.drain(2..4);
    let (closed, said) = volume("open.obj", obj(&[open.clone()]), "repair: true");
    assert_relative_eq!(closed, 27.0, max_relative = EXACT);
    assert!(said.contains("filled 1 hole with 2 triangles of 9.000e-4 m2 in all; nothing else moved"), "{said}");
    refused("open.obj", obj(&[open.clone()]), "", &["is open: 4 edges with one triangle only", "`repair: true`"]);
    // A fin: an edge with three triangles.
    let mut fin = cube([0.0; 3], 0.03);
    fin.0.push(DVec3::new(-0.03, -0.03, 0.0));
    fin.1.push([0, 1, 8]);
    let (trimmed, said) = volume("fin.obj", obj(&[fin]), "repair: true");
    assert_relative_eq!(trimmed, 27.0, max_relative = 0.02);
    assert!(said.contains("remeshed from its winding number"), "{said}");
    // A valid surface is unchanged; a sheet cannot be repaired.
    let whole = obj(&[cube([0.0; 3], 0.03)]);
    let (plain, mended) = (build("ok.obj", &whole, "").unwrap(), build("ok.obj", &whole, "repair: true").unwrap());
    assert_eq!(plain.object.surface, mended.object.surface);
    let sheet = "v -0.02 -0.02 0\nv 0.02 -0.02 0\nv 0.02 0.02 0\nf 1 2 3\nf 1 3 2\n";
    refused("sheet.obj", sheet, "repair: true", &["encloses no volume"]);
}

/// Returns the paths of all real object meshes.
fn real_objects() -> Vec<PathBuf> {
    let mut folders: Vec<PathBuf> = ["objects", "indenters"].into_iter().filter_map(data).collect();
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        for path in std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()) {
            let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
            if path.is_dir() {
                folders.push(path);
            } else if ["obj", "stl", "ply"].contains(&extension.as_str()) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

#[test]
fn real_objects_load_and_close_or_say_what_to_do() {
    for path in real_objects() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("scene.ron");
        let text = format!(
            "(object: (shape: Mesh({path:?})), gripper: (pads: GelSightMini(spacing: 5e-3), opening: 0.15, stroke: 0.075), \
             grasps: Antipodal(count: 1, seed: 1), loading: Squeeze(force: 2.0, frames: 1))"
        );
        std::fs::write(&file, text).unwrap();
        let scene = load(&file).unwrap().scene;
        let name = path.display();
        let model = match Model::build(&scene) {
            Ok(model) => model,
            Err(error) => {
                let message = error.to_string();
                eprintln!("{message}");
                assert!(message.contains("`repair: true`") || message.contains("`scale: "), "{message}");
                continue;
            }
        };
        let litres = model.object.mass.volume * 1e3;
        assert!((1e-4..2.0).contains(&litres), "{name}: {litres} l");
        let pose = match grasp_poses(&scene) {
            Ok(poses) => poses[0],
            Err(error) => {
                eprintln!("{name}: {error}");
                continue;
            }
        };
        let mut environment = Environment::new(&model, choose(&scene).unwrap().as_ref(), pose).unwrap();
        while matches!(environment.phase(), Phase::Place | Phase::Close) {
            environment.step();
        }
        if let Phase::Infeasible { reason } = environment.phase() {
            panic!("{name}: {reason}");
        }
    }
}

#[test]
fn some_real_objects_are_squeezed() {
    let squeezed = ["lemon02_processed.stl", "cup04_processed.stl", "rubiks_cube.obj"];
    for path in real_objects().into_iter().filter(|p| squeezed.iter().any(|s| p.ends_with(s))) {
        let (status, reason) = squeeze(&path, "grasps: Antipodal(count: 1, seed: 1),");
        eprintln!("{}: {status:?} {reason}", path.display());
        assert!(status == Status::Reached || !reason.is_empty(), "{}: {status:?}", path.display());
    }
}
