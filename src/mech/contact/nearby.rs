//! List of the pad points, or contact vertices of the object, that can touch while neither body has moved far since it
//! was built.

use crate::potential::state::BodyView;
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// Largest motion of a point of a quadratic face over that of its nodes: the maximum of the sum of its shape functions'
/// magnitudes.
pub(crate) const QUADRATIC_MOTION_RATIO: f64 = 5.0 / 3.0;

/// Indices of the points that were near at an earlier state.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct NearbyList {
    /// Indices, ascending.
    pub list: Vec<usize>,
    /// Node positions when the list was built, m; empty before.
    x: Vec<DVec3>,
    /// Position of the object relative to the finger, m, and its orientation when the list was built.
    object: (DVec3, DMat3),
    /// Largest distance from the origin of the object of the points that may rotate relative to each other, m.
    pub radius: f64,
}

impl NearbyList {
    /// Creates the list of the ascending indices `list` under `view`; no point is farther than `radius` (m) from the
    /// origin of the object.
    pub fn new(list: Vec<usize>, view: &BodyView, radius: f64) -> Self {
        Self { list, x: view.x.to_vec(), object: object(view), radius }
    }

    /// Upper bound of the relative motion of any point of the pad and any of the object since the list was built, m;
    /// `+inf` before the first list.
    pub fn moved(&self, view: &BodyView) -> f64 {
        let ((place, turn), (then, turned)) = (object(view), self.object);
        let turn = turn - turned;
        let turn = [turn.x_axis, turn.y_axis, turn.z_axis].map(|c| c.length_squared()).iter().sum::<f64>().sqrt();
        QUADRATIC_MOTION_RATIO * largest_node_motion(&self.x, view.x) + place.distance(then) + turn * self.radius
    }
}

/// Largest distance between two positions of a node, m; `+inf` if the meshes differ.
pub(crate) fn largest_node_motion(before: &[DVec3], x: &[DVec3]) -> f64 {
    if before.len() != x.len() {
        return f64::INFINITY;
    }
    before.iter().zip(x).map(|(a, b)| a.distance_squared(*b)).fold(0.0, f64::max).sqrt()
}

/// Position of the object relative to the finger, m, and its orientation.
fn object(view: &BodyView) -> (DVec3, DMat3) {
    (view.object.position - view.offset, view.object.rotation)
}
