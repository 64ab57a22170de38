//! Potatoes.

use crate::error::Result;
use crate::shape::Shape;
use crate::shape::generate::icosphere;
use crate::shape::params::{length, require, segments as turn};
use glam::DVec3;

/// Number of bumps that are added up.
const WAVES: usize = 12;

/// A potato: an ellipsoid of the given semi-axes, m, with smooth bumps of about `roughness` (0 to 0.3) of its local radius.
/// The seed decides the bumps: equal seeds give equal potatoes.
pub fn potato(semi: DVec3, roughness: f64, seed: u64, segments: u32) -> Result<Shape> {
    for (axis, value) in ["x", "y", "z"].into_iter().zip(semi.to_array()) {
        length("potato", &format!("semi-axis {axis}"), value)?;
    }
    require("potato", semi.max_element() <= 100.0 * semi.min_element(), || {
        format!("semi-axes {semi} m differ by more than a factor of 100")
    })?;
    require("potato", (0.0..=0.3).contains(&roughness), || {
        format!("roughness is {roughness}; it must be between 0 and 0.3")
    })?;
    let mut mesh = icosphere(turn("potato", segments)?);
    let mut state = seed;
    let mut random = || unit(&mut state);
    let waves: Vec<(DVec3, f64)> = (0..WAVES)
        .map(|_| {
            // Plane waves of a wave number of 1 to 4 per radius, seen on the sphere only.
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
    Ok(Shape::from_mesh(mesh)?.named("potato"))
}

/// A number in -1..1: SplitMix64 (Steele, Lea and Flood 2014), which needs no state but a counter.
fn unit(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^= z >> 31;
    (z >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}
