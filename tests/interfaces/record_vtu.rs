//! `.vtu` files are read back by an independent decoder, and by `vtk` and `meshio` if Python has them.

use crate::skipped::skipped;
use crate::synthetic::{frame, pads, sphere};
use std::process::Command;
use tactus::record::vtu;

fn attribute<'a>(tag: &'a str, name: &str) -> &'a str {
    tag.split(&format!("{name}=\""))
        .nth(1)
        .and_then(|rest| rest.split('"').next())
        .unwrap_or_else(|| panic!("{name}: {tag}"))
}

/// Returns the bytes of the array `name` in the section `section`, and checks the sizes in its header.
fn array(text: &str, section: &str, name: &str) -> Vec<u8> {
    let part = text
        .split(&format!("<{section}>"))
        .nth(1)
        .and_then(|r| r.split(&format!("</{section}>")).next())
        .expect(section);
    let array = part.split("<DataArray ").skip(1).find(|a| attribute(a, "Name") == name).expect(name);
    let encoded = array.split('>').nth(1).and_then(|r| r.split('<').next()).expect("content").trim();
    // The header is encoded separately: 32 characters for three numbers of 8 bytes, 44 with padding for four.
    let header = base64(&encoded[..32]);
    let number =
        |bytes: &[u8], k: usize| u64::from_le_bytes(bytes[8 * k..8 * k + 8].try_into().expect("header")) as usize;
    if number(&header, 0) == 0 {
        return Vec::new();
    }
    let (header, packed) = encoded.split_at(44);
    let (header, packed) = (base64(header), base64(packed));
    assert_eq!((number(&header, 0), number(&header, 2)), (1, 0), "{name}: one whole block");
    assert_eq!(number(&header, 3), packed.len(), "{name}: compressed size");
    let mut bytes = Vec::new();
    std::io::Read::read_to_end(&mut flate2::read::ZlibDecoder::new(&packed[..]), &mut bytes).expect("zlib");
    assert_eq!(number(&header, 1), bytes.len(), "{name}: byte count");
    bytes
}

fn base64(text: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    for group in text.as_bytes().chunks(4) {
        let sextet = |c: u8| match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            _ => 0,
        };
        let bits = group.iter().fold(0u32, |bits, &c| bits << 6 | u32::from(sextet(c)));
        let kept = 3 - group.iter().filter(|&&c| c == b'=').count();
        bytes.extend_from_slice(&bits.to_be_bytes()[1..1 + kept]);
    }
    bytes
}

fn floats(bytes: &[u8]) -> Vec<f64> {
    bytes.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().expect("eight"))).collect()
}

fn integers(bytes: &[u8]) -> Vec<i64> {
    bytes.chunks_exact(8).map(|b| i64::from_le_bytes(b.try_into().expect("eight"))).collect()
}

#[test]
fn pads_read_back_with_their_cells_and_fields() {
    for (quadratic, width, kind) in [(false, 4, 10u8), (true, 10, 24u8)] {
        let pads = pads(quadratic);
        let state = frame(&pads, 0, 1e-3);
        let text = vtu::pads(&pads, &state);
        let (nodes, tets) = (2 * pads[0].rest.len(), 2 * pads[0].elements.len());
        let piece = text.split("<Piece ").nth(1).expect("piece");
        assert_eq!(attribute(piece, "NumberOfPoints"), nodes.to_string());
        assert_eq!(attribute(piece, "NumberOfCells"), tets.to_string());
        let offsets = integers(&array(&text, "Cells", "offsets"));
        assert!((1..=tets as i64).map(|i| i * width).eq(offsets));
        let connectivity = integers(&array(&text, "Cells", "connectivity"));
        assert!(connectivity.iter().all(|&n| (0..nodes as i64).contains(&n)));
        assert!(
            connectivity[connectivity.len() / 2..].iter().all(|&n| n >= nodes as i64 / 2),
            "the right pad has its own nodes"
        );
        assert_eq!(array(&text, "Cells", "types"), vec![kind; tets]);
        let points = floats(&array(&text, "Points", "Points"));
        assert!(points.iter().all(|v| v.is_finite()));
        assert!(state.pads.iter().flat_map(|p| &p.position).flat_map(|p| p.to_array()).eq(points));
        let stress = floats(&array(&text, "PointData", "von_mises_pa"));
        assert!(state.pads.iter().flat_map(|p| p.von_mises_node.clone()).eq(stress));
        assert_eq!(floats(&array(&text, "PointData", "displacement_m")).len(), 3 * nodes);
        assert_eq!(floats(&array(&text, "PointData", "contact_force_n")).len(), 3 * nodes);
        assert_eq!(floats(&array(&text, "CellData", "element_von_mises_pa")).len(), tets);
        assert_eq!(array(&text, "CellData", "pad").iter().filter(|&&p| p == 1).count(), tets / 2);
    }
}

#[test]
fn the_object_is_moved_by_its_pose() {
    let (mesh, pads) = (sphere(6, 0.02), pads(false));
    let state = frame(&pads, 0, 1e-3);
    let points = floats(&array(&vtu::object(&mesh, &state), "Points", "Points"));
    let first = state.object_position + state.object_rotation * mesh.vertices[0];
    assert_eq!(points[..3], first.to_array());
    assert_eq!(points.len(), 3 * mesh.vertices.len());
}

/// `TACTUS_PYTHON` may name the interpreter. A wrong node order would give wrong or negative volumes (tolerance: 1e-9,
/// relative).
#[test]
fn python_readers_agree() {
    let python = std::env::var("TACTUS_PYTHON").unwrap_or_else(|_| "python3".into());
    let dir = tempfile::tempdir().expect("temporary directory");
    let pads = pads(true);
    let state = frame(&pads, 0, 0.0);
    let volume = 2.0 * 8.0 * crate::synthetic::SIZE.0 * crate::synthetic::SIZE.1 * crate::synthetic::SIZE.2 / 2.0;
    std::fs::write(dir.path().join("p.vtu"), vtu::pads(&pads, &state)).expect("written");
    let counts = format!("{} {}", 2 * pads[0].rest.len(), 2 * pads[0].elements.len());
    let meshio = "import sys, meshio\nm = meshio.read(sys.argv[1])\nprint(len(m.points), len(m.cells_dict['tetra10']))\n\
                  assert set(m.point_data) == {'displacement_m', 'contact_force_n', 'von_mises_pa', 'pad'}";
    let vtk = "import sys\nfrom vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader as R\n\
               from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter as S\n\
               r = R(); r.SetFileName(sys.argv[1]); r.Update(); g = r.GetOutput()\n\
               print(g.GetNumberOfPoints(), g.GetNumberOfCells())\n\
               s = S(); s.SetInputConnection(r.GetOutputPort()); s.Update(); v = s.GetOutput().GetCellData().GetArray('Volume')\n\
               t = sum(v.GetValue(i) for i in range(v.GetNumberOfTuples()))\n\
               assert abs(t / float(sys.argv[2]) - 1) < 1e-9 and v.GetRange()[0] > 0, t";
    for (module, script) in [("meshio", meshio), ("vtkmodules", vtk)] {
        let run = |code: &str| {
            Command::new(&python).args(["-c", code]).arg(dir.path().join("p.vtu")).arg(volume.to_string()).output()
        };
        if !run(&format!("import {module}")).is_ok_and(|out| out.status.success()) {
            skipped(&format!("python3 has no {module} (TACTUS_PYTHON names another)"));
            continue;
        }
        let out = run(script).expect("ran");
        assert!(out.status.success(), "{module}: {}", String::from_utf8_lossy(&out.stderr));
        assert!(String::from_utf8_lossy(&out.stdout).starts_with(&counts), "{module}");
        println!("{module} agrees");
    }
}
