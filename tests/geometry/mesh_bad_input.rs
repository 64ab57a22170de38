//! Malformed mesh files are refused, without panic, with a message that states location, allowed values and remedy.

use std::fs;
use std::path::PathBuf;

use tactus::geometry::mesh::io;

/// Reads `content` as a file called `name` and returns the error message.
fn refusal(name: &str, content: impl AsRef<[u8]>) -> String {
    let dir = tempfile::tempdir().expect("temporary folder");
    let path = dir.path().join(name);
    fs::write(&path, content).expect("write test file");
    let triangles = name.ends_with("obj") || name.ends_with("stl");
    let result = if triangles {
        io::read_tri_mesh(&path).map(|(m, _)| m.triangles.len())
    } else {
        io::read_tet_mesh(&path).map(|(m, _)| m.tets.len())
    };
    match result {
        Ok(n) => panic!("{name} was accepted with {n} elements"),
        Err(e) => e.to_string(),
    }
}

/// Asserts that reading `content` as `name` is refused with a message naming the file and containing all `parts`.
fn refused(name: &str, content: impl AsRef<[u8]>, parts: &[&str]) {
    let message = refusal(name, content);
    assert!(message.contains(name), "no file name in: {message}");
    for part in parts {
        assert!(message.contains(part), "`{part}` is not in: {message}");
    }
}

const NODES: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";

fn tet(rest: &str) -> String {
    format!("{NODES}{rest}")
}

#[test]
fn tet_files() {
    refused("a.tet", "v 0 0\n", &["line 1, column 5: ", "3 columns", "allowed: 4 or 5"]);
    refused("b.tet", "# c\n\nv 0 0 nan\n", &["line 3, column 7: z is NaN", "finite"]);
    refused("c.tet", "v 0 1e999 0\n", &["line 1, column 5: y is inf"]);
    refused("d.tet", "v 0 zero 0\n", &["line 1, column 5: y `zero` is not a number"]);
    refused("e.tet", tet("t 0 1 2 4\n"), &["line 5, column 9: tetrahedron 0 refers to node 4", "allowed: 0..=3"]);
    refused("f.tet", tet("t 0 1 2 -1\n"), &["line 5, column 9: node index `-1` is not a whole number >= 0"]);
    refused("g.tet", tet("t 0 1 2\n"), &["line 5, column 7: ", "4 columns; allowed: 5"]);
    refused("h.tet", tet("q 0 1 2 3\n"), &["line 5, column 1: a line starts with `q`; allowed: `v`, `t`, `#`"]);
    refused("i.tet", "", &["the mesh is empty: 0 nodes"]);
    refused("j.tet", NODES, &["the mesh is empty: 4 nodes", "0 tetrahedra"]);
    refused("k.tet", b"\x7fELF\x00\x01\x02", &["binary content (a zero byte at offset 4)"]);
    refused("l.tet", tet("t 0 1 2 18446744073709551616\n"), &["line 5, column 9: ", "not a whole number"]);
    refused("m.tet", tet("t 0 1 2 4294967296\n"), &["refers to node 4294967296"]);
}

#[test]
fn unfit_tetrahedra() {
    refused("a.tet", tet("t 0 1 2 2\n"), &["tetrahedron 0 (0-based) uses node 2 twice, at (0.000000, 1.000000"]);
    let flat = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nt 0 1 2 4\nt 0 1 2 3\n";
    refused("b.tet", flat, &["tetrahedron 1 (0-based)", "is flat: volume 0.000e0 m^3", "centroid (0.500000, 0.500000"]);
    let three = tet("v 0 0 2\nv 0 0 3\nt 0 1 2 3\nt 0 1 2 4\nt 0 1 2 5\n");
    refused("c.tet", three, &["the face of nodes [0, 1, 2]", "shared by 3 tetrahedra (0, 1, 2); at most 2"]);
    let folded = tet("v 0.1 0.1 2\nt 0 1 2 3\nt 0 1 2 4\n");
    refused("e.tet", folded, &["the face of nodes [0, 1, 2]", "2 tetrahedra (0, 1) on the same side of it"]);
    let far = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1e30\nt 0 1 2 3\n";
    refused("f.tet", far, &["node 3 (0-based) is [0, 0, 1000", "within 1e9"]);
    let coincident = tet("v 0 0 1\nt 0 1 3 4\n");
    refused("d.tet", coincident, &["uses node"]);
}

#[test]
fn gmsh_files() {
    let v2 = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
    let v4 = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
    refused(
        "a.msh",
        "$MeshFormat\n4.1 1 8\n",
        &["the file ends where the 1 that indicates the byte order should follow"],
    );
    refused("b.msh", "$MeshFormat\n3.0 0 8\n", &["line 2, column 1: gmsh format `3.0`; allowed: 2.2, 4.0 or 4.1"]);
    refused("c.msh", "$Nodes\n1\n", &["line 1, column 1: ", "must come first"]);
    let huge = format!("{v2}$Nodes\n99999999999\n");
    refused("d.msh", huge, &["line 5, column 1: the number of nodes 99999999999", "5000000 allowed"]);
    refused("e.msh", format!("{v2}$Nodes\n2\n1 0 0 0\n"), &["the file ends where a node"]);
    let twice = format!("{v2}$Nodes\n2\n7 0 0 0\n7 1 0 0\n");
    refused("f.msh", twice, &["line 7, column 1: node tag 7 is used twice"]);
    let nodes = "$Nodes\n1\n7 0 0 0\n$EndNodes\n";
    let unknown = format!("{v2}{nodes}$Elements\n1\n1 4 2 0 0 7 8 9 10\n$EndElements\n");
    refused("g.msh", unknown, &["line 10, column 13: tetrahedron 0 refers to node tag 8"]);
    let triangles = format!("{v2}{nodes}$Elements\n1\n1 2 2 0 0 7 7 7\n$EndElements\n");
    refused("h.msh", triangles, &["the mesh is empty", "found 1 of type 2"]);
    let short = format!("{v4}$Nodes\n1 1 1 1\n3 0 0 1\n1\n0 0\n");
    refused("i.msh", short, &["line 8, column 3: node coordinates has 2 columns"]);
    let extra = format!("{v4}$Nodes\n0 0 0 0\n5 5 5\n$EndNodes\n");
    let fewer = format!("{v4}$Nodes\n1 2 1 2\n3 0 0 1\n1\n0 0 0\n$EndNodes\n");
    refused("m.msh", fewer, &["line 5, column 3: 2 nodes declared, but the blocks contain 1"]);
    // The header declares nine elements more than the file has, as in a truncated or edited file.
    let tetrahedron = "$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n$EndNodes\n$Elements\n";
    let nine = format!("{v4}{tetrahedron}1 10 1 10\n3 1 4 1\n1 1 2 3 4\n$EndElements\n");
    refused("n.msh", nine, &["line 17, column 3: 10 elements declared, but the blocks contain 1"]);
    refused("j.msh", extra, &["line 6, column 1: expected `$EndNodes`"]);
    refused("k.msh", "hello\n", &["line 1, column 1: expected a section", "`hello`"]);
    refused("l.msh", "", &["no `$MeshFormat` section"]);
}

#[test]
fn medit_files() {
    let head = "MeshVersionFormatted 1\nDimension 3\n";
    refused("a.mesh", "Vertices 1\n", &["line 1, column 1: a Medit file starts with"]);
    refused("b.mesh", "MeshVersionFormatted 1\nDimension 2\n", &["line 2, column 11: dimension `2`; allowed: 3"]);
    let huge = format!("{head}Vertices 9999999999\n");
    refused("c.mesh", huge, &["line 3, column 10: the number of vertices 9999999999"]);
    refused("d.mesh", format!("{head}Vertices 2\n0 0 0 0\n1 1"), &["the file ends where a vertex"]);
    let zero = format!("{head}Vertices 1\n0 0 0 0\nTetrahedra 1\n0 1 1 1 0\nEnd\n");
    refused("e.mesh", zero, &["line 6, column 1: tetrahedron 0 refers to node 0; Medit counts nodes from 1"]);
    let high = format!("{head}Vertices 1\n0 0 0 0\nTetrahedra 1\n1 1 1 2 0\nEnd\n");
    refused("f.mesh", high, &["line 6, column 7: tetrahedron 0 refers to node 2", "allowed: 1..=1"]);
    refused("g.mesh", format!("{head}Flowers 3\n"), &["the mesh is empty", "it also has 3 `Flowers`"]);
}

#[test]
fn triangle_files() {
    refused("a.obj", "v 0 0 0\nf 1 2 3\n", &["line 2, column 5: triangle 0 refers to vertex 2", "allowed: 1..=1"]);
    refused("b.obj", "v 0 0 0\nf 0 1 1\n", &["refers to vertex 0"]);
    refused("c.obj", "v 0 0 0\nf 1 1\n", &["line 2, column 1: a face of 2 vertices"]);
    refused("d.obj", "v 0 0 inf\n", &["line 1, column 7: z is inf"]);
    refused("e.obj", "v 0 0 0\n", &["the mesh is empty: 1 vertex (`v`"]);
    refused("f.obj", "v 0 0 0\nf 1 1 1\n", &["every triangle has a repeated vertex"]);
    refused("g.obj", "x 1\n", &["line 1, column 1: unknown keyword `x`; allowed: v, f"]);
    refused("h.obj", "v 0 0 0\nf 1 -2 1\n", &["refers to vertex -2"]);
    refused("a.stl", "nothing", &["not an STL file: 7 bytes"]);
    refused("b.stl", [0xff_u8; 200], &["declares 4294967295 facets", "but it has 200 bytes"]);
    refused("c.stl", "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 x\n", &["line 4, column 12: z `x` is not"]);
    refused("d.stl", "solid s\nvertex 0 0 0\nendfacet\n", &["line 3, column 1: a facet without exactly 3"]);
    refused("e.stl", "solid s\nendsolid s\n", &["the mesh is empty"]);
    let mut nan = vec![0_u8; 80];
    nan.extend(1_u32.to_le_bytes());
    nan.extend([0_u8; 12]);
    nan.extend(f32::NAN.to_le_bytes());
    nan.extend([0_u8; 34]);
    refused("f.stl", nan, &["facet 0 (0-based) has the vertex [NaN, 0, 0]"]);
}

#[test]
fn missing_files_folders_and_unknown_types() {
    let dir = tempfile::tempdir().expect("temporary folder");
    let message = |p: PathBuf| io::read_tet_mesh(p).expect_err("must be refused").to_string();
    assert!(message(dir.path().join("none.tet")).contains("cannot be read"));
    assert!(message(dir.path().join("pad.xyz")).contains("`.xyz` is not supported here; allowed: .tet"));
    assert!(message(dir.path().join("pad")).contains("file type `.`"));
    fs::create_dir(dir.path().join("folder.tet")).expect("folder");
    assert!(message(dir.path().join("folder.tet")).contains("not a regular file"));
    assert!(io::write_tet(dir.path().join("no/such/a.tet"), &Default::default()).is_err());
}

/// A reader that opened such a file would wait or read without end. The same files in the fields of a scene are tested
/// in `scenes_checked.rs`.
#[cfg(unix)]
#[test]
fn meshes_that_are_no_regular_files_are_refused_before_they_are_opened() {
    use std::{path::Path, process::Command, sync::mpsc, time::Duration};
    let dir = tempfile::tempdir().expect("temporary folder");
    let fifo = dir.path().join("pipe");
    assert!(Command::new("mkfifo").arg(&fifo).status().expect("mkfifo").success());
    let (done, wait) = mpsc::channel();
    let link = dir.path().join("pad.tet");
    std::thread::spawn(move || {
        for (file, says) in
            [(Path::new("/dev/zero"), "is a device"), (&fifo, "is a fifo"), (Path::new("/"), "is a directory")]
        {
            let _ = fs::remove_file(&link);
            std::os::unix::fs::symlink(file, &link).expect("link");
            let error = io::read_tet_mesh(&link).expect_err("must be refused").to_string();
            done.send((says, error)).expect("the test waits");
        }
    });
    for file in ["a device", "a fifo", "a directory"] {
        let (says, error) = wait.recv_timeout(Duration::from_secs(20)).unwrap_or_else(|e| panic!("{file}: {e}"));
        assert!(error.contains(says) && error.contains("not a regular file"), "{error}");
    }
}
