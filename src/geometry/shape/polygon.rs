//! Exact signed distance in the half-plane (rho, z) of a solid of revolution.

use crate::error::Result;
use crate::geometry::shape::params::require;
use glam::{DVec2, DVec3};

/// Largest number of points of a profile.
pub const MAX_POINTS: usize = 2048;
const CHUNK: usize = 8;

/// Outline of a meridian section: points (rho, z), m, counter-clockwise (inside on the left).
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    points: Vec<DVec2>,
    closed: bool,
    /// Outward unit normal of segment `i`, from point `i` to the next.
    normals: Vec<DVec2>,
    /// Boxes of `CHUNK` segments each.
    boxes: Vec<(DVec2, DVec2)>,
}

/// Closest point of a profile.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ProfilePoint {
    pub distance: f64,
    pub normal: DVec2,
    /// True if the point lies on a segment rather than on a corner.
    pub smooth: bool,
}

impl Profile {
    /// Builds a profile: either a loop off the axis (`closed`, first point not repeated), or a line from the axis to the
    /// axis.
    ///
    /// # Errors
    /// Fails if the number of points is out of range, a point is out of range or repeated, an end is not on the axis, the
    /// profile crosses itself or encloses no area.
    pub fn new(shape: &str, mut points: Vec<DVec2>, closed: bool) -> Result<Self> {
        let n = points.len();
        let most = 1e3;
        require(shape, (3..=MAX_POINTS).contains(&n), || {
            format!("the profile has {n} points; it must have 3 to {MAX_POINTS}")
        })?;
        for (i, p) in points.iter().enumerate() {
            let fits = p.is_finite() && p.abs().max_element() <= most;
            require(shape, fits, || format!("profile point {i} is {p}; it must be finite and within {most} m"))?;
            let end = !closed && (i == 0 || i == n - 1);
            require(shape, if end { p.x == 0.0 } else { p.x > 0.0 }, || {
                let wanted = if end { "rho = 0: a profile that is not a loop ends on the axis" } else { "rho > 0" };
                format!("profile point {i} is (rho, z) = ({}, {}) m; it must have {wanted}", p.x, p.y)
            })?;
        }
        if area(&points) < 0.0 {
            points.reverse();
        }
        let count = if closed { n } else { n - 1 };
        let size = points.iter().fold(0.0, |m: f64, p| m.max((*p - points[0]).length()));
        for i in 0..count {
            let short = points[i].distance(points[(i + 1) % n]) < 1e-9 * size;
            require(shape, !short, || format!("profile point near ({}, {}) m is repeated", points[i].x, points[i].y))?;
        }
        for i in 0..count {
            for j in i + 2..count {
                if closed && i == 0 && j == n - 1 {
                    continue;
                }
                let cross = crossing(points[i], points[i + 1], points[j], points[(j + 1) % n]);
                require(shape, !cross, || {
                    format!("the profile crosses itself near ({}, {}) m", points[i].x, points[i].y)
                })?;
            }
        }
        require(shape, area(&points) > 1e-12 * size * size, || {
            "the profile encloses no area, so the solid encloses no volume; give it a thickness".into()
        })?;
        let ends = |i: usize| (points[i], points[(i + 1) % n]);
        let normals = (0..count).map(|i| -(ends(i).1 - ends(i).0).normalize().perp()).collect();
        let boxes = (0..count)
            .step_by(CHUNK)
            .map(|c| {
                let all = (c..count.min(c + CHUNK)).flat_map(|i| [ends(i).0, ends(i).1]);
                all.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |b, p| (b.0.min(p), b.1.max(p)))
            })
            .collect();
        Ok(Self { points, closed, normals, boxes })
    }

    /// Returns the points (rho, z), m, counter-clockwise.
    pub fn points(&self) -> &[DVec2] {
        &self.points
    }

    /// Returns true if the last point joins the first.
    pub fn closed(&self) -> bool {
        self.closed
    }

    /// Returns the number of segments.
    pub fn segments(&self) -> usize {
        self.normals.len()
    }

    /// Returns the ends of segment `i`, m.
    pub fn segment(&self, i: usize) -> (DVec2, DVec2) {
        (self.points[i], self.points[(i + 1) % self.points.len()])
    }

    /// Returns the unit normals of the segments before and after point `i`; on the axis, those of a segment and its
    /// mirror image.
    pub(crate) fn around(&self, i: usize) -> (DVec2, DVec2) {
        let n = self.points.len();
        let mirror = |m: DVec2| DVec2::new(-m.x, m.y);
        if self.closed {
            (self.normals[(i + n - 1) % n], self.normals[i])
        } else if i == 0 {
            (mirror(self.normals[0]), self.normals[0])
        } else if i == n - 1 {
            (self.normals[n - 2], mirror(self.normals[n - 2]))
        } else {
            (self.normals[i - 1], self.normals[i])
        }
    }

    /// Returns the closest point to `q` with squared distance below `limit`.
    pub(crate) fn nearest(&self, q: DVec2, limit: f64) -> Option<ProfilePoint> {
        let (mut best, mut at, mut along) = (limit, usize::MAX, 0.0);
        let apart = |c: usize| {
            let b = self.boxes[c];
            (b.0 - q).max(q - b.1).max(DVec2::ZERO).length_squared()
        };
        // The nearest box first: it leaves little to the others.
        let count = self.boxes.len();
        let first = (0..count).map(|c| (c, apart(c))).min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(c, _)| c);
        for c in (first..count).chain(0..first) {
            if apart(c) >= best {
                continue;
            }
            for i in c * CHUNK..self.segments().min((c + 1) * CHUNK) {
                let (a, e) = (self.points[i], self.segment(i).1 - self.points[i]);
                let t = ((q - a).dot(e) / e.length_squared()).clamp(0.0, 1.0);
                let d = (q - a - t * e).length_squared();
                if d < best {
                    (best, at, along) = (d, i, t);
                }
            }
        }
        if at == usize::MAX {
            return None;
        }
        if along > 0.0 && along < 1.0 {
            let normal = self.normals[at];
            return Some(ProfilePoint { distance: normal.dot(q - self.points[at]), normal, smooth: true });
        }
        let corner = if along == 0.0 { at } else { (at + 1) % self.points.len() };
        let (before, after) = self.around(corner);
        let pseudo = (before + after).try_normalize().unwrap_or(after);
        let away = q - self.points[corner];
        let length = away.length();
        let distance = if away.dot(pseudo) < 0.0 { -length } else { length };
        let normal = if length < 1e-12 { pseudo } else { away / distance };
        Some(ProfilePoint { distance, normal, smooth: false })
    }

    /// Returns the smallest and largest (rho, z), m.
    pub fn bounds(&self) -> (DVec2, DVec2) {
        self.points.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |b, &p| (b.0.min(p), b.1.max(p)))
    }

    /// Returns a point of the solid of revolution farthest along `direction`.
    pub(crate) fn support(&self, direction: DVec3) -> Option<DVec3> {
        let across = direction.x.hypot(direction.y);
        let d = DVec2::new(across, direction.z);
        let p = self.points.iter().copied().max_by(|a, b| a.dot(d).total_cmp(&b.dot(d)))?;
        let radial = DVec3::new(direction.x, direction.y, 0.0).normalize_or(DVec3::X);
        Some(p.x * radial + p.y * DVec3::Z)
    }
}

/// Returns twice the signed area of the polygon.
fn area(points: &[DVec2]) -> f64 {
    (0..points.len()).map(|i| points[i].perp_dot(points[(i + 1) % points.len()])).sum()
}

/// Returns true if the segments ab and cd share a point.
fn crossing(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> bool {
    let side = |p: DVec2, q: DVec2, r: DVec2| (q - p).perp_dot(r - p);
    let (s1, s2, s3, s4) = (side(a, b, c), side(a, b, d), side(c, d, a), side(c, d, b));
    let overlap = a.min(b).cmple(c.max(d)).all() && c.min(d).cmple(a.max(b)).all();
    overlap && s1 * s2 <= 0.0 && s3 * s4 <= 0.0
}
