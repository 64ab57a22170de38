//! Samples: a grasp of a data set, with features computed from its stored scene, and the finite-element results.

use super::loss::{LossValue, bounded_relative_error};
use crate::autodiff::tensor::{Matrix, Real, Tape};
use crate::features::loads::LoadFeatures;
use crate::features::select_rows;
use crate::features::{GraspFeatures, ROTATION, VECTOR};
use crate::linear_response::canonical_pads::CanonicalPads;
use crate::linear_response::object_motion::rigid_motion;
use crate::linear_response::{GraspLoad, frame_loads};
use crate::network::{NetworkOutput, Normalisers};
use base::error::{Error, Result};
use dataset::{ObjectFile, StoredGrasp};
use geometry::Pose;
use glam::DVec3;
use model::Model;
use record::FieldTransfer;
use scene::from_ron;

use std::sync::Arc;

/// Nodes of displacement and stress of a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LabelNodes {
    /// The canonical nodes, at which the network is trained.
    Canonical,
    /// The nodes of the scene, at which finite elements recorded them and a user reads them.
    Scene,
}

/// Grasp for training or evaluation. Fields are in SI and pad frames, ordered by level, then pad, then node.
#[derive(Debug, Clone)]
pub struct Sample {
    /// Name of the object.
    pub object: String,
    /// Index of the grasp.
    pub grasp: usize,
    /// Indices of the frames in this sample.
    pub frames: Vec<usize>,
    /// Features of the grasp.
    pub features: GraspFeatures,
    /// Features of each level.
    pub loads: LoadFeatures,
    /// Force per finger of each level, N.
    pub forces: Vec<f64>,
    /// Load of each level, N and N m.
    pub grasp_loads: Vec<GraspLoad>,
    /// Map from the canonical nodes to those of displacement and stress; None if these are the canonical ones.
    pub to_labels: Option<Arc<FieldTransfer>>,
    /// Displacement (levels, pads, nodes, 3), m.
    pub displacement: Vec<f32>,
    /// Stress (levels, pads, nodes), Pa.
    pub stress: Vec<f32>,
    /// Contact force (levels, pads, canonical face nodes, 3), N.
    pub contact: Vec<f32>,
    /// Travel (levels, pads), m.
    pub travel: Vec<f64>,
    /// Motion (levels, pads, 6) since first contact: translation (m) of the point of the object midway between the
    /// pads, rotation vector.
    pub motion: Vec<f64>,
}

/// Returns the vectors with these components.
fn vectors(components: &[f32]) -> Vec<DVec3> {
    components.as_chunks::<3>().0.iter().map(|v| DVec3::from_array(v.map(f64::from))).collect()
}

/// Builds the model of a file of a data set.
///
/// # Errors
/// Fails if the scene cannot be built.
pub fn model_of(file: &ObjectFile) -> Result<Arc<Model>> {
    let bad = |e| Error::file(&file.path, format!("its scene cannot be read: {e}"));
    Model::build(&from_ron(&file.scene).map_err(bad)?.without_finer_mesh())
}

impl Sample {
    /// Reads a grasp, at most `most` of its frames, evenly spaced from the first to the last.
    ///
    /// # Errors
    /// Fails if the grasp is damaged, or if its first contact cannot be found.
    pub fn read(
        file: &ObjectFile,
        pads: &CanonicalPads,
        grasp: usize,
        labels: LabelNodes,
        most: usize,
    ) -> Result<Self> {
        Self::of(file, pads, (grasp, &file.grasp(grasp)?), labels, most)
    }

    /// Creates the sample of a grasp that has been read. The features do not depend on finite-element results.
    ///
    /// # Errors
    /// Fails if first contact cannot be found.
    pub fn of(
        file: &ObjectFile,
        canonical: &CanonicalPads,
        (grasp, data): (usize, &StoredGrasp),
        labels: LabelNodes,
        most: usize,
    ) -> Result<Self> {
        let (model, graph) = (&canonical.model, &canonical.graph);
        let touch = canonical.first_contact(Pose::from_row(&data.grasp_pose))?;
        let count = data.frames.min(most);
        let last = data.frames.saturating_sub(1);
        let frames = (0..count).map(|i| if count > 1 { i * last / (count - 1) } else { last });
        let frames: Vec<usize> = frames.collect();
        let (pads, nodes) = (file.sizes.pads, file.sizes.nodes);
        let features = GraspFeatures::new(model, graph, &touch);
        let forces: Vec<f64> = frames.iter().map(|k| data.force[*k] / pads as f64).collect();
        let all = frame_loads(model);
        // With the force that the simulation applied.
        let given =
            frames.iter().zip(&forces).map(|(k, force)| GraspLoad { force: *force, ..all[*k] }).collect::<Vec<_>>();
        let mut sample = Self {
            object: file.name.clone(),
            grasp,
            loads: features.loads(&given),
            grasp_loads: given,
            features,
            forces,
            to_labels: canonical.to_scene().filter(|_| labels == LabelNodes::Scene).cloned(),
            displacement: Vec::new(),
            stress: Vec::new(),
            contact: Vec::new(),
            travel: Vec::new(),
            motion: Vec::new(),
            frames: frames.clone(),
        };
        for k in frames {
            let own = k * pads * nodes..(k + 1) * pads * nodes;
            for pad in 0..pads {
                let own = own.start + pad * nodes..own.start + (pad + 1) * nodes;
                let components = 3 * own.start..3 * own.end;
                let [moved, force] =
                    [&data.displacement, &data.contact_force].map(|all| vectors(&all[components.clone()]));
                let stress: Vec<f64> = data.von_mises[own].iter().map(|s| f64::from(*s)).collect();
                let map = canonical.from_scene();
                let force = match map {
                    Some(map) => map.force(&force),
                    None => force,
                };
                let (moved, stress) = match map.filter(|_| labels == LabelNodes::Canonical) {
                    Some(map) => (map.displacement(&moved), map.values(&stress)),
                    None => (moved, stress),
                };
                let single = |v: &DVec3| v.to_array().map(|c| c as f32);
                sample.displacement.extend(moved.iter().flat_map(single));
                sample.stress.extend(stress.iter().map(|s| *s as f32));
                sample.contact.extend(graph.face.iter().flat_map(|i| single(&force[*i as usize])));
            }
            // The travel counts from the first contact of the canonical pads.
            let position = &data.finger_position[k * pads..(k + 1) * pads];
            sample.travel.extend(position.iter().zip(&touch.travel).map(|(now, first)| now - first));
            let Pose { position, rotation } = Pose::from_row(&data.object_pose[7 * k..]);
            let now = Pose { position, rotation };
            for finger in &model.fingers {
                let (shift, turn) = rigid_motion(model, &touch.object, &now, finger.placement.rotation);
                sample.motion.extend(shift.to_array().into_iter().chain(turn.to_array()));
            }
        }
        Ok(sample)
    }

    /// Returns a sample with these levels only.
    pub fn select_levels(&self, levels: &[usize]) -> Self {
        let count = self.forces.len();
        Self {
            object: self.object.clone(),
            grasp: self.grasp,
            frames: levels.iter().map(|l| self.frames[*l]).collect(),
            features: self.features.clone(),
            loads: self.loads.select_levels(levels),
            forces: select_rows(&self.forces, count, levels),
            to_labels: self.to_labels.clone(),
            grasp_loads: select_rows(&self.grasp_loads, count, levels),
            displacement: select_rows(&self.displacement, count, levels),
            stress: select_rows(&self.stress, count, levels),
            contact: select_rows(&self.contact, count, levels),
            travel: select_rows(&self.travel, count, levels),
            motion: select_rows(&self.motion, count, levels),
        }
    }

    /// Computes the loss of `output`: relative errors (L2) of each level in a bounded form
    /// ([`bounded_relative_error`]), averaged over the levels, weighted and added.
    ///
    /// Travel and motion are in the units of [`Normalisers`].
    pub fn loss<E: Real, T: Tape<E>>(
        &self,
        output: NetworkOutput<E, T>,
        norms: &Normalisers,
        mirror: (bool, bool),
        weights: &[f32; 4],
    ) -> LossValue<E, T> {
        let (pads, levels, loads) = (self.features.pads, self.forces.len(), &self.loads);
        let depth = &loads.depth;
        let t = self.features.graph.thickness;
        // Per row of a field: target in the network's unit, and the inverse square of the field's norm at that level.
        let field = |all: &[f32], cols: usize, signs: &[f32], unit: &dyn Fn(usize) -> f64| {
            let per_pad = all.len() / (levels * pads);
            let mut target: Vec<f32> = Vec::with_capacity(all.len());
            for (at, own) in all.chunks_exact(per_pad).enumerate() {
                let unit = unit(at);
                target.extend(own.iter().enumerate().map(|(i, v)| (f64::from(*v) / unit) as f32 * signs[i % cols]));
            }
            let mut rows = Vec::with_capacity(all.len() / cols);
            for level in target.chunks_exact(per_pad * pads) {
                let square: f64 = level.iter().map(|v| f64::from(*v).powi(2)).sum();
                rows.extend(std::iter::repeat_n((1.0 / square.max(1e-12)) as f32, level.len() / cols));
            }
            (target, rows)
        };
        let sign = |parity: &[crate::features::Parity]| parity.iter().map(|p| p.sign(mirror)).collect::<Vec<_>>();
        let (u, u_rows) = field(&self.displacement, 3, &sign(&VECTOR), &|at| depth[at] * f64::from(norms.displacement));
        let stress_unit = |at: usize| self.features.young * depth[at] / t * f64::from(norms.stress);
        let (s, s_rows) = field(&self.stress, 1, &[1.0], &stress_unit);
        // In the pad frame the object presses against the closing direction.
        let turned: Vec<f32> = self.contact.as_chunks::<3>().0.iter().flat_map(|f| [-f[2], f[0], f[1]]).collect();
        let mirrored = [1.0, VECTOR[0].sign(mirror), VECTOR[1].sign(mirror)];
        let (c, c_rows) = field(&turned, 3, &mirrored, &|at| loads.pressing_force[at] * self.features.unit_force());
        let travel = self.travel.iter().zip(&loads.travel).zip(depth).map(|((x, prior), d)| {
            (((x - prior) / d - f64::from(norms.travel[0])) / f64::from(norms.travel[1])) as f32
        });
        let travel: Vec<f32> = travel.collect();
        let each = 1.0 / pads as f32;
        let signs: Vec<f32> = sign(&VECTOR).into_iter().chain(sign(&ROTATION)).collect();
        let motion: Vec<f32> = (self.motion.iter().enumerate())
            .map(|(i, v)| {
                let d = depth[i / 6];
                let unit = if i % 6 < 3 { d * f64::from(norms.motion[0]) } else { d / t * f64::from(norms.motion[1]) };
                ((v - loads.motion[i]) / unit) as f32 * signs[i % 6]
            })
            .collect();
        // The error of the travel is relative to the mean travel.
        let travel_rows: Vec<f32> = (0..levels * pads)
            .map(|i| {
                let own = &self.travel[i / pads * pads..][..pads];
                let mean = (own.iter().sum::<f64>() / pads as f64).abs().max(1e-9);
                each * (f64::from(norms.travel[1]) * depth[i] / mean).powi(2) as f32
            })
            .collect();
        let motion_rows = vec![each / 6.0; levels * pads];
        let part = |x: Matrix<E, T>, target: Vec<f32>, rows: Vec<f32>, weight: f32| {
            bounded_relative_error(x, target, rows, levels) * E::of(weight)
        };
        part(output.displacement, u, u_rows, 1.0)
            + part(output.stress, s, s_rows, weights[0])
            + part(output.contact, c, c_rows, weights[1])
            + part(output.travel, travel, travel_rows, weights[2])
            + part(output.motion, motion, motion_rows, weights[3])
    }
}
