//! Pads of a scene, meshed in the pad frame and placed on their fingers in the hand frame.

use crate::gripper::FingerPlacement;
use crate::limits::PadSize;
use base::error::{Error, Result};
use base::number::format_number;
use base::scales::CONTACT_FORCE;
use geometry::Aabb;
use geometry::mesh::io::read_tri_mesh;
use geometry::mesh::quality::{Quality, quality};
use geometry::mesh::{quadratic, surface};
use geometry::pad::{self, Bonding, Density, PadMesh, Resolution};
use glam::DVec3;
use mech::body::{self, Body};
use mech::contact::law::ContactLaw;
use mech::contact::{ContactSurface, SurfaceFace};
use mech::material::Material;
use record::{self, PadTopology};
use scene::bonding::BondingRule;
use scene::leaf::{MAX_LENGTH, MIN_PAD_SIDE};
use scene::pad::FilePad;
use scene::{self, Element, Gripper, Pads};
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

/// Finger: its pad in the hand frame, and the data that the solver and the recorder need of it.
#[derive(Debug, Clone)]
pub struct FingerModel {
    /// Reference mesh in the hand frame at zero travel, and constitutive law.
    pub body: Arc<Body>,
    /// Samples of the pad's free surface that can touch the object.
    pub surface: Arc<ContactSurface>,
    /// Topology of the pad for records, in the pad frame.
    pub topology: Arc<PadTopology>,
    /// Placement of the pad in the hand frame at zero travel.
    pub placement: FingerPlacement,
    /// Kind of element, for reports.
    pub element: String,
    /// Mesh quality without mid-edge nodes.
    pub quality: Quality,
    /// Density of the gel, kg/m3.
    pub gel_density: f64,
    /// Law of the contact with the object.
    pub law: ContactLaw,
}

impl FingerModel {
    /// Returns the element faces of the sensing face.
    pub fn sensing_faces(&self) -> Vec<SurfaceFace> {
        let sensing: BTreeSet<u32> = self.topology.sensing.iter().flatten().copied().collect();
        let sensing = |face: &&SurfaceFace| {
            face.corners.iter().chain(face.mids.iter().flatten()).all(|node| sensing.contains(node))
        };
        self.surface.faces.iter().filter(sensing).copied().collect()
    }
}

/// Returns the size of a generated pad along x, y and z, m; None for a pad from a file.
pub fn extent(pads: &Pads) -> Option<[f64; 3]> {
    grid(pads).map(|(_, size)| size)
}

/// Returns the mesh resolution of a generated pad, and its size along x, y and z, m; None for a pad from a file. An
/// accuracy has no effect here, see [`crate::accuracy`].
fn grid(pads: &Pads) -> Option<(Resolution, [f64; 3])> {
    let fine = |density, grading: scene::leaf::Ratio, focus: scene::leaf::Ratio| Resolution {
        density,
        grading: grading.get(),
        focus: focus.get(),
    };
    match pads {
        Pads::GelSightMini(g) => {
            let spacing = g.mesh_spacing().get();
            Some((fine(Density::Spacing(spacing), g.grading, g.focus), pad::GELSIGHT_MINI))
        }
        Pads::Box(b) => {
            let spacing = b.mesh_spacing().get();
            let density = b.cells.map_or(Density::Spacing(spacing), |c| Density::Cells(c.counts()));
            Some((fine(density, b.grading, b.focus), b.size.size().to_array()))
        }
        Pads::Disc(d) => {
            let (across, thickness) = (2.0 * d.radius.get(), d.thickness.get());
            let spacing = d.mesh_spacing().get();
            Some((fine(Density::Spacing(spacing), d.grading, d.focus), [across, across, thickness]))
        }
        Pads::File(_) => None,
    }
}

/// Returns the number of nodes and unknowns of a generated pad before it is meshed; None for a pad from a file.
///
/// # Errors
/// Fails if the number of cells is out of range.
pub fn size(pads: &Pads, element: Element) -> Result<Option<PadSize>> {
    let Some((resolution, size)) = grid(pads) else { return Ok(None) };
    Ok(Some(PadSize::of_cells(resolution.cells_for(size)?, element)))
}

/// Meshes or reads the pad; adds repairs and assumptions to `notices`.
///
/// # Errors
/// Fails if the pad cannot be generated or read, and for a mesh without tetrahedra.
pub fn build(pads: &Pads, notices: &mut Vec<String>) -> Result<(PadMesh, Quality)> {
    let pad = match (pads, grid(pads)) {
        (Pads::GelSightMini(g), Some((fine, _))) => {
            let shape = match g.shape {
                scene::pad::GelShape::Flat => pad::GelProfile::Flat,
                scene::pad::GelShape::Domed => pad::GelProfile::Domed,
            };
            pad::gelsight_mini(shape, &fine)?
        }
        (Pads::Disc(d), Some((fine, _))) => pad::disc_pad(d.radius.get(), d.thickness.get(), &fine)?,
        (_, Some((fine, [x, y, z]))) => pad::box_pad(x, y, z, &fine)?,
        (Pads::File(file), _) => read(file, notices)?,
        (_, None) => return Err(Error::Mesh("the pad is neither generated nor from a file".into())),
    };
    let quality = quality(&pad.mesh).ok_or_else(|| Error::Mesh("the pad has no tetrahedron".into()))?;
    if quality.worst < LOW_QUALITY {
        notices.push(format!(
            "the pad's tetrahedron {} (0-based) has poor quality: mean ratio {:.3} at {:.6}",
            quality.worst_index, quality.worst, quality.worst_centroid
        ));
    }
    Ok((pad, quality))
}

/// Mean ratio below which a notice about the worst element is given.
const LOW_QUALITY: f64 = 0.1;

fn read(file: &FilePad, notices: &mut Vec<String>) -> Result<PadMesh> {
    let scale = file.scale.get();
    let (bonding, listed) = bonding(file, notices)?;
    let (outward, across) = (file.outward.dvec3().normalize(), file.across.map(|a| a.dvec3()));
    let placement = pad::PadPlacement { outward, across, bonding };
    let (mut pad, news) = pad::read_pad_group(&file.path, file.group.as_deref(), &placement, listed)?;
    // The reader's notice that coordinates are taken as metres does not apply with a `scale`.
    notices.extend(news.into_iter().filter(|n| scale == 1.0 || !n.contains("taken as metres")));
    pad.mesh.nodes.iter_mut().for_each(|p| *p *= scale);
    let size = Aabb::from_points(pad.mesh.nodes.iter().copied()).size();
    if size.min_element() < MIN_PAD_SIDE || size.max_element() > MAX_LENGTH {
        let [x, y, z] = size.to_array().map(format_number);
        return Err(Error::file(
            &file.path,
            format!(
                "the pad is {x} x {y} x {z} m; each side must be from {MIN_PAD_SIDE:e} to {MAX_LENGTH} m: `scale` is the factor from the \
                 unit of the file to metres (millimetres: 1e-3), here {}",
                format_number(scale)
            ),
        ));
    }
    let (bonded, nodes) = (pad.bonded.iter().filter(|b| **b).count(), pad.bonded.len());
    notices.push(format!("{}: {bonded} of {nodes} nodes are bonded to the finger", file.path.display()));
    Ok(pad)
}

/// Returns the bonding rule of the pad, in the unit of its file, and the file that lists the bonded nodes, if there is
/// one.
fn bonding<'f>(file: &'f FilePad, notices: &mut Vec<String>) -> Result<(Bonding, Option<&'f Path>)> {
    let scale = file.scale.get();
    let rule = match &file.bonded {
        BondingRule::Plane(plane) => Bonding::Plane {
            normal: plane.normal.map(|n| n.dvec3().normalize()),
            offset: plane.offset.map(|offset| offset.get() / scale),
            within: plane.within.map_or(0.0, |within| within.get() / scale),
        },
        BondingRule::NearMesh(core) => {
            let (surface, news) = read_tri_mesh(&core.path)?;
            notices.extend(news);
            Bonding::Surface { surface: Arc::new(surface), within: core.within.get() / scale }
        }
        BondingRule::Nodes(nodes) => Bonding::Nodes(nodes.clone()),
        BondingRule::NodesFile(path) => return Ok((Bonding::back(0.0), Some(path))),
    };
    Ok((rule, None))
}

/// Gel of a pad.
struct Gel {
    material: Arc<dyn Material>,
    /// Young's modulus, Pa.
    young: f64,
    /// Density, kg/m3.
    density: f64,
}

impl FingerModel {
    /// Returns the bounding box of the undeformed pad, pad frame, m.
    pub fn bounds(&self) -> Aabb {
        Aabb::from_points(self.topology.rest.iter().copied())
    }

    /// Places `pad`, with its mesh quality, on finger `side` (0 left, 1 right) of a gripper with two equal pads.
    /// `offset` is the contact offset, m.
    ///
    /// # Errors
    /// Fails for a pad without a free surface.
    pub fn build(
        (pad, quality): (&PadMesh, Quality),
        side: usize,
        gripper: &Gripper,
        fem: &scene::Fem,
        (material, offset): (Arc<dyn Material>, f64),
    ) -> Result<Self> {
        let spec = gripper.material.spec();
        let gel = Gel { material, young: spec.young, density: spec.density };
        let contact = (gripper.friction.get(), offset);
        Self::from_mesh((pad, quality), placement(side, gripper), (fem.element, fem.mean_dilatation), gel, contact)
    }

    /// Creates a finger from a pad with its mesh quality; `contact` is the coefficient of friction and the contact
    /// offset, m.
    fn from_mesh(
        (pad, quality): (&PadMesh, Quality),
        placement: FingerPlacement,
        (element, mean_dilatation): (Element, bool),
        gel: Gel,
        contact: (f64, f64),
    ) -> Result<Self> {
        let corner_count = pad.mesh.nodes.len();
        let (nodes, elements, bonded, mean_dilatation) = match element {
            Element::Linear => {
                (pad.mesh.nodes.clone(), body::Elements::Linear(pad.mesh.tets.clone()), pad.bonded.clone(), false)
            }
            Element::Quadratic => {
                let promoted = quadratic::to_quadratic(&pad.mesh);
                let mut bonded = pad.bonded.clone();
                // The midpoint of an edge is bonded if both end nodes are.
                let glued = |[a, b]: [u32; 2]| pad.bonded[a as usize] && pad.bonded[b as usize];
                bonded.extend(quadratic::midpoint_edges(&pad.mesh).into_iter().map(glued));
                (promoted.nodes, body::Elements::Quadratic(promoted.tets), bonded, mean_dilatation)
            }
        };
        let topology = topology(pad, &nodes, &elements, &bonded, corner_count);
        let rest: Vec<DVec3> = nodes.iter().map(|x| placement.place(*x)).collect();
        let body = Arc::new(Body::new(rest, elements, bonded, gel.material, mean_dilatation));
        let surface = Arc::new(ContactSurface::new(&body));
        if surface.points.is_empty() {
            return Err(Error::Mesh("the pad has no free surface: every boundary face is bonded to the finger".into()));
        }
        let name = match (element, mean_dilatation) {
            (Element::Linear, _) => "linear".into(),
            (Element::Quadratic, true) => "quadratic, mean dilatation".into(),
            (Element::Quadratic, false) => "quadratic".into(),
        };
        let (friction, offset) = contact;
        let law = ContactLaw::new(gel.young, surface.spacing, friction, offset);
        let topology = Arc::new(topology);
        Ok(Self { body, surface, topology, placement, element: name, quality, gel_density: gel.density, law })
    }

    /// Returns the finger with the shape of its pad meshed anew by 10-node tetrahedra in a structured grid, whose cells
    /// have the width `spacing` over the thickness of the pad.
    ///
    /// # Errors
    /// Fails for a pad whose sensing face has no star-shaped outline.
    pub fn remeshed(&self, spacing: f64) -> Result<Self> {
        let (mesh, quality) = self.remeshed_pad(spacing * self.topology.thickness())?;
        let material = self.body.material.clone();
        let gel = Gel { young: material.moduli().young, density: self.gel_density, material };
        let element = (Element::Quadratic, scene::Fem::default().mean_dilatation);
        Self::from_mesh((&mesh, quality), self.placement, element, gel, (self.law.friction, self.law.offset))
    }

    /// Returns the shape of the pad meshed anew by a structured grid with cells of the width `spacing`, m, and the quality
    /// of this mesh.
    ///
    /// # Errors
    /// Fails as [`Self::remeshed`] does.
    pub fn remeshed_pad(&self, spacing: f64) -> Result<(PadMesh, Quality)> {
        let PadTopology { rest, surface, sensing, bonded, .. } = &*self.topology;
        let shape = pad::PadShape { nodes: rest, surface, sensing, bonded };
        let mesh = pad::remesh(&shape, self.topology.thickness(), spacing)?;
        let quality = quality(&mesh.mesh).ok_or_else(|| Error::Mesh("the pad has no tetrahedron".into()))?;
        Ok((mesh, quality))
    }

    /// Returns the mean width of two triangles of the sensing face, m.
    pub fn cell_width(&self) -> f64 {
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| self.topology.rest[i as usize]);
            (b - a).cross(c - a).length()
        };
        let sensing = &self.topology.sensing;
        (sensing.iter().map(area).sum::<f64>() / sensing.len().max(1) as f64).sqrt()
    }

    /// Returns this pad on finger `side` (0 left, 1 right); all data except the placement are shared.
    pub fn on_finger(&self, side: usize, gripper: &Gripper) -> Self {
        self.placed(placement(side, gripper))
    }

    /// Returns this pad with another placement; all other data are shared.
    pub fn placed(&self, placement: FingerPlacement) -> Self {
        let rest: Vec<DVec3> = self.topology.rest.iter().map(|x| placement.place(*x)).collect();
        let surface = Arc::new(self.surface.placed(&rest));
        Self { body: Arc::new(self.body.placed(rest)), surface, placement, ..self.clone() }
    }

    /// Returns the force at which the contact has grown from points to a patch, N: `0.02 E t^2`.
    pub fn contact_force(&self) -> f64 {
        CONTACT_FORCE * self.body.material.moduli().young * self.topology.thickness().powi(2)
    }
}

/// Returns the placement of a pad on finger `side`.
fn placement(side: usize, gripper: &Gripper) -> FingerPlacement {
    let mut placement = FingerPlacement::new(side, gripper.opening.get(), gripper.placement.z.get());
    placement.origin.y += gripper.placement.y.get();
    placement
}

/// Returns the topology of the pad for the recorder.
fn topology(
    pad: &PadMesh,
    nodes: &[DVec3],
    elements: &body::Elements,
    bonded: &[bool],
    corner_count: usize,
) -> PadTopology {
    let edges = quadratic::midpoint_edges(&pad.mesh);
    let middle = |a: u32, b: u32| {
        let k = edges.partition_point(|e| *e < [a.min(b), a.max(b)]);
        (corner_count + k) as u32
    };
    let quadratic = matches!(elements, body::Elements::Quadratic(_));
    let face = |[a, b, c]: [u32; 3]| {
        let mids = quadratic.then(|| [middle(a, b), middle(b, c), middle(c, a)]);
        SurfaceFace { corners: [a, b, c], mids }
    };
    let elements = match elements {
        body::Elements::Linear(tets) => record::ElementNodes::Linear(tets.clone()),
        body::Elements::Quadratic(tets) => record::ElementNodes::Quadratic(tets.clone()),
    };
    PadTopology {
        rest: nodes.to_vec(),
        corner_count,
        elements,
        surface: surface::boundary(&pad.mesh).into_iter().map(|f| f.nodes).collect(),
        sensing: pad::sensing_faces(pad).into_iter().flat_map(|f| face(f.nodes).flat_parts()).collect(),
        bonded: bonded.to_vec(),
    }
}
