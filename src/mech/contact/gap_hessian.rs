//! Second derivatives of the distance of a contact vertex to a face of the pad: the face is curved, rotates with its
//! nodes, and the closest point slides over it.
//!
//! Let `g` be the gap along the face's normal `n`, `u` the motion of the vertex relative to the closest point, `d_i`
//! the tangents there and `w_i` their rotation towards `n` by the motion of the nodes. The smallest distance over the
//! face has
//!
//! ```text
//! d2g = -(2 a.G^-1 w + g w.G^-1 w + c.Q c)      a_i = d_i.u    c = a + g w    G_ij = d_i.d_j
//!                                               Q = G^-1 B (G - g B)^-1       B_ij = n.d_i,j
//! ```
//!
//! (second variation of a minimum: the Hessian minus the part that the sliding of the closest point relaxes).

use super::closest_point::ClosestPoint;
use super::folds::second_derivatives;
use super::surface::{ON_RIM, SurfaceFace, tangents};
use crate::potential::block::Form;
use glam::{DMat2, DVec2, DVec3};

/// Second derivatives of the energy of a pressure force `p` (N) on the pad due to this curvature; `None` on the rim of
/// the face, where the closest point does not slide, and beyond the centre of curvature.
pub(crate) fn curvature_form(face: &SurfaceFace, x: &[DVec3], closest_point: &ClosestPoint, p: f64) -> Option<Form<4>> {
    if closest_point.l.iter().any(|v| v.abs() <= ON_RIM) {
        return None;
    }
    let (n, gap) = (closest_point.normal, closest_point.gap);
    let (_, d1, d2) = tangents(face, x, closest_point.l);
    let [b11, b12, b22] = second_derivatives(face, x).map(|d| d.dot(n));
    let metric = symmetric(d1.dot(d1), d1.dot(d2), d2.dot(d2));
    let bent = symmetric(b11, b12, b22);
    let slid = metric - bent * gap;
    if slid.x_axis.x <= 0.0 || slid.determinant() <= 0.0 || metric.determinant() <= 0.0 {
        return None;
    }
    let inverse = metric.inverse();
    let q = inverse * bent * slid.inverse();
    let cross = inverse + q * gap;
    let turned = cross * gap;
    let part = |m: &DMat2, i: usize, j: usize| 0.5 * (m.col(i)[j] + m.col(j)[i]);
    // The force conjugate to the gap is -p.
    let matrix = std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            p * match (i < 2, j < 2) {
                (true, true) => part(&q, i, j),
                (false, false) => part(&turned, i - 2, j - 2),
                _ => part(&cross, i % 2, j % 2),
            }
        })
    });
    let nodes =
        face.shape(closest_point.l).map(|(node, phi, slope)| (node, [d1 * -phi, d2 * -phi, n * slope.x, n * slope.y]));
    Some(Form { nodes: nodes.collect(), delta: [-d1, -d2, DVec3::ZERO, DVec3::ZERO], matrix })
}

fn symmetric(a: f64, b: f64, c: f64) -> DMat2 {
    DMat2::from_cols(DVec2::new(a, b), DVec2::new(b, c))
}
