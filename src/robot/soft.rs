//! Soft pads of a URDF on the links that carry them: how their meshes lie, and which of their nodes are bonded.

use super::fem::FemTag;
use super::{Joint, Link};
use crate::geometry::mesh::TriMesh;
use crate::geometry::mesh::io::{read_tet_mesh, read_tet_mesh_raw, read_tri_mesh};
use crate::geometry::pad::{Bonding, PadPlacement, read_pad};
use crate::geometry::shape::{DEFAULT_SEGMENTS, ShapeKind, SurfaceDistance};
use glam::{DMat3, DQuat, DVec3, EulerRot};
use std::path::{Path, PathBuf};
use urdf_rs::{Collision, Geometry};

/// Component of a direction that stems from rounding.
const ROUNDING: f64 = 1e-9;

/// Soft pad from a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct SoftPad {
    /// Path of the tetrahedral mesh.
    pub mesh: PathBuf,
    /// Factor from the unit of the mesh to metres.
    pub scale: f64,
    /// Direction out of the gel, unit, in the axes of the mesh.
    pub outward: DVec3,
    /// Direction of the approach, unit, in the axes of the mesh.
    pub across: DVec3,
    /// Indices of the nodes that are bonded to the finger.
    pub bonded: Vec<usize>,
    /// Young's modulus, Pa.
    pub young: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Density, kg/m3; None where the file is silent.
    pub density: Option<f64>,
}

/// Places the soft body `tag` of the link `pad` of the URDF at `path`, whose links are `links` with these `collisions`; `closing` and
/// `approach` are unit vectors in the axes of the link. Returns the pad, and the centre of its sensing face in the axes of the link, m.
pub(super) fn place(
    path: &Path,
    (links, collisions): (&[Link], &[Vec<Collision>]),
    pad: usize,
    tag: &FemTag,
    [closing, approach]: [DVec3; 2],
) -> Result<(SoftPad, DVec3), String> {
    let back = tag.rotation.inverse();
    let [outward, across] = [closing, approach].map(|v| tidy(back * v));
    let mesh = file(path, &tag.mesh);
    let in_link = |x: DVec3| tag.rotation * (x * tag.scale) + tag.position;
    let (raw, _) = read_tet_mesh_raw(&mesh).map_err(|e| e.to_string())?;
    let (carrier, to_carrier) = carrier(links, collisions, pad)?;
    let core = SurfaceDistance::new(&surface(path, &collisions[carrier])?);
    let near = |x: &DVec3| core.outside(to_carrier(in_link(*x))) <= tag.attach + ROUNDING * core.size();
    let bonded: Vec<usize> = (0..raw.nodes.len()).filter(|i| near(&raw.nodes[*i])).collect();
    let about = |e: crate::error::Error| {
        format!("{e} (within <attachDistance> {} m of link {:?})", tag.attach, links[carrier].name)
    };
    let placement = PadPlacement { outward, across: Some(across), bonding: Bonding::Nodes(bonded.clone()) };
    let (placed, _) = read_pad(&mesh, &placement, None).map_err(about)?;
    // Nodes keep their order, so that the first one says where the pad's origin lies in the axes of the mesh.
    let (first, _) = read_tet_mesh(&mesh).map_err(|e| e.to_string())?;
    let axes = DMat3::from_cols(across, outward.cross(across), outward);
    let center = first.nodes[0] - axes * placed.mesh.nodes[0];
    let (scale, young, poisson, density) = (tag.scale, tag.young, tag.poisson, tag.density);
    Ok((SoftPad { mesh, scale, outward, across, bonded, young, poisson, density }, in_link(center)))
}

/// Returns the direction without what rounding has left beside its axes.
fn tidy(v: DVec3) -> DVec3 {
    DVec3::from_array(v.to_array().map(|c| if c.abs() < ROUNDING { 0.0 } else { c })).normalize()
}

/// Returns the first link from `pad` upwards that has a shape, and the way from the axes of `pad` into its axes.
fn carrier(
    links: &[Link],
    collisions: &[Vec<Collision>],
    pad: usize,
) -> Result<(usize, impl Fn(DVec3) -> DVec3), String> {
    let (mut at, mut rotation, mut position) = (pad, DQuat::IDENTITY, DVec3::ZERO);
    for _ in 0..=links.len() {
        if !collisions[at].is_empty() {
            return Ok((at, move |x: DVec3| rotation * x + position));
        }
        let Link { joint: Joint::Fixed, parent: Some(parent), .. } = &links[at] else { break };
        position = links[at].rotation * position + links[at].position;
        rotation = links[at].rotation * rotation;
        at = *parent;
    }
    Err(format!(
        "the soft link {:?} is fixed to no link with a <collision> that it could be bonded to",
        links[pad].name
    ))
}

/// Returns the surface of a link, in its axes, m.
fn surface(path: &Path, collisions: &[Collision]) -> Result<TriMesh, String> {
    let mut whole = TriMesh::default();
    for collision in collisions {
        let ([roll, pitch, yaw], position) = (*collision.origin.rpy, DVec3::from_array(*collision.origin.xyz));
        let rotation = DQuat::from_euler(EulerRot::ZYX, yaw, pitch, roll);
        let (part, scale) = match &collision.geometry {
            Geometry::Mesh { filename, scale } => {
                let (mesh, _) = read_tri_mesh(file(path, filename)).map_err(|e| e.to_string())?;
                (mesh, scale.map_or(DVec3::ONE, |s| DVec3::from_array(*s)))
            }
            Geometry::Box { size } => {
                (shape(ShapeKind::Cuboid { size: DVec3::from_array(**size), edge_radius: 0.0 })?, DVec3::ONE)
            }
            Geometry::Cylinder { radius, length } => {
                (shape(ShapeKind::Cylinder { radius: *radius, height: *length })?, DVec3::ONE)
            }
            Geometry::Capsule { radius, length } => {
                (shape(ShapeKind::Capsule { radius: *radius, length: length + 2.0 * radius })?, DVec3::ONE)
            }
            Geometry::Sphere { radius } => (shape(ShapeKind::Sphere { radius: *radius })?, DVec3::ONE),
        };
        let first = whole.vertices.len() as u32;
        whole.vertices.extend(part.vertices.iter().map(|x| rotation * (*x * scale) + position));
        whole.triangles.extend(part.triangles.iter().map(|t| t.map(|i| first + i)));
    }
    Ok(whole)
}

fn shape(kind: ShapeKind) -> Result<TriMesh, String> {
    Ok((*kind.build(DEFAULT_SEGMENTS).map_err(|e| e.to_string())?.surface).clone())
}

/// Returns the path of a file that the URDF at `path` names; `package://name/` is the folder of the URDF.
fn file(path: &Path, name: &str) -> PathBuf {
    let own = name.strip_prefix("package://").map_or(name, |rest| rest.split_once('/').map_or(rest, |(_, rest)| rest));
    path.parent().unwrap_or(Path::new("")).join(own)
}
