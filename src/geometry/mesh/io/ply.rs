//! `.ply`, ASCII and binary of both byte orders, through `ply_rs_bw`: vertex positions and faces.

use std::io::{Cursor, Read};
use std::path::Path;

use glam::DVec3;
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Property, PropertyAccess, PropertyAccessResult, PropertyType};

use crate::mesh::{MAX_COUNT, TriMesh, polygon};
use base::error::{Error, Result};
use base::number::format_count;

/// Element of the file; unused properties are omitted.
#[derive(Debug, Clone, Default)]
struct Element {
    position: [f64; 3],
    corners: Vec<i64>,
}

impl PropertyAccess for Element {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        match name {
            "x" | "y" | "z" => match number(&property) {
                Some(value) => self.position[usize::from(name.as_bytes()[0] - b'x')] = value,
                None => return PropertyAccessResult::UnsupportedType,
            },
            "vertex_indices" | "vertex_index" => match indices(property) {
                Some(corners) => self.corners = corners,
                None => return PropertyAccessResult::UnsupportedType,
            },
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

fn number(property: &Property) -> Option<f64> {
    Some(match *property {
        Property::Char(x) => x.into(),
        Property::UChar(x) => x.into(),
        Property::Short(x) => x.into(),
        Property::UShort(x) => x.into(),
        Property::Int(x) => x.into(),
        Property::UInt(x) => x.into(),
        Property::Float(x) => x.into(),
        Property::Double(x) => x,
        _ => return None,
    })
}

fn indices(property: Property) -> Option<Vec<i64>> {
    fn wide<T: Into<i64>>(list: Vec<T>) -> Vec<i64> {
        list.into_iter().map(Into::into).collect()
    }
    Some(match property {
        Property::ListChar(l) => wide(l),
        Property::ListUChar(l) => wide(l),
        Property::ListShort(l) => wide(l),
        Property::ListUShort(l) => wide(l),
        Property::ListInt(l) => wide(l),
        Property::ListUInt(l) => wide(l),
        _ => return None,
    })
}

/// Parses a `.ply` file. Vertices keep the order of the file; polygons are split by [`polygon::triangulate`].
///
/// # Errors
/// Fails for content that is not PLY or is cut short, non-finite numbers, an index out of range, more items than the
/// cap and no faces (a point cloud).
pub(crate) fn parse(path: &Path, bytes: &[u8]) -> Result<(TriMesh, Vec<String>)> {
    // Messages of the library quote whole lines.
    let failed = |e: &dyn std::fmt::Display| {
        let said = e.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
        Error::file(path, format!("the PLY file cannot be read: {}", said.chars().take(200).collect::<String>()))
    };
    let parser = Parser::<Element>::new();
    let mut reader = Reader::new(Cursor::new(bytes));
    let header = parser.read_header(&mut reader).map_err(|e| failed(&e))?;
    let mut mesh = TriMesh::default();
    let mut faces = Vec::new();
    let mut left_out = Vec::new();
    for (name, definition) in &header.elements {
        if definition.count > MAX_COUNT {
            let message = format!("{} elements `{name}`; at most {MAX_COUNT} are allowed", definition.count);
            return Err(Error::file(path, message));
        }
        if definition.properties.is_empty() {
            continue;
        }
        let elements = parser.read_payload_for_element(&mut reader, definition, &header).map_err(|e| failed(&e))?;
        match name.as_str() {
            "vertex" => {
                complete(path, definition)?;
                mesh.vertices.extend(elements.iter().map(|e| DVec3::from_array(e.position)));
            }
            "face" => faces = elements,
            other => left_out.push(format!("{} `{other}`", definition.count)),
        }
    }
    if let Some((i, p)) = mesh.vertices.iter().enumerate().find(|(_, p)| !p.is_finite()) {
        let message = format!("vertex {i} (0-based) is {p}; only finite numbers are allowed");
        return Err(Error::file(path, message));
    }
    let mut notices = Vec::new();
    let (mut polygons, mut crossed) = (0, 0);
    for (i, face) in faces.iter().enumerate() {
        let corners = corners(path, i, face, mesh.vertices.len())?;
        let points: Vec<_> = corners.iter().map(|v| mesh.vertices[*v as usize]).collect();
        polygons += usize::from(corners.len() > 3);
        let triangles = polygon::triangulate(&points).unwrap_or_else(|| {
            crossed += 1;
            (1..corners.len() - 1).map(|i| [0, i, i + 1]).collect()
        });
        mesh.triangles.extend(triangles.into_iter().map(|t| t.map(|i| corners[i])));
        if mesh.triangles.len() > MAX_COUNT {
            return Err(Error::file(path, format!("more than the {MAX_COUNT} triangles allowed")));
        }
    }
    if mesh.triangles.is_empty() {
        let n = mesh.vertices.len();
        let message = format!(
            "the mesh is empty: {n} vertices and no faces; create a surface from the point cloud first (for example by \
             Poisson reconstruction in MeshLab or Open3D)"
        );
        return Err(Error::file(path, message));
    }
    let file = path.display();
    if polygons > 0 {
        notices.push(format!("{file}: split {polygons} polygons into triangles"));
    }
    if crossed > 0 {
        notices.push(format!("{file}: {crossed} faces have an outline that crosses itself"));
    }
    if !left_out.is_empty() {
        notices.push(format!("{file}: ignored elements other than vertices and faces: {}", left_out.join(", ")));
    }
    let mut rest = Vec::new();
    // Reading from memory cannot fail.
    let _ = reader.into_inner().read_to_end(&mut rest);
    if rest.iter().any(|b| !b.is_ascii_whitespace()) {
        notices.push(format!("{file}: ignored {} after the last element", format_count(rest.len(), "byte")));
    }
    Ok((mesh, notices))
}

/// Rejects vertices without a position.
fn complete(path: &Path, definition: &ElementDef) -> Result<()> {
    for axis in ["x", "y", "z"] {
        let scalar = definition.properties.get(axis).is_some_and(|p| matches!(p.data_type, PropertyType::Scalar(_)));
        if !scalar {
            return Err(Error::file(path, format!("the PLY file's vertices have no coordinate `{axis}`")));
        }
    }
    Ok(())
}

/// Returns the corners of face `i`, checked against `count` vertices.
fn corners(path: &Path, i: usize, face: &Element, count: usize) -> Result<Vec<u32>> {
    let n = face.corners.len();
    if n < 3 {
        return Err(Error::file(
            path,
            format!("face {i} (0-based) has {}; at least 3 are needed", format_count(n, "vertex")),
        ));
    }
    let valid = |v: &i64| u32::try_from(*v).ok().filter(|v| (*v as usize) < count);
    let refused = |v: &i64| {
        let message = format!(
            "face {i} (0-based) refers to vertex {v}, but there are {count}; allowed: 0..={}",
            count.saturating_sub(1)
        );
        Error::file(path, message)
    };
    face.corners.iter().map(|v| valid(v).ok_or_else(|| refused(v))).collect()
}
