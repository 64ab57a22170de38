//! Recording of a grasp for the 3-D viewer of the page.
//!
//! Only surface nodes are stored, in the pad frame, because the interior is not visible. The page positions the pads
//! itself, closed or unfolded.

use super::packed::{indices, numbers};
use base::error::{Error, Result};
use dataset::ObjectFile;
use dataset::inspect::{frame, sample_frames};
use geometry::mesh::TriMesh;
use glam::{DMat3, DVec3};
use record::render::pad_pose;
use record::{Frame, PadFrame, PadTopology};
use serde::Serialize;
use serde_json::{Value, json};

/// Frames of a grasp.
#[derive(Debug, Clone)]
pub struct Recording {
    /// Name of the grasp.
    pub name: String,
    /// Role of the grasp among the examples (e.g. the worst); may be empty.
    pub about: String,
    /// Meshes of its pads, left first.
    pub pads: Vec<PadTopology>,
    /// Surface of the object, object frame, m.
    pub object: TriMesh,
    /// States: the truth, then the prediction if any, at the same frames.
    pub states: Vec<RecordedState>,
    /// Errors of the prediction in each frame.
    pub errors: Option<Errors>,
}

/// Frames computed by one backend.
#[derive(Debug, Clone)]
pub struct RecordedState {
    /// Name of the backend: `finite elements`, `network`.
    pub label: String,
    /// Frames of the grasp.
    pub frames: Vec<Frame>,
}

/// Errors of each frame, relative to the norm of the field.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Errors {
    /// Error of the displacement.
    pub displacement: Vec<f64>,
    /// Error of the von Mises stress.
    pub stress: Vec<f64>,
    /// Error of the nodal contact force.
    pub contact_force: Vec<f64>,
}

impl Recording {
    /// Returns the grasp as JSON. Meshes are shared between grasps: they are stored in `meshes`, and the grasp refers
    /// to their indices.
    ///
    /// # Errors
    /// Fails if the grasp has no frames or no pads, or if the pose of a pad cannot be determined.
    pub fn json(&self, meshes: &mut Vec<Value>) -> Result<Value> {
        let fail = |message: &str| Error::Start(format!("{}: {message}", self.name));
        let first = self.states.first().and_then(|s| s.frames.first()).ok_or_else(|| fail("has no frame to show"))?;
        let poses = self.pads.iter().zip(&first.pads).map(|(pad, frame)| pad_pose(pad, frame));
        let rotations: Vec<DMat3> = poses.filter_map(|pose| pose.map(|p| p.0)).collect();
        if rotations.len() != first.pads.len() || rotations.is_empty() {
            return Err(fail("has no pad with an extent"));
        }
        let surfaces: Vec<Surface> = self.pads.iter().zip(&rotations).map(|(pad, r)| Surface::of(pad, *r)).collect();
        let states = self.states.iter().map(|s| state(&surfaces, s)).collect::<Vec<_>>();
        let time = first.moving.is_some();
        let at = self.states[0].frames.iter().map(|f| if time { f.time } else { f.applied_force });
        let axis = if time { json!({ "name": "time", "unit": "s" }) } else { json!({ "name": "force", "unit": "N" }) };
        Ok(json!({
            "name": self.name,
            "about": self.about,
            "axis": axis,
            "at": at.collect::<Vec<_>>(),
            "force": self.states[0].frames.iter().map(|f| f.applied_force).collect::<Vec<_>>(),
            "pads": surfaces.iter().map(|surface| place(meshes, surface.json())).collect::<Vec<_>>(),
            "object": place(meshes, object(&self.object)),
            "rotations": rotations.iter().map(DMat3::to_cols_array).collect::<Vec<_>>(),
            "states": states,
            "errors": self.errors,
        }))
    }
}

/// Returns the index of `mesh` in `meshes`; appends it if it is not there.
fn place(meshes: &mut Vec<Value>, mesh: Value) -> usize {
    meshes.iter().position(|m| *m == mesh).unwrap_or_else(|| {
        meshes.push(mesh);
        meshes.len() - 1
    })
}

fn object(mesh: &TriMesh) -> Value {
    json!({
        "vertices": numbers(&[mesh.vertices.len(), 3], &flat(&mesh.vertices)),
        "triangles": indices(&[mesh.triangles.len(), 3], mesh.triangles.as_flattened()),
    })
}

fn flat(vectors: &[DVec3]) -> Vec<f64> {
    vectors.iter().flat_map(DVec3::to_array).collect()
}

/// Visible surface of a pad.
struct Surface<'a> {
    pad: &'a PadTopology,
    /// Rotation from the pad frame to the hand frame.
    rotation: DMat3,
    nodes: Vec<usize>,
    sensing: Vec<u32>,
    outside: Vec<u32>,
}

impl<'a> Surface<'a> {
    fn of(pad: &'a PadTopology, rotation: DMat3) -> Self {
        let outside = pad.outer_triangles();
        let mut seen = vec![false; pad.rest.len()];
        pad.sensing.iter().chain(&outside).flatten().for_each(|n| seen[*n as usize] = true);
        let nodes: Vec<usize> = (0..seen.len()).filter(|n| seen[*n]).collect();
        let mut number = vec![0; seen.len()];
        (0..).zip(&nodes).for_each(|(k, n)| number[*n] = k);
        let renumbered =
            |all: &[[u32; 3]]| all.as_flattened().iter().map(|n| number[*n as usize]).collect::<Vec<u32>>();
        Self { sensing: renumbered(&pad.sensing), outside: renumbered(&outside), nodes, pad, rotation }
    }

    fn json(&self) -> Value {
        let rest: Vec<DVec3> = self.nodes.iter().map(|n| self.pad.rest[*n]).collect();
        json!({
            "rest": numbers(&[rest.len(), 3], &flat(&rest)),
            "sensing": indices(&[self.sensing.len() / 3, 3], &self.sensing),
            "outside": indices(&[self.outside.len() / 3, 3], &self.outside),
        })
    }

    /// Returns a vector field at the visible nodes, in the pad frame; None if it was not recorded.
    fn vectors(&self, field: &[DVec3]) -> Option<Vec<DVec3>> {
        self.nodes.iter().map(|n| field.get(*n).map(|v| self.rotation.transpose() * *v)).collect()
    }

    /// Returns the origin of the pad frame in the hand frame, m.
    fn origin(&self, pad: &PadFrame) -> DVec3 {
        // `position - displacement` is the rigidly moved reference shape, so any node can be used.
        pad.position[0] - pad.displacement[0] - self.rotation * self.pad.rest[0]
    }
}

/// Returns a state as JSON: fields of the visible nodes (frames, then nodes of all pads, left first), and poses of pads
/// and object in the hand frame.
fn state(surfaces: &[Surface], state: &RecordedState) -> Value {
    let (frames, nodes) = (state.frames.len(), surfaces.iter().map(|s| s.nodes.len()).sum::<usize>());
    let all = || state.frames.iter().flat_map(|f| f.pads.iter().zip(surfaces));
    let vectors = |pick: fn(&PadFrame) -> &Vec<DVec3>| -> Option<Vec<DVec3>> {
        let fields = all().map(|(pad, surface)| surface.vectors(pick(pad))).collect::<Option<Vec<_>>>();
        fields.map(|fields| fields.concat())
    };
    let displacement = vectors(|p| &p.displacement).unwrap_or_default();
    let stress: Option<Vec<f64>> =
        all().flat_map(|(p, surface)| surface.nodes.iter().map(|n| p.von_mises_node.get(*n).copied())).collect();
    let force = vectors(|p| &p.contact_force).map(|force| {
        // Only nodes that are in contact in some frame are stored.
        let touched = |i: &usize| (0..frames).any(|k| force[k * nodes + i] != DVec3::ZERO);
        let touched: Vec<usize> = (0..nodes).filter(touched).collect();
        let kept = (0..frames).flat_map(|k| touched.iter().map(move |i| (k, *i)));
        let kept: Vec<DVec3> = kept.map(|(k, i)| force[k * nodes + i]).collect();
        let places: Vec<u32> = touched.iter().map(|i| *i as u32).collect();
        json!({
            "nodes": indices(&[touched.len()], &places),
            "values": numbers(&[frames, touched.len(), 3], &flat(&kept)),
        })
    });
    let origins = state.frames.iter().map(|f| {
        let own = f.pads.iter().zip(surfaces).map(|(pad, surface)| surface.origin(pad).to_array());
        own.collect::<Vec<_>>()
    });
    let object = state.frames.iter().map(|f| {
        let (p, q) = (f.object_position, f.object_rotation);
        [p.x, p.y, p.z, q.w, q.x, q.y, q.z]
    });
    json!({
        "label": state.label,
        "displacement": numbers(&[frames, nodes, 3], &flat(&displacement)),
        "stress": stress.map(|s| numbers(&[frames, nodes], &s)),
        "contact_force": force,
        "origins": origins.collect::<Vec<_>>(),
        "object": object.collect::<Vec<_>>(),
        "travel": state.frames.iter().map(|f| &f.travel).collect::<Vec<_>>(),
    })
}

/// Returns the recording of grasp `number` of a data set, with at most `most` of its frames.
pub(super) fn dataset_recording(file: &ObjectFile, number: usize, most: usize) -> Result<Recording> {
    let grasp = file.grasp(number)?;
    let frames = sample_frames(grasp.frames, Some(most)).into_iter().map(|k| frame(file, &grasp, k)).collect();
    Ok(Recording {
        name: format!("{}, grasp {number}", file.name),
        about: String::new(),
        pads: file.pads.clone(),
        object: file.object.clone(),
        states: vec![RecordedState { label: "finite elements".into(), frames }],
        errors: None,
    })
}
