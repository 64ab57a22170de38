//! Exact signed distance in the half-plane (rho, z) of a solid of revolution.

use crate::shape::params::require;
use base::error::Result;
use glam::{DVec2, DVec3};
use pulp::{Arch, NullaryFnOnce};

/// Largest number of points of a profile.
pub const MAX_POINTS: usize = 2048;
/// Number of segments that are evaluated together (SIMD).
const CHUNK: usize = 8;

/// Outline of a meridian section: points (rho, z), m, counter-clockwise (inside on the left).
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    points: Vec<DVec2>,
    closed: bool,
    /// Outward unit normal of segment `i`, from point `i` to the next.
    normals: Vec<DVec2>,
    /// Segments in groups of [`CHUNK`].
    chunks: Vec<Chunk>,
    /// Bounding boxes of the chunks, in groups of [`CHUNK`].
    boxes: Vec<Boxes>,
}

/// Up to [`CHUNK`] consecutive segments as a structure of arrays; the last segment is repeated in unused entries.
#[derive(Debug, Clone, PartialEq)]
struct Chunk {
    /// Starts of the segments, and the vectors from there to their ends, m; by axis, then segment.
    start: [[f64; CHUNK]; 2],
    along: [[f64; CHUNK]; 2],
    /// Inverse of the squared length.
    inverse: [f64; CHUNK],
}

impl Chunk {
    /// Packs at most [`CHUNK`] segments, given by their ends.
    fn new(segments: &[(DVec2, DVec2)]) -> Self {
        let of = |value: fn(DVec2, DVec2) -> f64| {
            std::array::from_fn(|k| {
                let (start, end) = segments[k.min(segments.len() - 1)];
                value(start, end - start)
            })
        };
        Self {
            start: [of(|start, _| start.x), of(|start, _| start.y)],
            along: [of(|_, along| along.x), of(|_, along| along.y)],
            inverse: of(|_, along| along.length_squared().recip()),
        }
    }

    /// Squared distance of `q` from each segment, and the parameter in 0..=1 of the closest point.
    #[inline(always)]
    fn distances(&self, q: DVec2) -> ([f64; CHUNK], [f64; CHUNK]) {
        let ([ax, ay], [ex, ey]) = (&self.start, &self.along);
        let (mut distance, mut part) = ([0.0; CHUNK], [0.0; CHUNK]);
        for k in 0..CHUNK {
            let (x, y) = (q.x - ax[k], q.y - ay[k]);
            let t = ((x * ex[k] + y * ey[k]) * self.inverse[k]).clamp(0.0, 1.0);
            let (x, y) = (x - t * ex[k], y - t * ey[k]);
            (distance[k], part[k]) = (x * x + y * y, t);
        }
        (distance, part)
    }
}

/// Closest point of a profile.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ProfilePoint {
    pub distance: f64,
    pub normal: DVec2,
    /// True if the point lies on a segment rather than on a corner.
    pub smooth: bool,
}

/// Bounding boxes of up to [`CHUNK`] chunks as a structure of arrays; unused entries are empty boxes, at an infinite
/// distance.
#[derive(Debug, Clone, PartialEq)]
struct Boxes {
    low: [[f64; CHUNK]; 2],
    high: [[f64; CHUNK]; 2],
}

impl Boxes {
    /// Creates the bounding boxes of at most [`CHUNK`] chunks of `segments`.
    fn new(segments: &[(DVec2, DVec2)]) -> Self {
        let mut boxes = Self { low: [[f64::INFINITY; CHUNK]; 2], high: [[f64::NEG_INFINITY; CHUNK]; 2] };
        for (k, chunk) in segments.chunks(CHUNK).enumerate() {
            for end in chunk.iter().flat_map(|(a, b)| [a, b]) {
                for axis in 0..2 {
                    boxes.low[axis][k] = boxes.low[axis][k].min(end[axis]);
                    boxes.high[axis][k] = boxes.high[axis][k].max(end[axis]);
                }
            }
        }
        boxes
    }

    /// Squared distances of `q` from the boxes.
    #[inline(always)]
    fn distances(&self, q: DVec2) -> [f64; CHUNK] {
        let apart = |k: usize, axis: usize| (self.low[axis][k] - q[axis]).max(q[axis] - self.high[axis][k]).max(0.0);
        std::array::from_fn(|k| apart(k, 0) * apart(k, 0) + apart(k, 1) * apart(k, 1))
    }
}

impl Profile {
    /// Builds a profile: either a loop that does not touch the axis (`closed`, first point not repeated), or an open
    /// polyline that starts and ends on the axis.
    ///
    /// # Errors
    /// Fails if the number of points is out of range, a point is out of range or repeated, an end is not on the axis,
    /// the profile crosses itself or encloses no area.
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
        let segments: Vec<(DVec2, DVec2)> = (0..count).map(ends).collect();
        let chunks = segments.chunks(CHUNK).map(Chunk::new).collect();
        let boxes = segments.chunks(CHUNK * CHUNK).map(Boxes::new).collect();
        Ok(Self { points, closed, normals, chunks, boxes })
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
    pub(crate) fn adjacent_normals(&self, i: usize) -> (DVec2, DVec2) {
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

    /// Returns the closest point to `q` if its squared distance is below `limit`.
    pub(crate) fn nearest(&self, q: DVec2, limit: f64) -> Option<ProfilePoint> {
        let (at, along) = Arch::new().dispatch(NearestSegment { profile: self, q, limit });
        if at == usize::MAX {
            return None;
        }
        if along > 0.0 && along < 1.0 {
            let normal = self.normals[at];
            return Some(ProfilePoint { distance: normal.dot(q - self.points[at]), normal, smooth: true });
        }
        let corner = if along == 0.0 { at } else { (at + 1) % self.points.len() };
        let (before, after) = self.adjacent_normals(corner);
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

/// Search for the segment nearest to `q`: its index (`usize::MAX` if no squared distance is below `limit`), and the
/// parameter of the closest point. A callable struct, which `Arch::dispatch` runs with the vector instructions of the
/// processor.
struct NearestSegment<'a> {
    profile: &'a Profile,
    q: DVec2,
    limit: f64,
}

impl NullaryFnOnce for NearestSegment<'_> {
    type Output = (usize, f64);

    #[inline(always)]
    fn call(self) -> (usize, f64) {
        let Self { profile: Profile { chunks, boxes, normals, .. }, q, limit } = self;
        let mut apart = [f64::INFINITY; MAX_POINTS / CHUNK];
        for (apart, boxes) in apart.as_chunks_mut::<CHUNK>().0.iter_mut().zip(boxes) {
            *apart = boxes.distances(q);
        }
        let apart = &apart[..chunks.len()];
        // The chunk with the nearest box comes first, so that most others are skipped.
        let (mut first, mut least) = (0, f64::INFINITY);
        for (c, apart) in apart.iter().enumerate() {
            (first, least) = if *apart < least { (c, *apart) } else { (first, least) };
        }
        let (mut best, mut at, mut along) = (limit, usize::MAX, 0.0);
        for c in (first..chunks.len()).chain(0..first) {
            if apart[c] >= best {
                continue;
            }
            let (distance, part) = chunks[c].distances(q);
            for k in (0..CHUNK).filter(|k| c * CHUNK + k < normals.len()) {
                if distance[k] < best {
                    (best, at, along) = (distance[k], c * CHUNK + k, part[k]);
                }
            }
        }
        (at, along)
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
