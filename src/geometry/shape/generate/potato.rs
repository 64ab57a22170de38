//! Potatoes.

use crate::shape::Shape;
use crate::shape::generate::icosphere;
use crate::shape::params::{check_length, check_segments as turn, require};
use base::error::Result;
use base::random::Random;
use glam::DVec3;

/// Number of bumps that are added.
const WAVES: usize = 12;

/// Builds a potato: an ellipsoid of the given semi-axes, m, with smooth bumps of about `roughness` (0 to 0.3) of its
/// local radius. The seed determines the bumps: equal seeds give equal potatoes.
///
/// # Errors
/// Fails if a parameter is out of range.
pub fn potato(semi: DVec3, roughness: f64, seed: u64, segments: u32) -> Result<Shape> {
    for (axis, value) in ["x", "y", "z"].into_iter().zip(semi.to_array()) {
        check_length("potato", &format!("semi-axis {axis}"), value)?;
    }
    require("potato", semi.max_element() <= 100.0 * semi.min_element(), || {
        format!("semi-axes {semi} m differ by more than a factor of 100")
    })?;
    require("potato", (0.0..=0.3).contains(&roughness), || {
        format!("roughness is {roughness}; it must be between 0 and 0.3")
    })?;
    let mut mesh = icosphere(turn("potato", segments)?);
    let mut numbers = Random::new(seed);
    let mut random = || 2.0 * numbers.uniform() - 1.0;
    let waves: Vec<(DVec3, f64)> = (0..WAVES)
        .map(|_| {
            // Plane waves with wave numbers of 1 to 4 per radius, evaluated on the sphere only.
            let direction = DVec3::new(random(), random(), random()).normalize_or(DVec3::X);
            (direction * (2.5 + 1.5 * random()), std::f64::consts::PI * random())
        })
        .collect();
    // The sum of independent waves of random phase has the variance WAVES / 2; the bound keeps every radius positive.
    let scale = roughness / (WAVES as f64 / 2.0).sqrt();
    for p in &mut mesh.vertices {
        let bump: f64 = waves.iter().map(|(k, phase)| (k.dot(*p) + phase).sin()).sum();
        *p *= semi * (1.0 + (scale * bump).clamp(-0.8, 0.8));
    }
    Ok(Shape::from_mesh(mesh)?.with_name("potato"))
}
