//! VTK XML `UnstructuredGrid` files (`.vtu`) for ParaView: the pads of one frame, or the object's surface.
//!
//! Arrays are inline base64 (`format="binary"`), little-endian, each compressed with zlib as one block
//! (`vtkZLibDataCompressor`). The file is well-formed XML, and its bytes depend only on the data.

use super::frame::{ElementNodes, Frame, PadTopology};
use super::names;
use base64::prelude::{BASE64_STANDARD, Engine};
use flate2::{Compression, write::ZlibEncoder};
use geometry::mesh::TriMesh;
use glam::DVec3;
use std::fmt::Write as _;
use std::io::Write as _;

const TRIANGLE: u8 = 5;
const TETRA: u8 = 10;
const QUADRATIC_TETRA: u8 = 24;

/// Returns the pads of `frame` as one grid, in the hand frame, or in the world frame for a dynamic scene. Point data:
/// displacement, contact force, von Mises stress, gap, `pad` (0 = left); cell data: von Mises stress, `pad`; names are
/// in [`names`]. Array sizes must have been checked ([`super::check::frame`]).
pub fn pads(topologies: &[PadTopology], frame: &Frame) -> String {
    let mut cells = Cells::default();
    let (mut node_pad, mut tet_pad) = (Vec::<u8>::new(), Vec::<u8>::new());
    let mut first_node = 0;
    for (index, topology) in topologies.iter().enumerate() {
        let kind = match topology.elements {
            ElementNodes::Linear(_) => TETRA,
            ElementNodes::Quadratic(_) => QUADRATIC_TETRA,
        };
        cells.add(topology.elements.nodes(), topology.elements.width(), kind, first_node);
        first_node += topology.rest.len() as i64;
        let id = u8::try_from(index).unwrap_or(u8::MAX);
        node_pad.extend(std::iter::repeat_n(id, topology.rest.len()));
        tet_pad.extend(std::iter::repeat_n(id, topology.elements.len()));
    }
    let gather = |field: fn(&super::frame::PadFrame) -> &[DVec3]| -> Vec<DVec3> {
        frame.pads.iter().flat_map(|pad| field(pad).iter().copied()).collect()
    };
    let scalars = |field: fn(&super::frame::PadFrame) -> &[f64]| -> Vec<f64> {
        frame.pads.iter().flat_map(|pad| field(pad).iter().copied()).collect()
    };
    let mut out = String::new();
    begin(&mut out, node_pad.len(), cells.types.len());
    out.push_str("<PointData>\n");
    let turned = |v: Vec<DVec3>| -> Vec<DVec3> { v.into_iter().map(|v| frame.to_display_vector(v)).collect() };
    vectors(&mut out, names::DISPLACEMENT, &turned(gather(|pad| &pad.displacement)));
    // Fields that are not recorded are empty and omitted.
    if frame.pads.iter().all(|pad| !pad.contact_force.is_empty()) {
        vectors(&mut out, names::CONTACT_FORCE, &turned(gather(|pad| &pad.contact_force)));
    }
    if frame.pads.iter().all(|pad| !pad.von_mises_node.is_empty()) {
        floats(&mut out, names::VON_MISES, &scalars(|pad| &pad.von_mises_node), 1);
    }
    if frame.pads.iter().all(|pad| !pad.gap.is_empty()) {
        floats(&mut out, names::GAP, &scalars(|pad| &pad.gap), 1);
    }
    array(&mut out, "UInt8", "pad", 1, &node_pad);
    out.push_str("</PointData>\n<CellData>\n");
    if frame.pads.iter().all(|pad| !pad.von_mises_element.is_empty()) {
        floats(&mut out, names::ELEMENT_VON_MISES, &scalars(|pad| &pad.von_mises_element), 1);
    }
    array(&mut out, "UInt8", "pad", 1, &tet_pad);
    out.push_str("</CellData>\n");
    let positions: Vec<DVec3> = gather(|pad| &pad.position).into_iter().map(|x| frame.to_display_point(x)).collect();
    end(&mut out, &positions, &cells);
    out
}

/// Returns the object's surface (object frame, m) at its pose in `frame`, in the same frame as [`pads`].
pub fn object(surface: &TriMesh, frame: &Frame) -> String {
    let moved: Vec<DVec3> = surface
        .vertices
        .iter()
        .map(|&v| frame.to_display_point(frame.object_position + frame.object_rotation * v))
        .collect();
    let mut cells = Cells::default();
    cells.add(surface.triangles.as_flattened(), 3, TRIANGLE, 0);
    let mut out = String::new();
    begin(&mut out, moved.len(), cells.types.len());
    end(&mut out, &moved, &cells);
    out
}

/// The three VTK arrays that describe cells.
#[derive(Default)]
struct Cells {
    connectivity: Vec<i64>,
    offsets: Vec<i64>,
    types: Vec<u8>,
}

impl Cells {
    fn add(&mut self, nodes: &[u32], width: usize, kind: u8, first_node: i64) {
        for cell in nodes.chunks_exact(width) {
            self.connectivity.extend(cell.iter().map(|&n| first_node + i64::from(n)));
            self.offsets.push(self.connectivity.len() as i64);
            self.types.push(kind);
        }
    }
}

fn begin(out: &mut String, points: usize, cells: usize) {
    out.push_str("<?xml version=\"1.0\"?>\n");
    out.push_str(
        "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\" \
         compressor=\"vtkZLibDataCompressor\">\n",
    );
    // Writing to a String cannot fail.
    let _ = writeln!(out, "<UnstructuredGrid>\n<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">");
}

fn end(out: &mut String, points: &[DVec3], cells: &Cells) {
    out.push_str("<Points>\n");
    vectors(out, "Points", points);
    out.push_str("</Points>\n<Cells>\n");
    integers(out, "connectivity", &cells.connectivity);
    integers(out, "offsets", &cells.offsets);
    array(out, "UInt8", "types", 1, &cells.types);
    out.push_str("</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
}

fn vectors(out: &mut String, name: &str, values: &[DVec3]) {
    let flat: Vec<f64> = values.iter().flat_map(DVec3::to_array).collect();
    floats(out, name, &flat, 3);
}

fn floats(out: &mut String, name: &str, values: &[f64], components: usize) {
    let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    array(out, "Float64", name, components, &bytes);
}

fn integers(out: &mut String, name: &str, values: &[i64]) {
    let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    array(out, "Int64", name, 1, &bytes);
}

fn array(out: &mut String, kind: &str, name: &str, components: usize, bytes: &[u8]) {
    let _ = writeln!(
        out,
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"binary\">"
    );
    // Header: number of blocks, uncompressed block size, size of a partial last block (0: none), compressed block size.
    // Then the block, as a separate base64 stream.
    let packed = deflated(bytes);
    let header = match bytes.len() as u64 {
        0 => vec![0, 0, 0],
        size => vec![1, size, 0, packed.len() as u64],
    };
    BASE64_STANDARD.encode_string(header.iter().flat_map(|n: &u64| n.to_le_bytes()).collect::<Vec<u8>>(), out);
    if !bytes.is_empty() {
        BASE64_STANDARD.encode_string(&packed, out);
    }
    out.push_str("\n</DataArray>\n");
}

fn deflated(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    // Writing to a vector cannot fail.
    let _ = encoder.write_all(bytes);
    encoder.finish().unwrap_or_default()
}
