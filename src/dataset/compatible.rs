//! Coordinate conventions of the public loader of DefGraspSim's tactile grasps.
//!
//! The hand of the loader closes along y, its world has Y up, and its pads are at (-0.0006, +-0.0275, 0.099) m in the
//! hand. Its right pad is the point reflection of its left pad, whereas a real right pad is the left pad rotated by 180
//! degrees about the approach axis. Both are the same body if the pad is mirror-symmetric along the approach axis. Node
//! i of the right pad is then stored as the node at the mirrored position, and the undeformed shapes of the loader are
//! correct.

use geometry::mesh::TetMesh;
use glam::{DMat3, DVec3};
use record::{ElementNodes, PadTopology};
use scene::Placement;
use std::collections::HashMap;

/// Centre of the pads in the loader's hand, along the finger width and the approach, m.
const CENTER: [f64; 2] = [-0.0006, 0.099];

/// Transformation from the hand frame to the loader's world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoaderFrame {
    offset: DVec3,
}

impl LoaderFrame {
    /// Returns the transformation for a gripper with this placement of its pads.
    pub fn new(placement: &Placement) -> Self {
        let offset = DVec3::new(CENTER[0] - placement.y.get(), 1.0 + CENTER[1] - placement.z.get(), 0.0);
        Self { offset }
    }

    /// Maps a point of the hand frame, m.
    pub fn point(&self, hand: DVec3) -> DVec3 {
        Self::rotation() * hand + self.offset
    }

    /// Returns the rotation from hand axes to world axes: (x, y, z) becomes (y, z, x).
    pub fn rotation() -> DMat3 {
        DMat3::from_cols(DVec3::Z, DVec3::X, DVec3::Y)
    }
}

/// Returns the mesh of `tactile_sensor.tet`: bonded face at y = 0, outward normal +y.
pub fn sensor(pad: &PadTopology) -> TetMesh {
    let back = pad.rest.iter().fold(f64::INFINITY, |low, p| low.min(p.z));
    let nodes = pad.rest[..pad.corner_count].iter().map(|p| DVec3::new(p.x, p.z - back, -p.y)).collect();
    TetMesh { nodes, tets: corner_tets(&pad.elements) }
}

/// Returns the corners of the tetrahedra.
fn corner_tets(elements: &ElementNodes) -> Vec<[u32; 4]> {
    match elements {
        ElementNodes::Linear(tets) => tets.clone(),
        ElementNodes::Quadratic(tets) => tets.iter().map(|t| [t[0], t[1], t[2], t[3]]).collect(),
    }
}

/// Nodes and tetrahedra of the right pad that are stored as node i and tetrahedron t of the loader.
#[derive(Debug, Clone, PartialEq)]
pub struct MirrorMap {
    /// Indices of the corner nodes.
    pub nodes: Vec<usize>,
    /// Indices of the tetrahedra.
    pub tets: Vec<usize>,
}

impl MirrorMap {
    /// Returns the mirror image of the pad along the approach (pad x); None if the mesh is not mirror-symmetric.
    pub fn of(pad: &PadTopology) -> Option<Self> {
        let key = |p: DVec3| p.to_array().map(|x| (x * 1e8).round() as i64);
        let corners = &pad.rest[..pad.corner_count];
        let places: HashMap<_, _> = corners.iter().enumerate().map(|(i, p)| (key(*p), i)).collect();
        let across = |p: &DVec3| places.get(&key(DVec3::new(-p.x, p.y, p.z))).copied();
        let nodes: Vec<usize> = corners.iter().map(across).collect::<Option<_>>()?;
        let sorted = |t: [usize; 4]| {
            let mut t = t;
            t.sort_unstable();
            t
        };
        let tets = corner_tets(&pad.elements);
        let known: HashMap<_, _> = tets.iter().enumerate().map(|(i, t)| (sorted(t.map(|n| n as usize)), i)).collect();
        let tets = tets.iter().map(|t| known.get(&sorted(t.map(|n| nodes[n as usize]))).copied());
        Some(Self { tets: tets.collect::<Option<_>>()?, nodes })
    }

    /// Returns the identity map.
    pub fn identity(pad: &PadTopology) -> Self {
        Self { nodes: (0..pad.corner_count).collect(), tets: (0..pad.elements.len()).collect() }
    }
}
