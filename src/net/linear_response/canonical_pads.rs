//! Pads as a network computes them: the shape of the pads of a scene on a canonical mesh, whose spacing over the thickness
//! is always the same.
//!
//! A network sees a pad as a continuum. Features, linear response and outputs belong to the nodes of the canonical mesh,
//! so that its answers do not depend on the mesh of the scene; they are then interpolated at the nodes of that mesh.

use super::first_contact::GeometricContact;
use super::pad_graph::{Layout, PadGraph, mesh_hash};
use super::pad_graphs::PadGraphs;
use base::error::Result;
use geometry::Pose;
use mech::contact::law::ContactLaw;
use model::Model;
use model::part::FingerModel;
use rayon::prelude::*;
use record::{FieldTransfer, PadTopology};
use std::sync::{Arc, Mutex, OnceLock, PoisonError, Weak};

/// Width of the cells of a canonical mesh over the thickness of the pad; the nodes of its 10-node tetrahedra are half as
/// far apart.
pub const CELL_WIDTH: f64 = 0.7;
/// Distance of corresponding nodes, over the thickness, below which two meshes are equal: rounding.
const SAME_NODE: f64 = 1e-9;

/// Pad of a finger on its canonical mesh.
#[derive(Debug)]
struct CanonicalPad {
    /// Finger of a scene, with the mesh of that scene.
    scene: FingerModel,
    /// Hash of that mesh.
    hash: String,
    /// The same finger with the canonical mesh.
    finger: FingerModel,
    graph: Arc<PadGraph>,
    /// Map from the canonical mesh to that of the scene; None if both are equal.
    to_scene: Option<Arc<FieldTransfer>>,
    /// Map from the mesh of the scene to the canonical one.
    from_scene: OnceLock<Arc<FieldTransfer>>,
}

/// Pads of a model on their canonical mesh.
#[derive(Debug, Clone)]
pub struct CanonicalPads {
    /// Model with the canonical mesh of its pads.
    pub model: Arc<Model>,
    /// Graph of this mesh.
    pub graph: Arc<PadGraph>,
    pad: Arc<CanonicalPad>,
}

impl CanonicalPads {
    /// Closes the canonical pads on the object of a grasp with this pose of the hand in the object frame.
    ///
    /// # Errors
    /// Fails as [`GeometricContact::find`] does.
    pub fn first_contact(&self, pose: Pose) -> Result<GeometricContact> {
        GeometricContact::find(&self.model, pose)
    }

    /// Returns the map from the canonical mesh to that of the scene; None if both are equal.
    pub fn to_scene(&self) -> Option<&Arc<FieldTransfer>> {
        self.pad.to_scene.as_ref()
    }

    /// Returns the map from the mesh of the scene to the canonical one; None if both are equal.
    pub fn from_scene(&self) -> Option<&Arc<FieldTransfer>> {
        let CanonicalPad { scene, finger, to_scene, from_scene, .. } = &*self.pad;
        let map = || Arc::new(FieldTransfer::new(&scene.topology, &finger.topology));
        to_scene.as_ref().map(|_| from_scene.get_or_init(map))
    }
}

/// Canonical pads that a program uses, each created once.
#[derive(Debug)]
pub struct CanonicalPadList {
    graphs: PadGraphs,
    pads: Mutex<Vec<Arc<CanonicalPad>>>,
    models: Mutex<Vec<(Weak<Model>, CanonicalPads)>>,
}

impl CanonicalPadList {
    /// Creates the empty list for a network of this layout.
    pub fn new(layout: Layout) -> Self {
        Self { graphs: PadGraphs::new(layout), pads: Mutex::default(), models: Mutex::default() }
    }

    /// Returns the pads of `model`, which are equal.
    ///
    /// # Errors
    /// Fails in the cases of [`Self::of_models`].
    pub fn of(&self, model: &Arc<Model>) -> Result<CanonicalPads> {
        let mut models = self.models.lock().unwrap_or_else(PoisonError::into_inner);
        models.retain(|(model, _)| model.strong_count() > 0);
        if let Some((_, known)) = models.iter().find(|(known, _)| std::ptr::eq(known.as_ptr(), Arc::as_ptr(model))) {
            return Ok(known.clone());
        }
        let pads = self.of_models(std::slice::from_ref(model))?.remove(0);
        models.push((Arc::downgrade(model), pads.clone()));
        Ok(pads)
    }

    /// Returns the pads of each of `models`. Linear responses of new pads are read from the user's cache, or computed in
    /// parallel.
    ///
    /// # Errors
    /// Fails for a pad whose sensing face has no star-shaped outline, as [`PadGraph::with_cache`] does, and if it is
    /// interrupted.
    pub fn of_models(&self, models: &[Arc<Model>]) -> Result<Vec<CanonicalPads>> {
        let fingers = models.iter().map(|model| model.finger()).collect::<Result<Vec<_>>>()?;
        let hashes: Vec<String> = fingers.par_iter().map(|finger| mesh_hash(&finger.topology)).collect();
        let mut pads = self.pads.lock().unwrap_or_else(PoisonError::into_inner);
        let find = |pads: &[Arc<CanonicalPad>], finger: &FingerModel, hash: &str| {
            pads.iter().find(|pad| pad.hash == hash && same_gel(&pad.scene, finger)).cloned()
        };
        let mut new: Vec<usize> = Vec::new();
        for (i, finger) in fingers.iter().enumerate() {
            let listed = |k: &usize| hashes[*k] == hashes[i] && same_gel(fingers[*k], finger);
            if find(&pads, finger, &hashes[i]).is_none() && !new.iter().any(listed) {
                new.push(i);
            }
        }
        let meshed = new.iter().map(|i| canonical_finger(fingers[*i])).collect::<Result<Vec<_>>>()?;
        // Several meshes of one pad share its graph.
        let graphs = self.graphs.get_or_build(&meshed.iter().map(|(finger, _)| finger).collect::<Vec<_>>())?;
        for ((i, (finger, equal)), graph) in new.into_iter().zip(meshed).zip(graphs) {
            let to_scene = (!equal).then(|| Arc::new(FieldTransfer::new(&finger.topology, &fingers[i].topology)));
            pads.push(Arc::new(CanonicalPad {
                scene: fingers[i].clone(),
                hash: hashes[i].clone(),
                finger,
                graph,
                to_scene,
                from_scene: OnceLock::new(),
            }));
        }
        let of = |((model, finger), hash): ((&Arc<Model>, &&FingerModel), &String)| {
            let pad = find(&pads, finger, hash).expect("every pad is listed");
            let on_canonical_mesh = match pad.to_scene {
                Some(_) => Arc::new(with_pads(model, &pad.finger)),
                None => model.clone(),
            };
            CanonicalPads { model: on_canonical_mesh, graph: pad.graph.clone(), pad }
        };
        Ok(models.iter().zip(&fingers).zip(&hashes).map(of).collect())
    }
}

/// Returns true if the gels of two fingers are equal.
fn same_gel(a: &FingerModel, b: &FingerModel) -> bool {
    let [a, b] = [a, b].map(|finger| &finger.body.material);
    a.name() == b.name() && a.moduli() == b.moduli()
}

/// Returns the finger with the canonical mesh of its pad, and whether that is its own mesh.
fn canonical_finger(finger: &FingerModel) -> Result<(FingerModel, bool)> {
    let canonical = finger.remeshed(CELL_WIDTH)?;
    let (own, new): (&PadTopology, &PadTopology) = (&finger.topology, &canonical.topology);
    let near = SAME_NODE * own.thickness();
    let equal = own.elements == new.elements
        && own.bonded == new.bonded
        && own.rest.iter().zip(&new.rest).all(|(a, b)| a.distance(*b) < near);
    Ok(if equal { (finger.clone(), true) } else { (canonical, false) })
}

/// Returns `model` with the pad of `finger` on each of its fingers.
fn with_pads(model: &Model, finger: &FingerModel) -> Model {
    let young = finger.body.material.moduli().young;
    let mounted = |own: &FingerModel| {
        let mut pad = finger.placed(own.placement);
        pad.law = ContactLaw::new(young, finger.surface.spacing, own.law.friction, own.law.offset);
        pad
    };
    Model { fingers: model.fingers.iter().map(mounted).collect(), ..model.clone() }
}
