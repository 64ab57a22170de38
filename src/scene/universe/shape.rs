//! Shapes drawn at random.

use super::draws::{Draws, round_for_text};
use crate::defaults;
use crate::leaf::{Count, Depth, Finite, Length, NonNegative, Positive};
use crate::object::*;
use crate::vector::{Tuple, Vec2};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Family of shapes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Family {
    /// Spheres.
    Sphere,
    /// Boxes with sharp edges.
    Cuboid,
    /// Boxes with rounded edges.
    RoundedCuboid,
    /// Ellipsoids.
    Ellipsoid,
    /// Cylinders.
    Cylinder,
    /// Capsules.
    Capsule,
    /// Prisms with three to eight sides.
    Prism,
    /// Hollow cylinders.
    Annulus,
    /// Cups.
    Cup,
    /// Lemons.
    Lemon,
    /// Strawberries.
    Strawberry,
    /// Pears.
    Pear,
    /// Bananas.
    Banana,
    /// Potatoes.
    Potato,
    /// Potatoes with large flat facets.
    Faceted,
    /// Solids of revolution with a wavy profile, some cut off flat, or with sharp rims.
    Revolve,
}

/// Smallest and largest ratio of two extents of a shape.
const ASPECT: [f64; 2] = [1.0, 2.5];
/// Smallest number of segments of a faceted shape, and the smallest that no longer occurs.
const FACETS: [u64; 2] = [8, 17];
/// Fraction of the smooth solids of revolution that are cut off flat, and the fractions of the height that remain.
const CUT: f64 = 0.4;
const REMAINS: [f64; 2] = [0.35, 0.8];
/// Number of points of a profile between its ends.
const PROFILE: usize = 12;

fn length(value: f64) -> Length {
    Length::new_unchecked(round_for_text(value))
}

impl Family {
    /// All families.
    pub const ALL: [Family; 16] = [
        Family::Sphere,
        Family::Cuboid,
        Family::RoundedCuboid,
        Family::Ellipsoid,
        Family::Cylinder,
        Family::Capsule,
        Family::Prism,
        Family::Annulus,
        Family::Cup,
        Family::Lemon,
        Family::Strawberry,
        Family::Pear,
        Family::Banana,
        Family::Potato,
        Family::Faceted,
        Family::Revolve,
    ];

    /// Returns the prefix of the names of its objects.
    pub fn name(self) -> &'static str {
        match self {
            Family::Sphere => "sphere",
            Family::Cuboid => "cuboid",
            Family::RoundedCuboid => "rounded",
            Family::Ellipsoid => "ellipsoid",
            Family::Cylinder => "cylinder",
            Family::Capsule => "capsule",
            Family::Prism => "prism",
            Family::Annulus => "annulus",
            Family::Cup => "cup",
            Family::Lemon => "lemon",
            Family::Strawberry => "strawberry",
            Family::Pear => "pear",
            Family::Banana => "banana",
            Family::Potato => "potato",
            Family::Faceted => "faceted",
            Family::Revolve => "revolve",
        }
    }

    /// Returns true if its shapes can be grasped perpendicular to faces or axes.
    pub(super) fn has_faces(self) -> bool {
        use Family::*;
        matches!(self, Sphere | Cuboid | RoundedCuboid | Cylinder | Capsule | Prism | Annulus | Cup)
    }

    /// Draws the number of segments of its surface meshes: the facets of a faceted shape, and the default otherwise.
    pub(super) fn segments(self, draws: &mut Draws) -> Count<8, 512> {
        match self {
            Family::Faceted => {
                Count::new_unchecked(FACETS[0] + draws.0.uniform_below((FACETS[1] - FACETS[0]) as usize) as u64)
            }
            _ => defaults::SEGMENTS,
        }
    }

    /// Draws a shape of about the given `width` (m); returns it with its volume, m3, which for smooth shapes is
    /// accurate to some per cent.
    pub(super) fn draw(self, width: f64, draws: &mut Draws) -> (ObjectShape, f64) {
        let mut aspect = || draws.between(ASPECT[0], ASPECT[1]);
        let (a, b, c) = (width, width * aspect(), width * aspect());
        let (radius, tall) = (0.5 * width, c);
        let part = |draws: &mut Draws, low: f64, high: f64| draws.between(low, high);
        match self {
            Family::Sphere => (ObjectShape::Sphere(Sphere { radius: length(radius) }), 4.0 / 3.0 * PI * radius.powi(3)),
            Family::Cuboid | Family::RoundedCuboid => {
                let rounded = self == Family::RoundedCuboid;
                let edge = if rounded { part(draws, 0.04, 0.4) * width } else { 0.0 };
                let edge_radius = Depth::new_unchecked(if rounded { round_for_text(edge) } else { 0.0 });
                let size = Tuple([length(a), length(b), length(c)]);
                (ObjectShape::Cuboid(Cuboid { size, edge_radius }), a * b * c)
            }
            Family::Ellipsoid => {
                let radii = Tuple([a, b, c].map(|extent| length(0.5 * extent)));
                (ObjectShape::Ellipsoid(Ellipsoid { radii }), PI / 6.0 * a * b * c)
            }
            Family::Cylinder => {
                let height = width * part(draws, 0.6, 3.0);
                let shape = Cylinder { radius: length(radius), height: length(height) };
                (ObjectShape::Cylinder(shape), PI * radius * radius * height)
            }
            Family::Capsule => {
                let height = width * part(draws, 0.3, 2.5);
                let shape = Capsule { radius: length(radius), height: length(height) };
                (ObjectShape::Capsule(shape), PI * radius * radius * (height + 4.0 / 3.0 * radius))
            }
            Family::Prism => {
                let (sides, height) = (3 + draws.0.uniform_below(6), width * part(draws, 0.6, 3.0));
                let turn = 2.0 * PI / sides as f64;
                let volume = 0.5 * sides as f64 * radius * radius * turn.sin() * height;
                let shape =
                    Prism { sides: Count::new_unchecked(sides as u64), radius: length(radius), height: length(height) };
                (ObjectShape::Prism(shape), volume)
            }
            Family::Annulus => {
                let (inner, height) = (radius * part(draws, 0.3, 0.85), width * part(draws, 0.5, 2.0));
                let shape = Annulus { outer: length(radius), inner: length(inner), height: length(height) };
                (ObjectShape::Annulus(shape), PI * (radius * radius - inner * inner) * height)
            }
            Family::Cup => {
                let (height, wall) = (width * part(draws, 0.7, 1.6), radius * part(draws, 0.08, 0.25));
                let hollow = PI * (radius - wall).powi(2) * (height - wall);
                let shape = Cup { radius: length(radius), height: length(height), wall: length(wall) };
                (ObjectShape::Cup(shape), PI * radius * radius * height - hollow)
            }
            Family::Lemon => {
                let long = width * part(draws, 1.2, 1.7);
                let shape = Lemon { length: length(long), diameter: length(width) };
                (ObjectShape::Lemon(shape), 0.48 * long * width * width)
            }
            Family::Strawberry => {
                let long = width * part(draws, 1.0, 1.5);
                let shape = Strawberry { length: length(long), diameter: length(width) };
                (ObjectShape::Strawberry(shape), 0.4 * long * width * width)
            }
            Family::Pear => {
                let long = width * part(draws, 1.3, 1.8);
                let shape = Pear { length: length(long), diameter: length(width) };
                (ObjectShape::Pear(shape), 0.38 * long * width * width)
            }
            Family::Banana => {
                let long = width * part(draws, 3.0, 5.0);
                let bend_deg = Positive::new_unchecked(round_for_text(part(draws, 20.0, 100.0)));
                let shape = Banana { length: length(long), diameter: length(width), bend_deg };
                (ObjectShape::Banana(shape), 0.6 * long * width * width)
            }
            Family::Potato | Family::Faceted => {
                let radii = Tuple([a, b, c].map(|extent| length(0.5 * extent)));
                let roughness = NonNegative::new_unchecked(round_for_text(part(draws, 0.02, 0.1)));
                let seed = draws.0.next_u64() % 1_000_000;
                (ObjectShape::Potato(Potato { radii, roughness, seed }), PI / 6.0 * a * b * c)
            }
            Family::Revolve => {
                let points = profile(radius, tall, draws);
                let frustum = |w: &[[f64; 2]]| {
                    let ([r, low], [s, high]) = (w[0], w[1]);
                    PI / 3.0 * (high - low) * (r * r + r * s + s * s)
                };
                let volume = points.windows(2).map(frustum).sum();
                let point = |p: &[f64; 2]| -> Vec2 { Tuple(p.map(Finite::new_unchecked)) };
                (ObjectShape::Revolve(Revolve { profile: points.iter().map(point).collect(), closed: false }), volume)
            }
        }
    }
}

/// Draws the profile of a solid of revolution with largest radius `radius` and this height (m): an ellipse modulated by
/// up to three waves, whole or cut off flat, or a polygon with sharp rims.
fn profile(radius: f64, height: f64, draws: &mut Draws) -> Vec<[f64; 2]> {
    let smooth = draws.is_in(0.6);
    let waves: Vec<[f64; 2]> = (1..=3).map(|_| [draws.between(-0.25, 0.25), draws.between(0.0, 2.0 * PI)]).collect();
    let remains = (smooth && draws.is_in(CUT)).then(|| draws.between(REMAINS[0], REMAINS[1]));
    let steps = if smooth { PROFILE } else { 2 + draws.0.uniform_below(3) };
    let at = |k: usize| {
        // Fraction of the height of this point, and of the whole ellipse below it.
        let [at, part] = match remains {
            Some(remains) => [1.0, remains].map(|whole| whole * (k as f64 + 0.5) / (steps as f64 - 0.5)),
            None if smooth => [(k as f64 + 0.5) / steps as f64; 2],
            None => [k as f64 / (steps - 1) as f64; 2],
        };
        let round = if smooth { (1.0 - (2.0 * part - 1.0).powi(2)).max(0.0).sqrt() } else { 1.0 };
        let wave: f64 =
            waves.iter().zip(1..).map(|([size, phase], k)| size * (PI * f64::from(k) * part + phase).sin()).sum();
        [round * (1.0 + wave).max(0.3), height * (at - 0.5)]
    };
    let inner: Vec<[f64; 2]> = (0..steps).map(at).collect();
    let most = inner.iter().map(|[r, _]| *r).fold(0.0, f64::max);
    let inner = inner.into_iter().map(|[r, z]| [round_for_text(radius * r / most), round_for_text(z)]);
    let ends = [[0.0, round_for_text(-0.5 * height)], [0.0, round_for_text(0.5 * height)]];
    std::iter::once(ends[0]).chain(inner).chain([ends[1]]).collect()
}
