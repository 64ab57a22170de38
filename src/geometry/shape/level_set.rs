//! Smooth surface: the zero level of a tricubic B-spline over a grid, with closest points, normals and curvature in
//! constant time.
//!
//! The coefficients are samples of a signed distance at the nodes of the grid. The spline therefore does not
//! interpolate the distance but averages it over about a cell on every side (the B-spline of degree three is a
//! convolution kernel: Unser 1999, "Splines: a perfect fit for signal and image processing", eq. 4): planes are
//! reproduced, and edges are rounded with a radius of about the grid spacing. The spline is C2, so the curvature of the
//! surface is continuous. Samples are stored only in blocks near the surface.

use crate::Aabb;
use crate::shape::{SignedDistance, SurfacePoint, outer};
use glam::{DMat3, DVec3, IVec3};
use rayon::prelude::*;
use std::sync::Arc;

/// Nodes along an edge of a block.
const BLOCK: i32 = 4;
/// Distance from the surface, over the spacing, up to which the spline is evaluated; beyond it the sampled distance is
/// used.
const BAND: f64 = 1.0;
/// Half-width of the support of the B-spline along an axis, in cells.
const SUPPORT: f64 = 2.0;
/// Lower bound of the distance of a point beyond the band, over the width of the band, which is measured to first
/// order.
const MIN_OUTSIDE: f64 = 0.5;
/// Smallest gradient norm of the spline at which a closest point is computed; the norm is 1 where the spline is a
/// distance.
const MIN_GRADIENT: f64 = 0.3;
/// Step of the closest-point iteration, over the spacing, at which it has converged: the next one would be of the size
/// of rounding errors.
const STEP_TOLERANCE: f64 = 1e-8;
/// Maximum number of iterations for a closest point.
const STEPS: usize = 12;

/// Tricubic B-spline over a grid whose zero level is a surface.
#[derive(Debug)]
pub struct LevelSet {
    /// Sampled distance.
    base: Arc<dyn SignedDistance>,
    /// Axes of the grid, as columns.
    axes: DMat3,
    /// Origin of the grid frame, which is a node, m.
    center: DVec3,
    /// Coordinates of the first node in the grid frame, m.
    origin: DVec3,
    /// Spacing of the nodes, m.
    spacing: f64,
    /// Number of blocks along the axes.
    blocks: IVec3,
    /// Index of the first coefficient of each block, divided by `BLOCK^3`; [`NO_BLOCK`] far from the surface.
    index: Vec<u32>,
    coefficients: Vec<f64>,
    /// Value of the spline on the surface, m.
    level: f64,
    /// Largest measured distance between the surface and the surface of `base`, m.
    deviation: f64,
}

/// Index of a block that has no coefficients.
const NO_BLOCK: u32 = u32::MAX;

/// Value above the level of the surface, gradient and Hessian of the spline at a point.
struct Jet {
    value: f64,
    gradient: DVec3,
    hessian: DMat3,
}

impl LevelSet {
    /// Samples `base` on nodes `spacing` (m) apart along the `axes`, one of them at `center`, m. The points `surface`
    /// (m) span its surface.
    pub fn new(base: Arc<dyn SignedDistance>, surface: &[DVec3], (center, axes): (DVec3, DMat3), spacing: f64) -> Self {
        let reach = (BAND + 3.0_f64.sqrt() * SUPPORT) * spacing;
        let bounds = Aabb::from_points(surface.iter().map(|p| axes.transpose() * (*p - center)));
        let origin = ((bounds.min - reach) / spacing).floor() * spacing;
        let blocks = ((bounds.max + reach - origin) / (f64::from(BLOCK) * spacing)).ceil().as_ivec3().max(IVec3::ONE);
        let half = 0.5 * f64::from(BLOCK - 1) * spacing;
        let near = reach + 3.0_f64.sqrt() * half;
        let block = |b: i32| IVec3::new(b % blocks.x, b / blocks.x % blocks.y, b / (blocks.x * blocks.y));
        let first = |b: IVec3| origin + (BLOCK * b).as_dvec3() * spacing;
        let all = (0..blocks.element_product()).into_par_iter();
        let close: Vec<i32> =
            all.filter(|b| base.distance(center + axes * (first(block(*b)) + half)).abs() <= near).collect();
        let nodes = |b: i32| {
            let at = first(block(b));
            let node = move |i: i32| IVec3::new(i % BLOCK, i / BLOCK % BLOCK, i / (BLOCK * BLOCK)).as_dvec3();
            (0..BLOCK.pow(3)).map(move |i| center + axes * (at + node(i) * spacing))
        };
        let coefficients = close.par_iter().flat_map_iter(|b| nodes(*b)).map(|node| base.distance(node)).collect();
        let mut index = vec![NO_BLOCK; blocks.element_product() as usize];
        close.iter().zip(0..).for_each(|(b, i)| index[*b as usize] = i);
        Self { base, axes, center, origin, spacing, blocks, index, coefficients, level: 0.0, deviation: 0.0 }
    }

    /// Shifts the level such that the surface passes through the `samples` (m, with weights) on average, and measures
    /// their distances from it. Returns the largest distance and the root mean square, m.
    pub fn fit(&mut self, samples: &[(DVec3, f64)]) -> [f64; 2] {
        let mean = |values: &mut dyn Iterator<Item = f64>| {
            let sums =
                samples.iter().zip(values).fold([0.0; 2], |[s, w], ((_, weight), v)| [s + weight * v, w + weight]);
            sums[0] / sums[1].max(f64::MIN_POSITIVE)
        };
        self.level = mean(&mut samples.iter().map(|(p, _)| self.jet(*p).map_or(0.0, |jet| jet.value)));
        // A sample without a closest point is farther from the surface than the grid resolves.
        let off = |p: DVec3| self.project(p).map_or(2.0 * self.spacing, |(_, c)| c.distance.abs());
        let off: Vec<f64> = samples.par_iter().map(|(p, _)| off(*p)).collect();
        self.deviation = off.iter().copied().fold(0.0, f64::max);
        [self.deviation, mean(&mut off.iter().map(|off| off * off)).sqrt()]
    }

    /// Spacing of the nodes, m: about the radius with which edges are rounded.
    pub fn spacing(&self) -> f64 {
        self.spacing
    }

    /// Surface point closest to `q`, which must be near the surface, and its data; None if the search fails.
    pub fn project(&self, q: DVec3) -> Option<(DVec3, SurfacePoint)> {
        self.project_from(q, self.jet(q)?)
    }

    /// As [`LevelSet::project`], given the spline's values at `q`.
    fn project_from(&self, q: DVec3, mut jet: Jet) -> Option<(DVec3, SurfacePoint)> {
        let slope = jet.gradient.length_squared();
        if slope < MIN_GRADIENT * MIN_GRADIENT || jet.value.abs() > 2.0 * BAND * self.spacing {
            return None;
        }
        // Newton's method for the minimum of |c - q|^2 / 2 subject to level(c) = 0, with the Lagrange multiplier
        // lambda.
        let (mut c, mut lambda) = (q, jet.value / slope);
        for _ in 0..STEPS {
            let (g, residual) = (jet.gradient, c - q + lambda * jet.gradient);
            let inverse = (DMat3::IDENTITY + jet.hessian * lambda).inverse();
            let (along, back) = (inverse * g, inverse * residual);
            let change = (jet.value - g.dot(back)) / g.dot(along);
            let step = -(back + change * along);
            if !step.is_finite() || step.length() > 2.0 * BAND * self.spacing {
                return None;
            }
            (c, lambda) = (c + step, lambda + change);
            jet = self.jet(c)?;
            if step.length() <= STEP_TOLERANCE * self.spacing {
                break;
            }
        }
        let size = jet.gradient.length();
        let normal = jet.gradient / size;
        let distance = (q - c).dot(normal);
        // The tangential part of q - c is the remaining error.
        if size < MIN_GRADIENT || (q - c - distance * normal).length() > 1e-6 * self.spacing {
            return None;
        }
        let tangent = DMat3::IDENTITY - outer(normal);
        let shape = tangent * jet.hessian * tangent * size.recip();
        // A parallel surface has the same lines of curvature; its radii of curvature are larger by the distance.
        let curvature = (DMat3::IDENTITY + shape * distance).inverse() * shape;
        Some((c, SurfacePoint { distance, normal, curvature }))
    }

    /// Closest point data of `q` if it lies in the band around the surface; of first order where the search fails, as
    /// on a medial axis.
    fn closest_in_band(&self, q: DVec3) -> Option<SurfacePoint> {
        let jet = self.jet(q)?;
        let size = jet.gradient.length();
        let distance = jet.value / size;
        // The negated comparison also excludes NaN.
        if !(distance.abs() <= BAND * self.spacing) {
            return None;
        }
        let first_order = SurfacePoint { distance, normal: jet.gradient / size, curvature: DMat3::ZERO };
        Some(self.project_from(q, jet).map_or(first_order, |(_, closest)| closest))
    }

    /// Value at `q` over the gradient norm, m: the distance to first order; None far from the surface.
    pub fn height(&self, q: DVec3) -> Option<f64> {
        self.jet(q).map(|jet| jet.value / jet.gradient.length())
    }

    /// Value above the level, gradient and Hessian of the spline at `q`; None far from the surface.
    #[inline]
    fn jet(&self, q: DVec3) -> Option<Jet> {
        let at = (self.axes.transpose() * (q - self.center) - self.origin) / self.spacing;
        let cell = at.floor();
        if !(cell.min_element() >= 1.0 && cell.cmplt((BLOCK * self.blocks - 2).as_dvec3()).all()) {
            return None;
        }
        let (first, t) = (cell.as_ivec3() - 1, at - cell);
        let [x, y, z] = t.to_array().map(weights);
        let mut sums = [0.0; 10];
        for (k, [z0, z1, z2]) in z.into_iter().enumerate() {
            for (j, [y0, y1, y2]) in y.into_iter().enumerate() {
                let (mut s0, mut s1, mut s2) = (0.0, 0.0, 0.0);
                for (i, [x0, x1, x2]) in x.into_iter().enumerate() {
                    let c = self.coefficient(first + IVec3::new(i as i32, j as i32, k as i32))?;
                    (s0, s1, s2) = (s0 + x0 * c, s1 + x1 * c, s2 + x2 * c);
                }
                let row = [
                    s0 * y0 * z0,
                    s1 * y0 * z0,
                    s0 * y1 * z0,
                    s0 * y0 * z1,
                    s2 * y0 * z0,
                    s0 * y2 * z0,
                    s0 * y0 * z2,
                    s1 * y1 * z0,
                    s0 * y1 * z1,
                    s1 * y0 * z1,
                ];
                sums.iter_mut().zip(row).for_each(|(s, r)| *s += r);
            }
        }
        let [value, x, y, z, xx, yy, zz, xy, yz, zx] = sums;
        let h = self.spacing.recip();
        let columns = [DVec3::new(xx, xy, zx), DVec3::new(xy, yy, yz), DVec3::new(zx, yz, zz)].map(|c| c * (h * h));
        let hessian = self.axes * DMat3::from_cols(columns[0], columns[1], columns[2]) * self.axes.transpose();
        Some(Jet { value: value - self.level, gradient: self.axes * DVec3::new(x, y, z) * h, hessian })
    }

    /// Coefficient of a node; None far from the surface.
    #[inline(always)]
    fn coefficient(&self, node: IVec3) -> Option<f64> {
        let (block, inner) = (node / BLOCK, node % BLOCK);
        let b = block.x + self.blocks.x * (block.y + self.blocks.y * block.z);
        let index = *self.index.get(b as usize)?;
        let i = inner.x + BLOCK * (inner.y + BLOCK * inner.z);
        self.coefficients.get(index as usize * BLOCK.pow(3) as usize + i as usize).copied()
    }
}

/// Cubic B-spline weights of the four nodes around a point at the fraction `t` of the cell after the second node, with
/// their first and second derivatives.
#[inline(always)]
fn weights(t: f64) -> [[f64; 3]; 4] {
    let s = 1.0 - t;
    [
        [s * s * s / 6.0, -0.5 * s * s, s],
        [(3.0 * t - 6.0) * t * t / 6.0 + 2.0 / 3.0, (1.5 * t - 2.0) * t, 3.0 * t - 2.0],
        [(3.0 * s - 6.0) * s * s / 6.0 + 2.0 / 3.0, (2.0 - 1.5 * s) * s, 3.0 * s - 2.0],
        [t * t * t / 6.0, 0.5 * t * t, t],
    ]
}

impl SignedDistance for LevelSet {
    fn distance(&self, q: DVec3) -> f64 {
        self.closest(q, f64::INFINITY).map_or(f64::NAN, |c| c.distance)
    }

    fn closest(&self, q: DVec3, max: f64) -> Option<SurfacePoint> {
        if let Some(closest) = self.closest_in_band(q) {
            return (closest.distance < max).then_some(closest);
        }
        let base = self.base.closest(q, max + self.deviation)?;
        // A lower bound of the distance: the surface may be nearer than that of `base` by the deviation, but not within
        // the band.
        let size = (base.distance.abs() - self.deviation).max(MIN_OUTSIDE * BAND * self.spacing);
        let distance = size.copysign(self.height(q).unwrap_or(base.distance));
        (distance < max).then_some(SurfacePoint { distance, ..base })
    }

    fn support(&self, direction: DVec3) -> Option<DVec3> {
        let far = self.base.support(direction)?;
        Some(self.project(far).map_or(far, |(c, _)| c))
    }
}
