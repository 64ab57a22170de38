//! Triangle in a local 2D frame, for fast and accurate closest-point queries.
//!
//! The longest edge lies on the x axis, which preserves the precision of slivers; a query costs one change of frame and
//! a few products. The point of a convex polygon closest to an exterior point lies on an edge whose outer half-plane
//! contains that point, so only these edges are evaluated.

use crate::Aabb;
use crate::mesh::adjacency::TrianglePart;
use crate::mesh::facets::FLAT_RATIO;
use glam::DVec3;

/// Triangle with corners a = (0, 0), b = (bx, 0), c = (cx, cy > 0) in the frame (u, v) at `origin`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Facet {
    pub origin: DVec3,
    pub u: DVec3,
    pub v: DVec3,
    /// Unit normal, outward.
    pub n: DVec3,
    bx: f64,
    cx: f64,
    cy: f64,
    /// Index of the triangle in its mesh.
    pub triangle: u32,
    /// Index of the corner of the mesh triangle that is corner 0 of the facet.
    pub turn: u32,
}

impl Facet {
    /// Builds the facet; returns None if the triangle is too thin to have a normal.
    pub fn new(p: [DVec3; 3], triangle: u32) -> Option<Self> {
        let length = |i: usize| (p[(i + 1) % 3] - p[i]).length_squared();
        let turn = (0..3).fold(0, |best, i| if length(i) > length(best) { i } else { best });
        let (a, b, c) = (p[turn], p[(turn + 1) % 3], p[(turn + 2) % 3]);
        let cross = (b - a).cross(c - a);
        let bx = (b - a).length();
        if !(cross.length() > FLAT_RATIO * bx * bx) {
            return None;
        }
        let u = (b - a) / bx;
        let n = cross.normalize();
        let v = n.cross(u);
        Some(Self { origin: a, u, v, n, bx, cx: u.dot(c - a), cy: v.dot(c - a), triangle, turn: turn as u32 })
    }

    /// Returns the squared distance to the triangle, m2, and its nearest part. If `q` projects exactly onto an edge or
    /// a corner, the part is that edge or corner.
    #[inline]
    pub fn nearest(&self, q: DVec3) -> (f64, TrianglePart) {
        self.nearest_within(q, f64::INFINITY)
    }

    /// Returns the result of [`Self::nearest`] if the squared distance is below `limit`, m2; otherwise the distance may
    /// be infinite.
    #[inline]
    pub fn nearest_within(&self, q: DVec3, limit: f64) -> (f64, TrianglePart) {
        let w = q - self.origin;
        let h = self.n.dot(w);
        let hh = h * h;
        if hh >= limit {
            return (f64::INFINITY, TrianglePart::Face);
        }
        let (x, y) = (self.u.dot(w), self.v.dot(w));
        let (bx, cx, cy) = (self.bx, self.cx, self.cy);
        let bc = cy * (x - bx) + (bx - cx) * y;
        let ca = cx * y - cy * x;
        if y > 0.0 && bc < 0.0 && ca < 0.0 {
            return (hh, TrianglePart::Face);
        }
        let mut best = (f64::INFINITY, TrianglePart::Face);
        let mut edge = |i: usize, px: f64, py: f64, ex: f64, ey: f64| {
            let (along, square) = (px * ex + py * ey, ex * ex + ey * ey);
            let (d, part) = if along <= 0.0 {
                (px * px + py * py, TrianglePart::Corner(i))
            } else if along >= square {
                ((px - ex) * (px - ex) + (py - ey) * (py - ey), TrianglePart::Corner((i + 1) % 3))
            } else {
                let across = px * ey - py * ex;
                (across * across / square, TrianglePart::Edge(i))
            };
            if d < best.0 {
                best = (d, part);
            }
        };
        if y <= 0.0 {
            edge(0, x, y, bx, 0.0);
        }
        if bc >= 0.0 {
            edge(1, x - bx, y, cx - bx, cy);
        }
        if ca >= 0.0 {
            edge(2, x - cx, y - cy, -cx, -cy);
        }
        (best.0 + hh, best.1)
    }

    /// Converts a part to the corner and edge indices of the mesh triangle.
    pub fn mesh_part(&self, part: TrianglePart) -> TrianglePart {
        let turned = |i: usize| (i + self.turn as usize) % 3;
        match part {
            TrianglePart::Face => TrianglePart::Face,
            TrianglePart::Edge(i) => TrianglePart::Edge(turned(i)),
            TrianglePart::Corner(i) => TrianglePart::Corner(turned(i)),
        }
    }

    /// Returns the distance of the projection of `q` from the nearest edge line, m; negative outside the triangle.
    pub fn edge_distance(&self, q: DVec3) -> f64 {
        let w = q - self.origin;
        let (x, y) = (self.u.dot(w), self.v.dot(w));
        let bc = (self.cy * (self.bx - x) + (self.cx - self.bx) * y) / self.cy.hypot(self.cx - self.bx);
        let ca = (self.cy * x - self.cx * y) / self.cy.hypot(self.cx);
        y.min(bc).min(ca)
    }

    /// Returns the corners, m; they may differ from the original ones by rounding.
    pub fn corners(&self) -> [DVec3; 3] {
        let o = self.origin;
        [o, o + self.bx * self.u, o + self.cx * self.u + self.cy * self.v]
    }

    /// Returns the area, m2.
    pub fn area(&self) -> f64 {
        0.5 * self.bx * self.cy
    }

    /// Returns the interval of parameters in 0..=1 on which the segment from `a` to `b`, which lies in the plane of the
    /// triangle, is inside the triangle or within `slack` (m) of it.
    pub fn clip(&self, a: DVec3, b: DVec3, slack: f64) -> Option<(f64, f64)> {
        let corners = self.corners();
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for i in 0..3 {
            let inward = self.n.cross(corners[(i + 1) % 3] - corners[i]).normalize();
            let (x, y) = (inward.dot(a - corners[i]) + slack, inward.dot(b - corners[i]) + slack);
            if x < 0.0 && y < 0.0 {
                return None;
            }
            if x < 0.0 {
                from = from.max(x / (x - y));
            } else if y < 0.0 {
                to = to.min(x / (x - y));
            }
        }
        (from <= to).then_some((from, to))
    }

    /// Returns the parameter at which the ray `o + t d` crosses from the outside to the inside. A margin of the size of
    /// rounding errors prevents rays from passing between two adjacent triangles.
    pub fn ray_entry(&self, o: DVec3, d: DVec3) -> Option<f64> {
        let (rate, w) = (self.n.dot(d), o - self.origin);
        if rate >= 0.0 {
            return None;
        }
        let t = -self.n.dot(w) / rate;
        let p = w + t * d;
        let (x, y) = (self.u.dot(p), self.v.dot(p));
        let margin = 1e-13 * (self.bx + w.abs().max_element());
        let inside = y >= -margin
            && self.cy * (x - self.bx) + (self.bx - self.cx) * y <= margin * self.bx
            && self.cx * y - self.cy * x <= margin * self.bx;
        (inside && t >= 0.0).then_some(t)
    }

    /// Returns the bounding box of the triangle; it may exceed the corners by rounding.
    pub fn aabb(&self) -> Aabb {
        Aabb::from_points(self.corners())
    }
}
