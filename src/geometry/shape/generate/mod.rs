//! Generated families of objects, one file each: a closed, outward-wound mesh, with a distance in closed form if there
//! is one.

mod annulus;
mod banana;
mod capsule;
mod cuboid;
mod cup;
mod cylinder;
mod ellipsoid;
mod fruit;
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
