//! Pads of a scene, meshed and placed on its fingers: one mesh for both, or one for each.

use super::accuracy;
use crate::limits::{self, PadSize};
use crate::part::{FingerModel, pad};
use base::error::{Error, Result};
use base::scales;
use geometry::mesh::quality::Quality;
use geometry::pad::PadMesh;
use geometry::shape::Shape;
use mech::contact::law::ContactLaw;
use mech::material::{FixedCorotated, Linear, Material, NeoHookean};
use scene::{self, Element, FinerMesh, Fingers, Gripper, MaterialSpec, Pads, Scene};
use std::sync::Arc;

/// Pads of a scene.
pub(super) struct MeshedPads {
    /// Fingers, left first.
    pub fingers: Vec<FingerModel>,
    /// Estimated memory of a grasp, bytes.
    pub memory: u64,
    /// Contact offset (gap at which contact begins), m, from the thinner pad.
    pub offset: f64,
}

/// Meshes the pads of `scene` and places them; adds the reason for the mesh, repairs and assumptions to `notices`.
///
/// # Errors
/// Fails if a pad cannot be meshed, or needs more memory than is free.
pub(super) fn build(scene: &Scene, object: &Shape, fem: &scene::Fem, notices: &mut Vec<String>) -> Result<MeshedPads> {
    let sides = match scene.gripper.fingers {
        Fingers::Both => 2,
        Fingers::One => 1,
        Fingers::None => 0,
    };
    let alike = scene.gripper.has_equal_fingers();
    let fields: &[&'static str] = if alike { &["gripper.pads"] } else { &["gripper.pads", "gripper.right"] };
    let (mut memory, mut meshed) = (0, Vec::new());
    for (side, field) in fields.iter().enumerate() {
        let about = |e: Error| e.with_field(field);
        let own = Scene { gripper: scene.gripper.with_equal_fingers(side), ..scene.clone() };
        let chosen = accuracy::choose_mesh(&own, object)?;
        notices.extend(chosen.iter().map(|choice| choice.reason.clone()));
        let pads = chosen.as_ref().map_or(&own.gripper.pads, |choice| &choice.pads);
        let finer = fem.mesh.and_then(|mesh| pads.finer(&mesh));
        let pads = finer.as_ref().unwrap_or(pads);
        let before = memory;
        let admit = |size: PadSize| {
            let memory = before + limits::estimate_memory(scene, size, sides / fields.len());
            limits::check_memory(memory, size).map(|()| memory).map_err(about)
        };
        let known = pad::size(pads, fem.element).map_err(about)?.map(admit).transpose()?;
        let mut news = Vec::new();
        let (mesh, quality) = pad::build(pads, &mut news).map_err(about)?;
        let (mesh, quality) = match (pads, fem.mesh) {
            (Pads::File(_), Some(finer)) => finer_shape((&mesh, quality), &own.gripper, &finer).map_err(about)?,
            _ => (mesh, quality),
        };
        news.retain(|notice| !notices.contains(notice));
        notices.extend(news);
        memory = known.map_or_else(|| admit(PadSize::of_pad(&mesh, fem.element)), Ok)?;
        meshed.push((mesh, quality, own.gripper));
    }
    let thickness = meshed.iter().map(|(mesh, ..)| mesh.thickness()).reduce(f64::min);
    let offset = scales::contact_offset(thickness.filter(|_| sides > 0), object.bounding_radius);
    let mut fingers = Vec::new();
    for (side, (mesh, quality, gripper)) in meshed.iter().enumerate().take(sides) {
        let material = law(gripper.material.spec());
        fingers.push(FingerModel::build((mesh, quality.clone()), side, gripper, fem, (material, offset))?);
    }
    if let (true, 2, [left]) = (alike, sides, fingers.as_mut_slice()) {
        let mut right = left.on_finger(1, &scene.gripper);
        // One contact law for both: the spacings of equal pads differ only by the rounding of their placements.
        let spacing = left.surface.spacing.min(right.surface.spacing);
        let young = scene.gripper.material.spec().young;
        left.law = ContactLaw::new(young, spacing, left.law.friction, offset);
        right.law = left.law;
        fingers.push(right);
    }
    Ok(MeshedPads { fingers, memory, offset })
}

/// Meshes the shape of a pad from a file anew, with cells narrower than those of the file by the factor of `finer`.
///
/// # Errors
/// Fails as [`FingerModel::remeshed`] does.
fn finer_shape(pad: (&PadMesh, Quality), gripper: &Gripper, finer: &FinerMesh) -> Result<(PadMesh, Quality)> {
    let given = scene::Fem { element: Element::Linear, ..scene::Fem::default() };
    let offset = scales::contact_offset(Some(pad.0.thickness()), 0.0);
    let finger = FingerModel::build(pad, 0, gripper, &given, (law(gripper.material.spec()), offset))?;
    finger.remeshed_pad(finger.cell_width() / finer.finer.get())
}

/// Returns the constitutive law of a gel.
pub(super) fn law(spec: MaterialSpec) -> Arc<dyn Material> {
    match spec.law {
        scene::Law::NeoHookean => Arc::new(NeoHookean::new(spec.young, spec.poisson)),
        scene::Law::Corotational => Arc::new(FixedCorotated::new(spec.young, spec.poisson)),
        scene::Law::Linear => Arc::new(Linear::new(spec.young, spec.poisson)),
    }
}
