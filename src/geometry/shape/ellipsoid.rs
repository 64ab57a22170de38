//! Signed distance to an ellipsoid.
//!
//! The closest point `x` satisfies `q - x = t x / e^2` for the largest root `t` of `sum (e_i q_i / (t + e_i^2))^2 = 1`
//! (Eberly 2013, "Distance from a point to an ellipse, an ellipsoid, or a hyperellipsoid", section 3). With the unknown
//! `s = t + min e^2` the root retains its relative precision near the medial disc. Newton's method on `1 / norm - 1`
//! (More and Sorensen 1983, eq. 3.10), which is almost linear, converges in a few steps and is safeguarded by
//! bisection.

use crate::shape::{Hit, SignedDistance, SurfacePoint, outer, trace_convex};
use glam::{DMat3, DVec3};

/// Ellipsoid about the origin, with its axes along x, y, z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ellipsoid {
    /// Semi-axes, m.
    pub semi: DVec3,
}

impl Ellipsoid {
    /// Returns the closest surface point, the signed distance and the unit outward normal.
    fn project(&self, q: DVec3) -> (DVec3, f64, DVec3) {
        // Unit of length: the shortest semi-axis.
        let unit = self.semi.min_element();
        let e = self.semi / unit;
        let y = q.abs() / unit;
        let square = e * e;
        let gap = square - DVec3::ONE;
        let z = e * y;
        let s = root(z, gap);
        let mut x = DVec3::ZERO;
        for i in 0..3 {
            let below = s + gap[i];
            x[i] = if below > 0.0 { (e[i] * z[i] / below).min(e[i]) } else { 0.0 };
        }
        if s == 0.0 {
            // On the medial disc the closest point is not unique: the remainder of the unit sum is assigned to a
            // shortest axis.
            let axis = e.min_position();
            let rest = (0..3).filter(|&i| i != axis).map(|i| (x[i] / e[i]).powi(2)).sum::<f64>();
            x[axis] = e[axis] * (1.0 - rest).max(0.0).sqrt();
        }
        let n = (x / square).normalize_or(DVec3::Z);
        let sign = DVec3::ONE.copysign(q);
        // The projection onto n removes the error of x in the tangent plane.
        (sign * x * unit, (y - x).dot(n) * unit, sign * n)
    }

    /// Returns a lower bound of the distance of an exterior point, m: the map `q -> q / e` has the Lipschitz constant
    /// `1 / min e`.
    #[inline]
    fn at_least(&self, q: DVec3) -> f64 {
        let outside = (q.abs() - self.semi).max_element();
        outside.max(self.semi.min_element() * ((q / self.semi).length() - 1.0))
    }
}

/// Computes the root `s >= 0` of `sum (z_i / (s + gap_i))^2 = 1`, or 0 if the sum is at most 1 for all `s` (then `z` is
/// zero where `gap` is).
fn root(z: DVec3, gap: DVec3) -> f64 {
    let norm = |s: f64| {
        let (mut sum, mut slope) = (0.0, 0.0);
        for i in 0..3 {
            // Terms 0 / 0 on the medial disc are omitted.
            if z[i] > 0.0 {
                let r = z[i] / (s + gap[i]);
                sum += r * r;
                slope -= r * r / (s + gap[i]);
            }
        }
        (sum.sqrt(), slope)
    };
    // Bracket: at `low` one term of the sum is at least 1; at s = |z| the sum is at most 1, because gaps are not
    // negative.
    let mut low = (z - gap).max_element().max(0.0);
    let mut high = z.length();
    if low == 0.0 && norm(0.0).0 <= 1.0 {
        return 0.0;
    }
    // Near the surface the root is close to t = 0, which is s = 1 in units of the shortest semi-axis.
    let mut s = if low < 1.0 && 1.0 < high { 1.0 } else { low };
    for _ in 0..200 {
        let (n, slope) = norm(s);
        if (n - 1.0).abs() <= 2.0 * f64::EPSILON {
            return s;
        }
        if n >= 1.0 {
            low = s;
        } else {
            high = s;
        }
        // d(1/n)/ds = -slope / n^3
        let next = s + (n - 1.0) * n * n / -slope;
        let next = if next > low && next < high { next } else { 0.5 * (low + high) };
        if (next - s).abs() <= 2.0 * f64::EPSILON * s || high - low <= 2.0 * f64::EPSILON * high {
            return next;
        }
        s = next;
    }
    s
}

impl SignedDistance for Ellipsoid {
    fn distance(&self, q: DVec3) -> f64 {
        self.project(q).1
    }

    fn closest(&self, q: DVec3, max: f64) -> Option<SurfacePoint> {
        if !(self.at_least(q) < max || max <= 0.0) {
            return None;
        }
        let (x, distance, normal) = self.project(q);
        if !(distance < max) {
            return None;
        }
        // Hessian on the surface: P diag(1/e^2) P / |x/e^2|; transported along the normal: S (I + d S)^-1.
        let square = self.semi * self.semi;
        let tangent = DMat3::IDENTITY - outer(normal);
        let shape = tangent * DMat3::from_diagonal(square.recip()) * tangent * (x / square).length_recip();
        let carry = DMat3::IDENTITY + shape * distance;
        // The distance is not differentiable on the medial surface.
        let curvature = if carry.determinant().abs() > 1e-9 { shape * carry.inverse() } else { DMat3::ZERO };
        Some(SurfacePoint { distance, normal, curvature })
    }

    fn ray(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        trace_convex(self, origin, direction)
    }

    fn support(&self, direction: DVec3) -> Option<DVec3> {
        Some(self.semi * (self.semi * direction).try_normalize()?)
    }
}
