//! Rigid transform from the pad frame to the hand frame, recovered from a frame.

use crate::{PadFrame, PadTopology};
use glam::{DMat3, DVec3};

/// Returns the rotation and the origin of the pad frame in the hand frame (m); `None` if the nodes are collinear.
///
/// `position - displacement` is the rigidly moved reference shape, so three distant nodes determine the motion exactly.
pub fn pad_pose(topology: &PadTopology, pad: &PadFrame) -> Option<(DMat3, DVec3)> {
    let rest = &topology.rest;
    let count = rest.len().min(pad.position.len()).min(pad.displacement.len());
    let farthest = |score: &dyn Fn(usize) -> f64| (0..count).max_by(|&i, &j| score(i).total_cmp(&score(j)));
    let first = farthest(&|i| rest[i].length_squared())?;
    let second = farthest(&|i| rest[i].distance_squared(rest[first]))?;
    let along = rest[second] - rest[first];
    let third = farthest(&|i| (rest[i] - rest[first]).cross(along).length_squared())?;
    let carried = |i: usize| pad.position[i] - pad.displacement[i];
    let before = basis(rest[first], rest[second], rest[third])?;
    let after = basis(carried(first), carried(second), carried(third))?;
    let rotation = after * before.transpose();
    Some((rotation, carried(first) - rotation * rest[first]))
}

fn basis(a: DVec3, b: DVec3, c: DVec3) -> Option<DMat3> {
    let x = (b - a).try_normalize()?;
    let z = (b - a).cross(c - a).try_normalize()?;
    Some(DMat3::from_cols(x, z.cross(x), z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    #[test]
    fn a_known_motion_is_recovered_whatever_the_displacement() {
        let rest = vec![DVec3::ZERO, DVec3::X, DVec3::Y * 2.0, DVec3::new(0.3, 0.2, 0.5)];
        let (turn, origin) = (DQuat::from_rotation_z(0.7) * DQuat::from_rotation_x(2.0), DVec3::new(0.1, -0.2, 0.3));
        let displacement: Vec<DVec3> = (0..4).map(|i| DVec3::splat(0.1 * f64::from(i))).collect();
        let position = rest.iter().zip(&displacement).map(|(&r, &u)| origin + turn * r + u).collect();
        let topology = PadTopology { rest, ..PadTopology::default() };
        let frame = PadFrame { position, displacement, ..PadFrame::default() };
        let Some((rotation, moved)) = pad_pose(&topology, &frame) else { panic!("no pose") };
        assert!((rotation - DMat3::from_quat(turn)).to_cols_array().iter().all(|e| e.abs() < 1e-12));
        assert!(moved.distance(origin) < 1e-12);
    }
}
