//! Pads from mesh files: outward direction and transformation into the pad frame.

use std::path::Path;

use glam::{DMat3, DVec3};

use crate::mesh::io::{self, text};
use crate::mesh::{TetMesh, clean};
use crate::pad::{Bonding, PadMesh, free_faces, looks_along, validity};
use base::error::{Error, Result};
use base::number::format_number;

/// Size of a pad above which a notice is given, m: its file is probably in millimetres.
pub const SUSPICIOUS_SIZE: f64 = 0.5;

/// Placement of a mesh, given in an arbitrary frame, as a pad.
#[derive(Debug, Clone, PartialEq)]
pub struct PadPlacement {
    /// Unit vector out of the gel, in the frame of the mesh; becomes +z of the pad.
    pub outward: DVec3,
    /// Direction that becomes +x of the pad, in the frame of the mesh; its component along `outward` is removed. None
    /// selects +x of the mesh, or +y if `outward` is nearly along x.
    pub across: Option<DVec3>,
    /// Rule that selects the bonded nodes, in the frame of the mesh.
    pub bonding: Bonding,
}

/// Transforms a mesh into the pad frame: origin at the centre of the bounding rectangle of the sensing face (the free
/// faces within 60 degrees of `outward`), at its highest point. Node order is kept, and the mesh must already be
/// repaired.
///
/// # Errors
/// Returns [`Error::Mesh`] if the mesh is empty or has bad indices, `outward` is not a unit vector, `across` is along
/// it, a node index is out of range, no node or every node is bonded, a part of the pad is not held or overlaps
/// another, or no free face points outwards.
pub fn from_mesh(mesh: TetMesh, placement: &PadPlacement) -> Result<PadMesh> {
    clean::check_indices(&mesh)?;
    let [x, y, z] = axes(placement)?;
    // Rows are the axes of the pad: the rotation maps from the frame of the mesh to that of the pad.
    let rotation = DMat3::from_cols(x, y, z).transpose();
    let bonded = placement.bonding.bonded_nodes(&mesh, z)?;
    validity::check(&mesh, &bonded)?;
    let mut mesh = mesh;
    for p in &mut mesh.nodes {
        *p = rotation * *p;
    }
    let face: Vec<DVec3> = free_faces(&mesh, &bonded)
        .iter()
        .filter(|f| looks_along(&mesh, f, DVec3::Z))
        .flat_map(|f| f.nodes.map(|i| mesh.nodes[i as usize]))
        .collect();
    if face.is_empty() {
        return Err(Error::Mesh(format!(
            "no free face of the pad faces along outward = {}; check its direction and that the sensing face is not \
             bonded",
            vector(placement.outward)
        )));
    }
    let low = face.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = face.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let origin = DVec3::new(0.5 * (low.x + high.x), 0.5 * (low.y + high.y), high.z);
    for p in &mut mesh.nodes {
        *p -= origin;
    }
    Ok(PadMesh { mesh, bonded })
}

/// Reads, repairs and places a pad. `nodes_file`, if given, replaces `placement.bonding`; its numbers refer to the
/// nodes of the mesh file in their order there. Returns the pad and notices.
///
/// The file contains whole numbers separated by blanks or line breaks; `#` starts a comment. They are either the
/// 0-based indices of the bonded nodes, or one 0 or 1 per node of the mesh (1 = bonded).
///
/// # Errors
/// Fails in the cases of [`io::read_tet_mesh`] and [`from_mesh`], and for a bad or repeated number in `nodes_file`,
/// with its position.
pub fn read_pad(
    mesh_file: impl AsRef<Path>,
    placement: &PadPlacement,
    nodes_file: Option<&Path>,
) -> Result<(PadMesh, Vec<String>)> {
    read_pad_group(mesh_file, None, placement, nodes_file)
}

/// Reads a pad as [`read_pad`] does, only from the tetrahedra of a group, see [`io::read_tet_group`].
///
/// # Errors
/// Fails in the cases of [`read_pad`], and if the file has no such group.
pub fn read_pad_group(
    mesh_file: impl AsRef<Path>,
    group: Option<&str>,
    placement: &PadPlacement,
    nodes_file: Option<&Path>,
) -> Result<(PadMesh, Vec<String>)> {
    let path = mesh_file.as_ref();
    let in_file = |e: Error| match e {
        Error::Mesh(message) => Error::file(path, message),
        other => other,
    };
    let (mut mesh, mut notices) = io::read_tet_group(path, group)?;
    let count = mesh.nodes.len();
    let repair = clean::repair_mapped(&mut mesh).map_err(in_file)?;
    notices.extend(repair.notices.iter().map(|n| format!("{}: {n}", path.display())));
    let listed = match (nodes_file, &placement.bonding) {
        (Some(file), _) => Some(read_nodes(file, count)?),
        (None, Bonding::Nodes(list)) => Some(list.clone()),
        (None, Bonding::Plane { .. } | Bonding::Surface { .. }) => None,
    };
    let mut placement = placement.clone();
    if let Some(list) = listed {
        if let Some(i) = list.iter().find(|i| **i >= count) {
            let message = format!("bonded node index {i}, but the mesh has {count} nodes; allowed: 0..={}", count - 1);
            return Err(Error::file(path, message));
        }
        // Nodes that were removed as unused are omitted.
        let now = list.into_iter().filter_map(|i| repair.node_map[i].map(|i| i as usize));
        placement.bonding = Bonding::Nodes(now.collect());
    }
    let pad = from_mesh(mesh, &placement).map_err(in_file)?;
    let low = pad.mesh.nodes.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = pad.mesh.nodes.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let size = (high - low).max_element();
    if size > SUSPICIOUS_SIZE {
        notices.push(format!(
            "{}: the pad is {} m long; coordinates are taken as metres: is it in mm?",
            path.display(),
            format_number(size)
        ));
    }
    Ok((pad, notices))
}

/// Reads the indices of a list of nodes, see [`read_pad`]; `count` is the number of nodes of the mesh file.
///
/// # Errors
/// Fails for an entry that is not a whole number, out of range or repeated, with line and column, and for an empty
/// list.
pub fn read_nodes(path: impl AsRef<Path>, count: usize) -> Result<Vec<usize>> {
    let path = path.as_ref();
    let source = io::read_text(path)?;
    let words: Vec<text::Word<'_>> = text::lines(&source, Some('#')).flat_map(|l| l.words).collect();
    let mut values = Vec::with_capacity(words.len());
    for word in &words {
        values.push(text::integer(path, *word, "node index")?);
    }
    if values.len() == count && values.iter().all(|v| *v <= 1) {
        return Ok((0..count).filter(|i| values[*i] == 1).collect());
    }
    let mut seen = vec![false; count];
    for (word, value) in words.iter().zip(&values) {
        match usize::try_from(*value).ok().and_then(|i| seen.get_mut(i)) {
            None => {
                let allowed = count.saturating_sub(1);
                let message = format!("node index {value}, but the mesh has {count} nodes; allowed: 0..={allowed}");
                return Err(text::word_error(path, *word, message));
            }
            Some(s) if *s => {
                let message = format!(
                    "node index {value} occurs twice; give each bonded node once, or one 0 or 1 for each of the \
                     {count} nodes (found {} numbers)",
                    values.len()
                );
                return Err(text::word_error(path, *word, message));
            }
            Some(s) => *s = true,
        }
    }
    if values.is_empty() {
        return Err(Error::file(path, "the list of bonded nodes is empty"));
    }
    Ok((0..count).filter(|i| seen[*i]).collect())
}

/// Returns a direction as text for messages.
fn vector(v: DVec3) -> String {
    format!("({}, {}, {})", format_number(v.x), format_number(v.y), format_number(v.z))
}

/// Returns the pad's unit axes in the frame of the mesh.
fn axes(placement: &PadPlacement) -> Result<[DVec3; 3]> {
    let outward = placement.outward;
    let off = (outward.length() - 1.0).abs();
    if off > 1e-6 || off.is_nan() {
        let found = vector(outward);
        return Err(Error::Mesh(format!("outward = {found} of the pad must be a unit vector, such as (0, 0, 1)")));
    }
    let z = outward.normalize();
    let wish = placement.across.unwrap_or(if z.x.abs() < 0.9 { DVec3::X } else { DVec3::Y });
    let part = wish - z * wish.dot(z);
    if !wish.is_finite() || part.length() <= 1e-6 * wish.length() {
        let message =
            format!("across = {} of the pad must not be zero or along outward = {}", vector(wish), vector(outward));
        return Err(Error::Mesh(message));
    }
    let x = part.normalize();
    Ok([x, z.cross(x), z])
}
