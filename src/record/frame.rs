//! Recorded frame of a grasp: the data exchanged between the steppers and all file writers.
//!
//! All quantities are in the hand frame and in SI units unless stated otherwise.

use super::{ErrorBound, TactileArray};
use geometry::Wrench;
use geometry::mesh::quality::EDGES;
use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeSet, HashMap};

/// State of one pad in one frame. Node arrays follow [`PadTopology::rest`], element arrays [`PadTopology::elements`].
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PadFrame {
    /// Deformed node positions, m.
    pub position: Vec<DVec3>,
    /// Node displacements relative to the pad carried rigidly by its finger, m.
    pub displacement: Vec<DVec3>,
    /// Nodal contact force on the pad, N; empty if not recorded.
    pub contact_force: Vec<DVec3>,
    /// Nodal von Mises stress, the volume-weighted average over the elements at the node, Pa; empty if not recorded.
    pub von_mises_node: Vec<f64>,
    /// Von Mises stress per element, Pa; empty if not recorded.
    pub von_mises_element: Vec<f64>,
    /// Signed distance of each node to the object, m; negative inside; empty if not recorded.
    pub gap: Vec<f64>,
    /// Fraction of the contact force of each node that is carried by sliding contact points, 0 to 1; empty unless an
    /// observation requires it.
    pub slip: Vec<f64>,
    /// Contact area in the reference configuration, m2; zero unless an observation requires it.
    pub contact_area: f64,
    /// Contact wrench on this pad, about the origin of its frame.
    pub wrench: Wrench,
}

impl PadFrame {
    /// Returns the translation by the finger from the node positions `rest` to the rigidly carried pad, m.
    pub fn rigid_translation(&self, rest: &[DVec3]) -> DVec3 {
        // The motion of a finger is a translation, so any node yields it.
        self.position[0] - self.displacement[0] - rest[0]
    }
}

/// Additional state of a frame of a dynamic scene. The world frame is the object frame at the start.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct DynamicState {
    /// Origin of the hand frame in the world, m.
    pub hand_position: DVec3,
    /// Rotation from the hand frame to the world.
    pub hand_rotation: DQuat,
    /// Velocity of the object's centre of mass, m/s, world axes.
    pub velocity: DVec3,
    /// Angular velocity of the object, rad/s, world axes.
    pub spin: DVec3,
    /// Linear momentum of the object, kg m/s, world axes.
    pub momentum: DVec3,
    /// Angular momentum of the object about its centre of mass, kg m2/s, world axes.
    pub angular_momentum: DVec3,
    /// Force of the ground on the object, N, world axes.
    pub ground_force: DVec3,
}

/// Recorded frame of a grasp.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// Index of the frame in its grasp, from 0.
    pub index: usize,
    /// Applied force, the sum over the fingers, N.
    pub applied_force: f64,
    /// Simulated time, s; 0 in quasi-static scenes.
    pub time: f64,
    /// Closing travel of each finger since first contact, left first, m.
    pub travel: Vec<f64>,
    /// Origin of the object frame, m.
    pub object_position: DVec3,
    /// Rotation from the object frame to the hand frame.
    pub object_rotation: DQuat,
    /// External load on the object (weight and applied push): force and torque about its centre of mass.
    pub object_load: Wrench,
    /// States of the pads, left first.
    pub pads: Vec<PadFrame>,
    /// Dynamic state; None in quasi-static scenes.
    pub moving: Option<DynamicState>,
    /// Value of the incremental potential, J.
    pub energy: f64,
    /// Number of Newton iterations of this frame.
    pub newton_iterations: u32,
    /// True while the object is held fixed.
    pub object_fixed: bool,
    /// Smallest det F over all elements; positive if no element is inverted; `+inf` without pads.
    pub min_det_f: f64,
    /// Smallest gap between the object and pads or ground, m; positive if nothing penetrates; `+inf` if nothing is near
    /// contact.
    pub min_gap: f64,
    /// Unbalanced force over the applied force. For a free object it is the norm of the sum of contact force and
    /// weight; otherwise the difference between the contact force on a finger and the force applied by the finger.
    pub force_balance: f64,
    /// |sum of the contact torques on the object| / (applied force x object size).
    pub torque_balance: f64,
    /// Norm of the unbalanced nodal forces after the last Newton iteration, N.
    pub residual: f64,
    /// Estimated error of a prediction; None for frames computed by finite elements.
    pub error: Option<ErrorBound>,
    /// Readings of the tactile sensors, in the order of the scene; empty if not recorded.
    pub tactile: Vec<TactileArray>,
}

impl Frame {
    /// Transforms a point of the hand frame to the display frame, m: the world in dynamic scenes, otherwise the hand
    /// frame.
    pub fn to_display_point(&self, x: DVec3) -> DVec3 {
        self.moving.as_ref().map_or(x, |m| m.hand_position + m.hand_rotation * x)
    }

    /// Returns the rotation from the object frame to the display frame (see [`Frame::to_display_point`]).
    pub fn display_rotation(&self) -> DQuat {
        self.moving.as_ref().map_or(self.object_rotation, |m| m.hand_rotation * self.object_rotation)
    }

    /// Rotates a vector from hand axes to the axes of the display frame.
    pub fn to_display_vector(&self, v: DVec3) -> DVec3 {
        self.moving.as_ref().map_or(v, |m| m.hand_rotation * v)
    }
}

/// Tetrahedra of a pad, node indices 0-based.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum ElementNodes {
    /// Four corners.
    Linear(Vec<[u32; 4]>),
    /// Four corners, then the mid-edge nodes (0,1) (1,2) (2,0) (0,3) (1,3) (2,3): the order of `VTK_QUADRATIC_TETRA`.
    Quadratic(Vec<[u32; 10]>),
}

impl Default for ElementNodes {
    fn default() -> Self {
        ElementNodes::Linear(Vec::new())
    }
}

impl ElementNodes {
    /// Creates tetrahedra from a flat list of `nodes`, `width` per tetrahedron; None if `width` is neither 4 nor 10.
    pub fn from_flat(nodes: &[u32], width: usize) -> Option<Self> {
        match width {
            4 => Some(ElementNodes::Linear(nodes.as_chunks().0.to_vec())),
            10 => Some(ElementNodes::Quadratic(nodes.as_chunks().0.to_vec())),
            _ => None,
        }
    }

    /// Returns the number of corner nodes, which come first in the numbering.
    pub fn corners(&self) -> usize {
        self.nodes().chunks_exact(self.width()).flat_map(|n| &n[..4]).max().map_or(0, |n| *n as usize + 1)
    }

    /// Returns the number of tetrahedra.
    pub fn len(&self) -> usize {
        match self {
            ElementNodes::Linear(tets) => tets.len(),
            ElementNodes::Quadratic(tets) => tets.len(),
        }
    }

    /// Returns true if there are no tetrahedra.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the number of nodes per tetrahedron: 4 or 10.
    pub fn width(&self) -> usize {
        match self {
            ElementNodes::Linear(_) => 4,
            ElementNodes::Quadratic(_) => 10,
        }
    }

    /// Returns `"linear"` or `"quadratic"`.
    pub fn name(&self) -> &'static str {
        match self {
            ElementNodes::Linear(_) => "linear",
            ElementNodes::Quadratic(_) => "quadratic",
        }
    }

    /// Returns the nodes of all tetrahedra as a flat list, [`Self::width`] per tetrahedron.
    pub fn nodes(&self) -> &[u32] {
        match self {
            ElementNodes::Linear(tets) => tets.as_flattened(),
            ElementNodes::Quadratic(tets) => tets.as_flattened(),
        }
    }
}

/// Mesh of a pad, constant during a run.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PadTopology {
    /// Reference positions of the nodes in the pad frame (sensing face at z = 0, +z out of the gel), m; corners first.
    pub rest: Vec<DVec3>,
    /// Number of element corners, which are the first nodes; the others are mid-edge nodes.
    pub corner_count: usize,
    /// Nodes of the tetrahedra.
    pub elements: ElementNodes,
    /// Corner triangles of the whole outer surface, counter-clockwise seen from outside.
    pub surface: Vec<[u32; 3]>,
    /// Triangles of the sensing face, counter-clockwise seen from outside; may use mid-edge nodes.
    pub sensing: Vec<[u32; 3]>,
    /// Flag per node: true if it is bonded to the finger.
    pub bonded: Vec<bool>,
}

impl PadTopology {
    /// Returns the depth of the deepest node below the sensing face in the reference configuration, m.
    pub fn thickness(&self) -> f64 {
        self.rest.iter().map(|x| -x.z).fold(0.0, f64::max)
    }

    /// Returns the nodes of the sensing face, ascending.
    pub fn sensing_nodes(&self) -> Vec<u32> {
        self.sensing.iter().flatten().copied().collect::<BTreeSet<_>>().into_iter().collect()
    }

    /// Returns the triangles of the outer surface without the sensing face, whose own triangles are finer. Triangles
    /// adjacent to the sensing face are split at its mid-edge nodes, so that the two meshes are conforming.
    pub fn outer_triangles(&self) -> Vec<[u32; 3]> {
        let mut sensing = vec![false; self.rest.len()];
        self.sensing.as_flattened().iter().for_each(|&n| sensing[n as usize] = true);
        let edge = |a: u32, b: u32| [a.min(b), a.max(b)];
        let mut middle = HashMap::new();
        if let ElementNodes::Quadratic(tets) = &self.elements {
            let edges = tets.iter().flat_map(|t| EDGES.iter().zip(&t[4..]).map(|((a, b), m)| (edge(t[*a], t[*b]), *m)));
            middle.extend(edges.filter(|(_, m)| sensing[*m as usize]));
        }
        let split = |t: &[u32; 3]| {
            let corners = [0, 1, 2].map(|k| [Some(t[k]), middle.get(&edge(t[k], t[(k + 1) % 3])).copied()]);
            let mut rim: Vec<u32> = corners.into_iter().flatten().flatten().collect();
            // A fan from a mid-edge node avoids a degenerate triangle along the edge of that node.
            rim.rotate_left(corners.iter().position(|c| c[1].is_some()).map_or(0, |k| k + 1));
            (1..rim.len() - 1).map(|k| [rim[0], rim[k], rim[k + 1]]).collect::<Vec<_>>()
        };
        self.surface.iter().filter(|t| !t.iter().all(|&n| sensing[n as usize])).flat_map(split).collect()
    }
}

/// Returns the name of pad and finger `index` in files and pictures: `left`, `right`, then `pad2` and so on.
pub fn pad_name(index: usize) -> String {
    match index {
        0 => "left".into(),
        1 => "right".into(),
        more => format!("pad{more}"),
    }
}
