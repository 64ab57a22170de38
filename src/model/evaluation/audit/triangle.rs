//! Distance of a point to a triangle.

use glam::DVec3;

/// Returns the point of the triangle closest to `p` (Ericson 2005, Real-Time Collision Detection, section 5.1.5).
pub fn closest([a, b, c]: [DVec3; 3], p: DVec3) -> DVec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3));
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
    }
    let scale = 1.0 / (va + vb + vc);
    a + ab * (vb * scale) + ac * (vc * scale)
}

/// Returns the smallest distance of `p` to any of the triangles, m.
pub fn distance(triangles: &[[DVec3; 3]], p: DVec3) -> f64 {
    let mut best = f64::INFINITY;
    for t in triangles {
        let reach = t[0].distance(t[1]).max(t[0].distance(t[2]));
        if p.distance(t[0]) - reach < best {
            best = best.min(closest(*t, p).distance(p));
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_closest_point_is_on_the_face_an_edge_or_a_corner() {
        let t = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let cases = [
            (DVec3::new(0.2, 0.3, 0.7), DVec3::new(0.2, 0.3, 0.0)),
            (DVec3::new(0.4, -1.0, 0.1), DVec3::new(0.4, 0.0, 0.0)),
            (DVec3::new(1.0, 1.0, -2.0), DVec3::new(0.5, 0.5, 0.0)),
            (DVec3::new(-1.0, 0.3, 0.0), DVec3::new(0.0, 0.3, 0.0)),
            (DVec3::new(3.0, -1.0, 0.0), DVec3::X),
            (DVec3::new(-1.0, -1.0, 1.0), DVec3::ZERO),
            (DVec3::new(-0.5, 4.0, 0.0), DVec3::Y),
        ];
        for (p, q) in cases {
            assert!(closest(t, p).distance(q) < 1e-15, "{p}: {} instead of {q}", closest(t, p));
        }
    }
}
