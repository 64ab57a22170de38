//! Soft pads of a URDF: orientation of their meshes, and bonded nodes.

use super::fem::FemTag;
use super::package;
use super::tolerance::{Deviation, ROUNDING_TOLERANCE};
use super::tree::{Link, LinkTree, Mobility};
use super::urdf::origin;
use super::xml::{XmlElement, without_prefix};
use geometry::mesh::TriMesh;
use geometry::mesh::io::{read_tet_mesh, read_tet_mesh_raw, read_tri_mesh};
use geometry::pad::{Bonding, PadPlacement, read_pad};
use geometry::shape::{DEFAULT_SEGMENTS, ShapeKind, SurfaceDistance};
use glam::{DAffine3, DMat3, DVec3};
use std::path::{Path, PathBuf};

/// Soft pad defined by a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct SoftPad {
    /// Path of the tetrahedral mesh.
    pub mesh: PathBuf,
    /// Scale factor from mesh units to metres.
    pub scale: f64,
    /// Outward normal of the sensing face, unit, in mesh axes.
    pub outward: DVec3,
    /// Approach direction, unit, in mesh axes.
    pub across: DVec3,
    /// Indices of the nodes bonded to the finger.
    pub bonded: Vec<usize>,
    /// Young's modulus, Pa.
    pub young: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Density, kg/m3; None if not given.
    pub density: Option<f64>,
}

/// Places the soft body `tag` of the link `pad` of the URDF at `path`, whose links are `tree` with these `elements`.
/// `closing` and `approach` are unit vectors in link axes; they are snapped to the mesh axes within `deviation`.
/// Returns the pad, and the centre of its sensing face in link axes, m.
pub(super) fn place(
    path: &Path,
    (tree, elements): (&LinkTree, &[&XmlElement]),
    pad: usize,
    tag: &FemTag,
    [closing, approach]: [DVec3; 2],
    deviation: &mut Deviation,
) -> Result<(SoftPad, DVec3), String> {
    let back = tag.pose.matrix3.transpose();
    let outward = deviation.snap_vector(back * closing);
    let across = deviation.snap_vector(back * approach).reject_from_normalized(outward).normalize();
    let mesh = &tag.mesh;
    let in_link = |x: DVec3| tag.pose.transform_point3(x * tag.scale);
    let (raw, _) = read_tet_mesh_raw(mesh).map_err(|e| without_prefix(&e))?;
    let (carrier, to_carrier) = link_with_collision_shape(tree, elements, pad)?;
    let core = SurfaceDistance::new(&surface(path, elements[carrier])?);
    let near = |x: &DVec3| {
        core.distance(to_carrier.transform_point3(in_link(*x))) <= tag.attach + ROUNDING_TOLERANCE * core.size()
    };
    let bonded: Vec<usize> = (0..raw.nodes.len()).filter(|i| near(&raw.nodes[*i])).collect();
    let about = |e: base::error::Error| {
        format!(
            "{} (within <attachDistance> {} m of link {:?})",
            without_prefix(&e),
            tag.attach,
            tree.links[carrier].name
        )
    };
    let placement = PadPlacement { outward, across: Some(across), bonding: Bonding::Nodes(bonded.clone()) };
    let (placed, _) = read_pad(mesh, &placement, None).map_err(about)?;
    // Both readers keep the node order, so the first node yields the position of the pad origin in mesh axes.
    let (first, _) = read_tet_mesh(mesh).map_err(|e| without_prefix(&e))?;
    let axes = DMat3::from_cols(across, outward.cross(across), outward);
    let center = first.nodes[0] - axes * placed.mesh.nodes[0];
    let (mesh, scale, young, poisson, density) = (mesh.clone(), tag.scale, tag.young, tag.poisson, tag.density);
    Ok((SoftPad { mesh, scale, outward, across, bonded, young, poisson, density }, in_link(center)))
}

/// Returns the first link from `pad` upwards, along fixed joints, that has a collision shape, and the transform from
/// the axes of `pad` to its axes.
fn link_with_collision_shape(
    tree: &LinkTree,
    elements: &[&XmlElement],
    pad: usize,
) -> Result<(usize, DAffine3), String> {
    let (mut at, mut pose) = (pad, DAffine3::IDENTITY);
    for _ in 0..=tree.links.len() {
        if elements[at].child("collision").is_some() {
            return Ok((at, pose));
        }
        let Link { mobility: Mobility::Fixed, parent: Some(parent), pose: own, .. } = &tree.links[at] else { break };
        pose = *own * pose;
        at = *parent;
    }
    Err(elements[pad].error("is not fixed to a link with a <collision> to which its <fem> could be bonded"))
}

/// Returns the collision surface of a link of the URDF at `path`, in link axes, m.
fn surface(path: &Path, link: &XmlElement) -> Result<TriMesh, String> {
    let mut whole = TriMesh::default();
    for collision in link.children_with_tag("collision") {
        let pose = origin(collision)?;
        let of = collision.child("geometry").and_then(|geometry| geometry.children.first());
        let of = of.ok_or_else(|| collision.error("has no <geometry>"))?;
        let part = part(path, of)?;
        let first = whole.vertices.len() as u32;
        whole.vertices.extend(part.vertices.iter().map(|x| pose.transform_point3(*x)));
        whole.triangles.extend(part.triangles.iter().map(|t| t.map(|i| first + i)));
    }
    Ok(whole)
}

/// Returns the surface of one collision geometry, m.
fn part(path: &Path, of: &XmlElement) -> Result<TriMesh, String> {
    let length = |name: &str| of.number(name)?.ok_or_else(|| of.error(format_args!("has no {name}=\"...\"")));
    let kind = match of.tag.as_str() {
        "mesh" => return mesh(path, of),
        "box" => {
            let size = of.numbers("size")?.ok_or_else(|| of.error("has no size=\"...\""))?;
            ShapeKind::Cuboid { size: DVec3::from_array(size), edge_radius: 0.0 }
        }
        "cylinder" => ShapeKind::Cylinder { radius: length("radius")?, height: length("length")? },
        "capsule" => {
            let radius = length("radius")?;
            ShapeKind::Capsule { radius, length: length("length")? + 2.0 * radius }
        }
        "sphere" => ShapeKind::Sphere { radius: length("radius")? },
        _ => return Err(of.error("is not a supported geometry; allowed: mesh, box, cylinder, capsule, sphere")),
    };
    let shape = kind.build(DEFAULT_SEGMENTS).map_err(|e| of.error(without_prefix(&e)))?;
    Ok((*shape.surface).clone())
}

/// Returns the surface of a mesh file, scaled, m.
fn mesh(path: &Path, of: &XmlElement) -> Result<TriMesh, String> {
    let scale = of.numbers("scale")?.map_or(DVec3::ONE, DVec3::from_array);
    if scale.abs().min_element() == 0.0 {
        return Err(of.error(format_args!("has scale {scale} and therefore no volume; each factor must be nonzero")));
    }
    let (mut mesh, _) = read_tri_mesh(package::file(path, of)?).map_err(|e| without_prefix(&e))?;
    mesh.vertices.iter_mut().for_each(|x| *x *= scale);
    // A reflection reverses the orientation of the triangles.
    if scale.to_array().iter().filter(|factor| **factor < 0.0).count() % 2 == 1 {
        mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    }
    Ok(mesh)
}
