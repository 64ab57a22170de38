//! Generated families of objects: one file each, every one a closed, outward-wound mesh, with a distance in closed form
//! where there is one.

mod annulus;
mod banana;
mod capsule;
mod cuboid;
mod cup;
mod cylinder;
mod ellipsoid;
mod icosphere;
mod lemon;
mod pear;
mod potato;
mod prism;
mod revolve;
mod sphere;
mod strawberry;
mod sweep;

pub use annulus::annulus;
pub use banana::banana;
pub use capsule::capsule;
pub use cuboid::cuboid;
pub use cup::cup;
pub use cylinder::cylinder;
pub use ellipsoid::ellipsoid;
pub use icosphere::icosphere;
pub use lemon::lemon;
pub use pear::pear;
pub use potato::potato;
pub use prism::prism;
pub use revolve::{revolve, revolved_mesh};
pub use sphere::sphere;
pub use strawberry::strawberry;
pub use sweep::{sweep, swept_mesh};

use glam::DVec2;

/// The profile of a fruit: `shape(s)` for s in 0..=1 along z, zero at both ends, is scaled to the given length and diameter.
/// Points crowd towards the ends, where the profile is steep.
fn fruit(length: f64, diameter: f64, segments: u32, shape: impl Fn(f64) -> f64) -> Vec<DVec2> {
    let largest = (0..=1000).map(|i| shape(f64::from(i) / 1000.0)).fold(f64::MIN_POSITIVE, f64::max);
    let n = segments / 2;
    let point = |i: u32| {
        let s = 0.5 - 0.5 * (std::f64::consts::PI * f64::from(i) / f64::from(n)).cos();
        let rho = if i == 0 || i == n { 0.0 } else { 0.5 * diameter * shape(s) / largest };
        DVec2::new(rho, length * (s - 0.5))
    };
    (0..=n).map(point).collect()
}
