//! Coulomb's friction cone: the tangential force that a normal force can carry. Forces and tractions share one unit.

use glam::DVec3;

/// Returns true if a tangential force of this `size` slips under `limit`. A force that was projected onto the limit
/// still counts as slipping, despite rounding.
#[inline(always)]
pub fn slips(size: f64, limit: f64) -> bool {
    size > limit * (1.0 - 1e-9)
}

/// Returns the factor by which the projection onto the friction cone scales a tangential force of this `size`.
#[inline(always)]
pub fn cone_factor(size: f64, limit: f64) -> f64 {
    if slips(size, limit) { limit / size } else { 1.0 }
}

/// Returns the tangential part of `force`, which presses against the unit `normal`, and its size over Coulomb's limit;
/// infinite where `force` does not press.
pub fn tangential(force: DVec3, normal: DVec3, friction: f64) -> (DVec3, f64) {
    let pressing = force.dot(normal);
    let along = force - normal * pressing;
    let size = along.length();
    (along, if size == 0.0 { 0.0 } else { size / (friction * pressing.max(0.0)) })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A normal force of 10 N carries 5 N at friction 0.5: a tangential force of 8 N is reduced to 5 N, which still
    /// count as slipping.
    #[test]
    fn a_force_is_projected_onto_the_cone() {
        let (along, used) = tangential(DVec3::new(8.0, 0.0, 10.0), DVec3::Z, 0.5);
        assert_eq!((along, used), (DVec3::X * 8.0, 1.6));
        let left = along * cone_factor(along.length(), 5.0);
        assert!((left.length() - 5.0).abs() < 1e-12, "{left} N");
        assert!(slips(left.length(), 5.0));
        assert_eq!(cone_factor(3.0, 5.0), 1.0);
        assert_eq!(tangential(DVec3::X - DVec3::Z, DVec3::Z, 0.5).1, f64::INFINITY);
    }
}
