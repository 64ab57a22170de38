//! Norms of the difference of two frames.

use super::fields::{Fields, Points};
use glam::DVec3;

/// Distances of one frame of a grasp from another over all pads. Relative distances are divided by the norm of the
/// other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameDistance {
    /// Displacement, L2 over the volume of the gel, relative.
    pub displacement: f64,
    /// Von Mises stress, L2 over the volume of the gel, relative.
    pub stress: f64,
    /// Contact force on the pads, relative.
    pub force: f64,
    /// Travel of the fingers, relative.
    pub travel: f64,
    /// Displacement, largest at a point, m.
    pub displacement_max_m: f64,
    /// Von Mises stress, largest at a point, Pa.
    pub stress_max_pa: f64,
}

impl FrameDistance {
    /// Computes the distances of `own` from `truth`, at the same points.
    pub fn of(points: &Points, own: &Fields, truth: &Fields) -> Self {
        let apart: Vec<f64> = own.displacement.iter().zip(&truth.displacement).map(|(a, b)| a.distance(*b)).collect();
        let stress: Vec<f64> = own.stress.iter().zip(&truth.stress).map(|(a, b)| a - b).collect();
        let norm = |values: &mut dyn Iterator<Item = f64>| {
            let volumes = points.volume.iter().cycle();
            values.zip(volumes).map(|(v, w)| w * v * v).sum::<f64>().sqrt()
        };
        let largest = |values: &[f64]| values.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let length = |v: &[DVec3]| v.iter().map(|f| f.length()).sum::<f64>();
        let force: Vec<DVec3> = own.force.iter().zip(&truth.force).map(|(a, b)| *a - *b).collect();
        let travel = own.travel.iter().zip(&truth.travel).map(|(a, b)| (a - b).abs()).sum();
        Self {
            displacement: ratio(
                norm(&mut apart.iter().copied()),
                norm(&mut truth.displacement.iter().map(|u| u.length())),
            ),
            stress: ratio(norm(&mut stress.iter().copied()), norm(&mut truth.stress.iter().copied())),
            force: ratio(length(&force), length(&truth.force)),
            travel: ratio(travel, truth.travel.iter().map(|t| t.abs()).sum()),
            displacement_max_m: largest(&apart),
            stress_max_pa: largest(&stress),
        }
    }
}

fn ratio(error: f64, whole: f64) -> f64 {
    if whole > 0.0 { error / whole } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_fields_have_no_error_and_doubled_ones_an_error_of_one() {
        let points = Points { position: vec![DVec3::ZERO; 2], volume: vec![1.0, 3.0] };
        let truth = Fields {
            displacement: vec![DVec3::X, DVec3::Y],
            stress: vec![1.0, 2.0],
            force: vec![DVec3::Z],
            travel: vec![0.5],
        };
        let none = FrameDistance::of(&points, &truth, &truth);
        assert_eq!([none.displacement, none.stress, none.force, none.travel, none.displacement_max_m], [0.0; 5]);
        let mut twice = truth.clone();
        twice.displacement.iter_mut().for_each(|u| *u *= 2.0);
        twice.stress.iter_mut().for_each(|s| *s *= 2.0);
        let error = FrameDistance::of(&points, &twice, &truth);
        assert!((error.displacement - 1.0).abs() < 1e-12 && (error.stress - 1.0).abs() < 1e-12);
        assert_eq!((error.displacement_max_m, error.stress_max_pa), (1.0, 2.0));
    }
}
