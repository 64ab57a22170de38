//! First and second derivatives of contact and friction energies in the motion of a pad point and of the object.

use super::edge::EdgeState;
use super::law::ContactLaw;
use crate::potential::block::Pair;
use crate::potential::cross::{cross_matrix, outer, rotation_hessian};
use crate::potential::term::Assembly;
use glam::{DMat3, DVec3};

/// Derivatives of the normal energy. With `g` the gap, `u = delta - w x r` the relative motion and `n` the normal,
/// `g = n.u + u.H u / 2 + n.(w x (w x r) / 2 - w x delta)` to second order.
pub(crate) fn normal_pair(law: &ContactLaw, e: &EdgeState, area: f64, r: DVec3, h: &DMat3, project: bool) -> Pair {
    let (n, p, k) = (e.normal, e.pressure * area, law.pressure(e.gap, e.scale).1 * area);
    let tau = -r.cross(n);
    let mut pair =
        Pair { force: n * -p, torque: tau * -p, dd: outer(n, n) * k, dw: outer(n, tau) * k, ww: outer(tau, tau) * k };
    if !project {
        let arm = cross_matrix(r);
        pair.dd -= *h * p;
        pair.dw -= (*h * arm - cross_matrix(n)) * p;
        pair.ww -= (arm.transpose() * *h * arm + rotation_hessian(n, r)) * p;
    }
    pair
}

/// Derivatives of the normal energy for a contact vertex of the object against a pad, whose normal does not rotate with
/// the object: with `r` the arm of the vertex, `g = n.(delta - w x r - w x (w x r) / 2) + u.H u / 2`.
pub(crate) fn vertex_pair(law: &ContactLaw, e: &EdgeState, area: f64, r: DVec3, h: &DMat3, project: bool) -> Pair {
    let mut pair = normal_pair(law, e, area, r, &DMat3::ZERO, true);
    if !project {
        let (p, arm) = (e.pressure * area, cross_matrix(r));
        pair.dd -= *h * p;
        pair.dw -= *h * arm * p;
        pair.ww += (rotation_hessian(e.normal, r) - arm.transpose() * *h * arm) * p;
    }
    pair
}

/// Drops the stiffness of a contact with negative `weight` if `project` is set. Such a contact is subtracted where
/// incident faces of a valley meet; its stiffness is negative, so that its projection is zero.
pub(crate) fn project_weighted(pair: Pair, weight: f64, project: bool) -> Pair {
    if weight < 0.0 && project {
        return Pair { dd: DMat3::ZERO, dw: DMat3::ZERO, ww: DMat3::ZERO, ..pair };
    }
    pair
}

/// Derivatives of the friction energy at fixed normal and limit; `s` is the displacement of the pad's point from the
/// sticking point, `r` the arm of the object's point.
pub(crate) fn friction_pair(law: &ContactLaw, e: &EdgeState, area: f64, s: DVec3, r: DVec3, how: Assembly) -> Pair {
    let n = e.plane;
    let (a, b) = law.with_active_fraction(e.active_fraction).friction_hessian(slip(s, n), e.limit, how.secant);
    let t = e.traction.normalize_or_zero();
    let d = ((DMat3::IDENTITY - outer(n, n)) * a - outer(t, t) * b) * area;
    let force = e.traction * -area;
    let arm = cross_matrix(r);
    let mut pair = Pair { force, torque: -r.cross(force), dd: d, dw: d * arm, ww: arm.transpose() * d * arm };
    if !how.project {
        pair.ww -= rotation_hessian(force, r);
    }
    pair
}

/// Tangential part of a displacement.
#[inline(always)]
pub(crate) fn slip(s: DVec3, normal: DVec3) -> DVec3 {
    s - normal * normal.dot(s)
}
