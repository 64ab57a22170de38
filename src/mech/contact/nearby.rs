//! The only points of a pad, or features of an object, that can matter while both have not moved far.

use crate::mech::potential::state::BodyView;
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// Largest motion of a point of a quadratic face over that of its nodes: the sum of the magnitudes of its shape functions.
pub(crate) const BULGE: f64 = 5.0 / 3.0;

/// Numbers of what was near at an earlier state.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct Nearby {
    /// Numbers, ascending.
    pub list: Vec<usize>,
    /// Node positions when they were listed, m; none before.
    x: Vec<DVec3>,
    /// Position of the object then, relative to the finger, m, and its orientation.
    object: (DVec3, DMat3),
    /// Largest distance from the origin of the object of what turns against each other, m.
    pub radius: f64,
}

impl Nearby {
    /// Creates the list of the ascending numbers `list` under `view`; nothing is farther than `radius` (m) from the origin of the object.
    pub fn new(list: Vec<usize>, view: &BodyView, radius: f64) -> Self {
        Self { list, x: view.x.to_vec(), object: object(view), radius }
    }

    /// Bound of the motion of any point of the pad and any of the object against each other since then, m; `+inf` before the first list.
    pub fn moved(&self, view: &BodyView) -> f64 {
        let ((place, turn), (then, turned)) = (object(view), self.object);
        let turn = turn - turned;
        let turn = [turn.x_axis, turn.y_axis, turn.z_axis].map(|c| c.length_squared()).iter().sum::<f64>().sqrt();
        BULGE * motion(&self.x, view.x) + place.distance(then) + turn * self.radius
    }
}

/// Largest distance between two positions of a node, m; `+inf` if they are not of the same mesh.
pub(crate) fn motion(before: &[DVec3], x: &[DVec3]) -> f64 {
    if before.len() != x.len() {
        return f64::INFINITY;
    }
    before.iter().zip(x).map(|(a, b)| a.distance_squared(*b)).fold(0.0, f64::max).sqrt()
}

/// Position of the object relative to the finger, m, and its orientation.
fn object(view: &BodyView) -> (DVec3, DMat3) {
    (view.object.position - view.offset, view.object.rotation)
}
