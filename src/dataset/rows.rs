//! Encoding of one grasp as rows, frame by frame.

use super::arrays::{ARRAYS, FileSizes, MAX_REASON_BYTES, RowName};
use super::compatible::{LoaderFrame, MirrorMap};
use geometry::Pose;
use glam::{DMat4, DVec3};
use model::Model;
use record::{Frame, PadTopology, Status};
use std::sync::Arc;

/// Encoder of frames into rows.
#[derive(Debug)]
pub struct Encoder {
    model: Arc<Model>,
    sizes: FileSizes,
    world: LoaderFrame,
    /// Order in which the nodes and tetrahedra of each pad are stored for the loader.
    mirrors: Vec<MirrorMap>,
    /// False if the mesh of the right pad is not the mirror image of the left one, which the loader assumes.
    pub mirrored: bool,
}

/// Rows of one grasp: bytes by array, in the order of [`FileSizes::rows`].
#[derive(Debug, Clone, PartialEq)]
pub struct GraspRows(pub Vec<Vec<u8>>);

impl Encoder {
    /// Creates an encoder for grasps of `model`.
    pub fn new(model: &Arc<Model>, sizes: FileSizes, world: LoaderFrame) -> Self {
        let pads: Vec<&PadTopology> = model.fingers.iter().map(|finger| finger.topology.as_ref()).collect();
        let mut mirrors: Vec<MirrorMap> = pads.iter().map(|pad| MirrorMap::identity(pad)).collect();
        let mirror = MirrorMap::of(pads[0]).filter(|_| pads.iter().all(|pad| *pad == pads[0]));
        let mirrored = mirror.is_some();
        if let (Some(right), Some(mirror)) = (mirrors.get_mut(1), mirror) {
            *right = mirror;
        }
        Self { model: model.clone(), sizes, world, mirrors, mirrored }
    }

    /// Returns empty rows of a grasp at `pose`.
    pub fn rows(&self, pose: &Pose) -> GraspRows {
        let mut rows = GraspRows(self.sizes.rows().map(|row| vec![0; row.bytes()]).collect());
        rows.doubles(RowName::Pose, 0, pose_row(pose.position, pose.rotation));
        rows
    }

    /// Writes a frame into the rows.
    pub fn frame(&self, rows: &mut GraspRows, frame: &Frame) {
        let s = &self.sizes;
        let (k, pads) = (frame.index, s.pads);
        rows.singles(RowName::StackedForces, k, [frame.applied_force]);
        let object = DMat4::from_rotation_translation(frame.object_rotation, frame.object_position);
        let world = DMat4::from_mat3(LoaderFrame::rotation());
        let mut matrix = world * object;
        matrix.w_axis = self.world.point(frame.object_position).extend(1.0);
        // Row-major, as NumPy reads it.
        rows.singles(RowName::StackedObjectFrame, k * 16, matrix.transpose().to_cols_array());
        let (mut corner, mut tet) = (k * s.corners, k * s.tets);
        for (i, (pad, finger)) in frame.pads.iter().zip(&self.model.fingers).enumerate() {
            let to_pad = finger.placement.rotation.transpose();
            let (mirror, at) = (&self.mirrors[i], k * pads + i);
            let positions = mirror.nodes.iter().flat_map(|&n| self.world.point(pad.position[n]).to_array());
            rows.singles(RowName::StackedPositions, 3 * corner, positions);
            rows.singles(RowName::StackedStresses, tet, mirror.tets.iter().map(|&t| pad.von_mises_element[t]));
            (corner, tet) = (corner + mirror.nodes.len(), tet + mirror.tets.len());
            let vectors = |v: &[DVec3]| v.iter().flat_map(|v| (to_pad * *v).to_array()).collect::<Vec<_>>();
            rows.singles(RowName::Displacement, 3 * s.nodes * at, vectors(&pad.displacement));
            rows.singles(RowName::ContactForce, 3 * s.nodes * at, vectors(&pad.contact_force));
            rows.singles(RowName::VonMises, s.nodes * at, pad.von_mises_node.iter().copied());
            rows.doubles(RowName::Wrench, 6 * at, pad.wrench.rotated(|v| to_pad * v).row());
            rows.doubles(RowName::Travel, at, [frame.travel[i]]);
            let carried = pad.rigid_translation(&finger.body.rest);
            rows.doubles(RowName::FingerPosition, at, [carried.dot(finger.placement.closing)]);
        }
        let load = frame.object_load;
        rows.doubles(RowName::ObjectLoad, 6 * k, load.row());
        rows.doubles(RowName::ObjectPose, 7 * k, pose_row(frame.object_position, frame.object_rotation));
        for (name, value) in [
            (RowName::Force, frame.applied_force),
            (RowName::Energy, frame.energy),
            (RowName::Residual, frame.residual),
            (RowName::ForceBalance, frame.force_balance),
            (RowName::TorqueBalance, frame.torque_balance),
            (RowName::MinDetF, frame.min_det_f),
            (RowName::MinGap, frame.min_gap),
        ] {
            rows.doubles(name, k, [value]);
        }
        rows.integer(RowName::NewtonIterations, k, frame.newton_iterations);
        for (array, row) in frame.tactile.iter().zip(&mut rows.0[ARRAYS.len()..]) {
            singles(row, k * array.values.len(), array.values.iter().copied());
        }
    }

    /// Completes the rows with status, reason, number of frames and checksum; returns the checksum.
    pub fn finish(&self, rows: &mut GraspRows, status: Status, reason: &str, frames: usize) -> blake3::Hash {
        if status != Status::Reached {
            // The loader takes every frame as valid and skips only grasps with zero forces.
            for (index, _) in ARRAYS.iter().enumerate().filter(|(_, a)| a.name.starts_with("_1_")) {
                rows.0[index].fill(0);
            }
        }
        rows.integer(RowName::RecordedFrames, 0, frames as u32);
        rows.0[RowName::Status as usize][0] = code(status);
        // Truncated at a character boundary, so that the text remains valid UTF-8.
        let end = (0..=MAX_REASON_BYTES.min(reason.len())).rev().find(|&i| reason.is_char_boundary(i)).unwrap_or(0);
        rows.0[RowName::Reason as usize][..end].copy_from_slice(&reason.as_bytes()[..end]);
        let hash = checksum(&rows.0);
        rows.0[RowName::Checksum as usize].copy_from_slice(hash.as_bytes());
        hash
    }
}

/// Computes the BLAKE3 of all rows except the checksum.
pub fn checksum(rows: &[Vec<u8>]) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    let others = rows.iter().enumerate().filter(|(array, _)| *array != RowName::Checksum as usize);
    others.for_each(|(_, row)| {
        hasher.update(row);
    });
    hasher.finalize()
}

/// Returns the code of a status in the file; 0 means not simulated.
pub fn code(status: Status) -> u8 {
    match status {
        Status::Reached => 1,
        Status::Fault => 2,
        Status::Infeasible => 3,
        Status::Dropped => 4,
    }
}

fn pose_row(p: DVec3, q: glam::DQuat) -> [f64; 7] {
    [p.x, p.y, p.z, q.w, q.x, q.y, q.z]
}

/// Writes single-precision numbers into a row, starting at index `first`.
fn singles(row: &mut [u8], first: usize, values: impl Iterator<Item = f32>) {
    row[4 * first..].chunks_exact_mut(4).zip(values).for_each(|(b, v)| b.copy_from_slice(&v.to_le_bytes()));
}

impl GraspRows {
    fn singles(&mut self, name: RowName, first: usize, values: impl IntoIterator<Item = f64>) {
        singles(&mut self.0[name as usize], first, values.into_iter().map(|v| v as f32));
    }

    fn doubles(&mut self, name: RowName, first: usize, values: impl IntoIterator<Item = f64>) {
        let row = &mut self.0[name as usize][8 * first..];
        row.chunks_exact_mut(8).zip(values).for_each(|(b, v)| b.copy_from_slice(&v.to_le_bytes()));
    }

    fn integer(&mut self, name: RowName, at: usize, value: u32) {
        self.0[name as usize][4 * at..4 * at + 4].copy_from_slice(&value.to_le_bytes());
    }
}
