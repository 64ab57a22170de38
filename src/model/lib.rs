//! Data shared by all grasps of a scene, built once and held behind one `Arc`.
//!
//! ```text
//! Scene -> object.rs (shape, mass) --+
//!       -> pads.rs (mesh, bodies) ---+-> Model -> every Environment
//!       -> needs.rs (what to spawn) -+
//! ```

pub mod accuracy;
pub mod dynamics;
pub mod evaluation;
pub mod grasp;
pub mod gripper;
pub mod limits;
pub mod needs;
mod pads;
pub mod part;
pub mod push;
pub mod sensors;

pub use dynamics::Dynamics;
pub use needs::Needs;
pub use push::PushLoad;

use crate::evaluation::Auditor;
use crate::grasp::resolve_object;
use crate::part::{FingerModel, object};
use crate::sensors::{SensorModel, SensorSetup};
use base::error::{Error, Result};
use base::number::format_number;
use geometry::Aabb;
use geometry::shape::Shape;
use glam::DVec3;
use mech::body::locking::locking_notice;
use mech::contact::ContactVertex;
use mech::material::Material;
use pads::MeshedPads;
use record::{PadReport, pad_name};
use scene::{self, Loading, ObjectMotion, Scene, StepperChoice};
use std::collections::BTreeSet;
use std::sync::Arc;

/// Data of a scene that are the same for all its grasps.
#[derive(Debug, Clone)]
pub struct Model {
    /// Rigid object.
    pub object: Shape,
    /// Mass of the object, kg.
    pub mass: f64,
    /// Flag: the object may move.
    pub free: bool,
    /// Contact vertices of the object, which may touch the pads between the pads' samples: vertices and points along
    /// sharp edges.
    pub features: Arc<[ContactVertex]>,
    /// Fingers, left first.
    pub fingers: Vec<FingerModel>,
    /// Gap at which contact begins, m.
    pub offset: f64,
    /// Coefficient of friction of the left pad, and of the right one if it is equal.
    pub friction: f64,
    /// Constitutive law of the left pad, and of the right one if it is equal.
    pub material: Arc<dyn Material>,
    /// Largest travel of a finger, m.
    pub stroke: f64,
    /// Distance between the sensing faces of the open gripper, m.
    pub opening: f64,
    /// Gravity in the object frame at the start of a grasp, m/s2.
    pub gravity: Option<DVec3>,
    /// Flag: the fingers are closed by a force; otherwise their travel is prescribed.
    pub force_driven: bool,
    /// Load at each recorded frame: force per finger of a squeeze, N; travel after first contact of a press, m; time of
    /// a dynamic scene, s.
    pub levels: Vec<f64>,
    /// Tolerance of the path error, over the displacement; None if the solution does not depend on the path.
    pub path_error: Option<f64>,
    /// Force per finger at which a free object is released, N: below it, the object is held in place and a support
    /// carries its weight.
    pub release: f64,
    /// Push after the squeeze; in its frames `levels` has the final force.
    pub push: Option<PushLoad>,
    /// Data of a dynamic scene; None for a quasi-static one.
    pub dynamics: Option<Dynamics>,
    /// Largest motion of a free object within one load level, once it is held, m; above it the object counts as lost.
    /// None is no limit.
    pub max_drift: Option<f64>,
    /// Motion relative to the hand after which a free object counts as dropped; None for a fixed object and in a
    /// dynamic scene.
    pub dropped_after: Option<DropLimits>,
    /// Estimated memory of a grasp, bytes.
    pub memory: u64,
    /// Components of the world and computations that the scene requires.
    pub needs: Needs,
    /// Auditor of the recorded frames, if the scene requires one.
    pub auditor: Option<Arc<Auditor>>,
    /// Tactile observations that the scene records.
    pub sensors: Arc<[Box<dyn SensorModel>]>,
    /// Repairs and assumptions, one sentence each.
    pub notices: Vec<String>,
}

/// Motion relative to the hand after which an object counts as dropped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DropLimits {
    /// Displacement of the point that was midway between the pads, m.
    pub distance: f64,
    /// Rotation, rad.
    pub angle: f64,
}

/// Force at which an object with weight is released over the final force.
const HEAVY_RELEASE_RATIO: f64 = 0.5;

impl Model {
    /// Builds the object and meshes the pads.
    ///
    /// # Errors
    /// Returns an error that names the part that cannot be simulated, and the remedy.
    pub fn build(scene: &Scene) -> Result<Arc<Self>> {
        let mut notices: Vec<String> = scene.gripper.notice.0.iter().cloned().collect();
        let scaled = resolve_object(scene, &mut notices)?;
        let object = object::build(&scaled, &mut notices).map_err(|e| e.with_field("object.shape"))?;
        let fem = match &scene.stepper {
            StepperChoice::Fem(fem) => *fem,
            StepperChoice::Gnn(_) => scene::Fem::default(),
        };
        let MeshedPads { fingers, memory, offset } = pads::build(scene, &object, &fem, &mut notices)?;
        let spacing = fingers.iter().map(|f| f.surface.spacing).fold(f64::INFINITY, f64::min);
        let object = object::with_contact_surface(&scaled, object, min_thickness(&fingers), spacing, &mut notices)
            .map_err(|e| e.with_field("object.surface"))?;
        let sides = fingers.len();
        let mass = object.mass.volume * scene.object.density.get();
        let dynamics = Dynamics::from_scene(scene, &object, mass, offset);
        let squeeze = matches!(scene.loading, Loading::Squeeze(_));
        let force_driven = squeeze || dynamics.as_ref().is_some_and(Dynamics::squeezes);
        let share = if squeeze { 1.0 / sides as f64 } else { 1.0 };
        let mut levels: Vec<f64> = scene.loading.levels().into_iter().map(|l| l * share).collect();
        let push = match &scene.loading {
            Loading::Squeeze(squeeze) => squeeze.push.map(|push| PushLoad::new(&push, levels.len())),
            Loading::Press(_) | Loading::Dynamic(_) => None,
        };
        let held = push.iter().flat_map(|push| &push.fractions[levels.len()..]).map(|_| levels.last().copied());
        let held: Vec<f64> = held.flatten().collect();
        levels.extend(held);
        if levels.is_empty() {
            return Err(Error::Start("the loading has no recorded frame; give a press `depth` or `depths`".into()));
        }
        if let (Loading::Press(_), Some(thickness)) = (&scene.loading, min_thickness(&fingers)) {
            let depth = levels.iter().copied().fold(0.0, f64::max);
            if depth >= thickness {
                let [depth, thickness] = [depth, thickness].map(|v| format_number(v * 1e3));
                let message = format!("a press of {depth} mm exceeds the thickness of the pad, {thickness} mm");
                return Err(Error::Start(format!("{message}; give a smaller depth")).with_field("loading"));
            }
        }
        let free = scene.object.motion == ObjectMotion::Free;
        let needs = Needs::from_scene(scene);
        // A quasi-static solution is path-dependent only with friction.
        let depends = needs.friction && dynamics.is_none() && !fingers.is_empty();
        let audit = || Arc::new(Auditor::new(&scene.expectations(), &scaled, &object, &fingers, offset));
        let auditor = needs.audit.then(audit);
        let stroke = scene.gripper.stroke.get();
        let hand = SensorSetup { fingers: &fingers, stroke, force: f64::INFINITY };
        let senses = scene.record.tactile.iter().map(|observe| sensors::sensor_model(observe, &hand)).collect();
        let mut model = Self {
            release: 0.0,
            path_error: depends.then(|| fem.path.get()),
            mass,
            free,
            features: object::features(&object, spacing, offset)?,
            fingers,
            offset,
            friction: scene.gripper.friction.get(),
            material: pads::law(scene.gripper.material.spec()),
            stroke,
            opening: scene.gripper.opening.get(),
            gravity: scene.gravity.map(|g| g.dvec3()).filter(|g| *g != DVec3::ZERO),
            force_driven,
            levels,
            push,
            dynamics,
            max_drift: None,
            dropped_after: None,
            memory,
            needs,
            auditor,
            sensors: senses,
            notices,
            object,
        };
        model.release = model.release_force(&scene.loading);
        model.dropped_after = model.drop_limits(&scene.object.dropped_after);
        Ok(Arc::new(model))
    }

    /// Returns the motion after which the object counts as dropped; by default half of the shortest side of the pads.
    fn drop_limits(&self, given: &scene::object::DroppedAfter) -> Option<DropLimits> {
        let sides = self.fingers.iter().map(|finger| finger.bounds().size().truncate().min_element());
        let half = 0.5 * sides.reduce(f64::min)?;
        let distance = given.distance.map_or(half, |distance| distance.get());
        let angle = given.turn_deg.get().to_radians();
        (self.free && self.dynamics.is_none()).then_some(DropLimits { distance, angle })
    }

    /// Returns the model with other forces per finger, N, than those of its squeeze `loading`, and with another
    /// coefficient of friction.
    pub fn with_loading(&self, loading: &Loading, levels: Vec<f64>, friction: f64) -> Self {
        let mut model = Self { levels, friction, ..self.clone() };
        model.fingers.iter_mut().for_each(|finger| finger.law.friction = friction);
        model.release = model.release_force(loading);
        model
    }

    /// Returns the descriptions of the pads in `run.json`.
    pub fn pad_reports(&self) -> Vec<PadReport> {
        self.fingers
            .iter()
            .enumerate()
            .map(|(i, f)| PadReport {
                name: pad_name(i),
                nodes: f.body.rest.len(),
                tets: f.body.element_count(),
                element: f.element.clone(),
                notice: locking_notice(&f.body),
            })
            .collect()
    }

    /// Returns warnings about locking of the pads' elements.
    pub fn pad_notices(&self) -> BTreeSet<String> {
        self.fingers.iter().filter_map(|f| locking_notice(&f.body)).collect()
    }

    /// Returns true if all pads are equal.
    pub fn has_equal_pads(&self) -> bool {
        self.fingers.windows(2).all(|pair| Arc::ptr_eq(&pair[0].topology, &pair[1].topology))
    }

    /// Returns the bounding box of all undeformed pads, pad frame, m; None without fingers.
    pub fn pad_bounds(&self) -> Option<Aabb> {
        let pads = self.fingers.iter().map(FingerModel::bounds);
        pads.reduce(|a, b| Aabb { min: a.min.min(b.min), max: a.max.max(b.max) })
    }

    /// Returns the first finger, which represents all fingers if the pads are equal.
    ///
    /// # Errors
    /// Fails for a scene without fingers.
    pub fn finger(&self) -> Result<&FingerModel> {
        self.fingers.first().ok_or_else(|| {
            Error::Start(
                "this needs pads, and the scene has none (`fingers: None`); use fingers: Both in gripper".into(),
            )
        })
    }

    /// Returns the midpoint between the pads at zero travel, m, hand frame; the origin without fingers.
    pub fn midpoint_between_pads(&self) -> DVec3 {
        let origins = self.fingers.iter().map(|finger| finger.placement.origin);
        origins.sum::<DVec3>() / self.fingers.len().max(1) as f64
    }

    /// Returns the thickness of the thinnest pad, m; zero without fingers.
    pub fn thickness(&self) -> f64 {
        min_thickness(&self.fingers).unwrap_or(0.0)
    }

    /// Returns the fraction of the push in frame `frame`; zero without a push.
    pub fn push_fraction(&self, frame: usize) -> f64 {
        self.push.as_ref().and_then(|push| push.fractions.get(frame)).copied().unwrap_or(0.0)
    }

    /// Returns true if the object is held in place first and released at [`Model::release`].
    pub fn is_released_later(&self) -> bool {
        self.force_driven && self.free && self.dynamics.is_none()
    }

    /// Returns true if the object is still held in place at the force `force` per finger, N.
    pub fn holds_object(&self, force: f64) -> bool {
        self.is_released_later() && force < self.release
    }

    /// Returns the force per finger at which the contact on every pad has grown from points to a patch, N.
    pub fn contact_force(&self) -> f64 {
        self.fingers.iter().map(FingerModel::contact_force).fold(0.0, f64::max)
    }

    /// Returns the force per finger at which a free object is released, N. Unless the scene gives it, an object is
    /// released at the contact force, and an object with weight at no less than half of the final force; at the final
    /// force at the latest.
    fn release_force(&self, loading: &Loading) -> f64 {
        let Loading::Squeeze(squeeze) = loading else { return 0.0 };
        let last = self.levels.last().copied().unwrap_or(0.0);
        let lifted = if self.gravity.is_some() { HEAVY_RELEASE_RATIO * last } else { 0.0 };
        let given = squeeze.release.map(|force| force.get() / self.fingers.len().max(1) as f64);
        given.unwrap_or(self.contact_force().max(lifted)).min(last)
    }

    /// Returns true if the fingers travel equal distances, as in a parallel gripper. With independent fingers, fingers
    /// and free object could translate together along the closing direction without any force. Around a fixed object,
    /// each finger has its own equilibrium.
    pub fn has_coupled_fingers(&self) -> bool {
        self.free || self.dynamics.is_some()
    }

    /// Returns the number of unknowns of the solver: pads, travels, pose.
    pub fn unknowns(&self) -> Unknowns {
        let pads: Vec<usize> = self.fingers.iter().map(|f| f.body.unknowns()).collect();
        let travels = match (self.force_driven, self.has_coupled_fingers()) {
            (false, _) => 0,
            (true, false) => self.fingers.len(),
            (true, true) => self.fingers.len().min(1),
        };
        let pose = if self.free { 6 } else { 0 };
        Unknowns { total: pads.iter().sum::<usize>() + travels + pose, pads, travels, pose }
    }
}

/// Returns the thickness of the thinnest pad, m.
fn min_thickness(fingers: &[FingerModel]) -> Option<f64> {
    fingers.iter().map(|f| f.topology.thickness()).reduce(f64::min)
}

/// Number of unknowns of a scene.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Unknowns {
    /// Unknowns of each pad, left first: three per free node.
    pub pads: Vec<usize>,
    /// Force-driven finger travels; one common travel for geared fingers.
    pub travels: usize,
    /// Translation and rotation of a free object.
    pub pose: usize,
    /// Total number.
    pub total: usize,
}
