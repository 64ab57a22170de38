//! From springs to gel: contact forces for which the pad's linear response, not each spring by itself, follows the object.
//!
//! Springs know nothing of their neighbours. The forces are relaxed towards those under which every touching node gives as
//! the object asks, none pulls, and their sums stay: projected gradient steps with momentum (Beck and Teboulle 2009). A few
//! are enough, the network learns the rest.

use super::compliance::Compliance;
use glam::{DMat3, DVec3};

/// Steps.
const STEPS: usize = 10;
/// Nodes take part if they are this near to touching, over the deepest.
const REACH: f64 = 0.3;

/// A face node under load, pad frame, over the thickness and `E t^2`.
#[derive(Debug, Clone, Copy)]
pub struct Touching {
    /// Node of the pad.
    pub node: usize,
    /// Normal of the object.
    pub normal: DVec3,
    /// How far the object asks it in along the normal; negative is a gap.
    pub pressed: f64,
    /// How far the object asks it along the face.
    pub dragged: DVec3,
    /// Force of its spring.
    pub force: DVec3,
}

/// Forces on all of `face`, and how much farther than the springs the pad must be closed for them.
pub fn settle(compliance: &Compliance, face: &[Touching]) -> (Vec<DVec3>, f64) {
    let deepest = face.iter().map(|n| n.pressed).fold(0.0, f64::max);
    let near: Vec<usize> =
        (0..face.len()).filter(|i| face[*i].pressed > -REACH * deepest && face[*i].normal != DVec3::ZERO).collect();
    let m = near.len();
    let mut forces: Vec<DVec3> = face.iter().map(|n| n.force).collect();
    if m == 0 {
        return (forces, 0.0);
    }
    let width = compliance.response.cols;
    let value = compliance.response.value();
    // (m * 3, m * 3): component of a node under a force component.
    let mut matrix = Vec::with_capacity(9 * m * m);
    for j in &near {
        for b in 0..3 {
            let row = &value[(3 * j + b) * width..(3 * j + b + 1) * width];
            matrix.extend(near.iter().flat_map(|i| &row[3 * face[*i].node..][..3]).copied());
        }
    }
    let own = |i: usize| {
        DMat3::from_cols_array_2d(
            &[0, 1, 2].map(|b| [0, 1, 2].map(|a| f64::from(matrix[(3 * i + b) * 3 * m + 3 * i + a]))),
        )
    };
    let normal: Vec<DVec3> = near.iter().map(|i| face[*i].normal).collect();
    let stiff: Vec<f64> = (0..m).map(|i| 1.0 / (normal[i].dot(own(i) * normal[i])).max(1e-9)).collect();
    // A bound of the largest eigenvalue of the scaled matrix gives the step.
    let sums = (0..m).map(|j| {
        let rows = &matrix[9 * j * m..9 * (j + 1) * m];
        rows.iter().map(|v| f64::from(v.abs())).sum::<f64>() / 3.0 * stiff[j]
    });
    let step = 1.0 / sums.fold(1.0, f64::max);
    let response = |f: &[DVec3]| {
        let mut u = vec![0.0_f32; 3 * m];
        for (j, f) in f.iter().enumerate() {
            for (b, f) in f.to_array().into_iter().enumerate().filter(|(_, f)| *f != 0.0) {
                let row = &matrix[(3 * j + b) * 3 * m..(3 * j + b + 1) * 3 * m];
                u.iter_mut().zip(row).for_each(|(u, r)| *u += r * f as f32);
            }
        }
        u.as_chunks::<3>().0.iter().map(|u| DVec3::from_array(u.map(f64::from))).collect::<Vec<_>>()
    };
    let mut f: Vec<DVec3> = near.iter().map(|i| forces[*i]).collect();
    let whole: f64 = f.iter().zip(&normal).map(|(f, n)| f.dot(*n)).sum();
    let along: DVec3 = f.iter().zip(&normal).map(|(f, n)| *f - *n * f.dot(*n)).sum();
    let (mut before, mut closer) = (f.clone(), 0.0);
    for k in 0..STEPS {
        let momentum = k as f64 / (k + 3) as f64;
        let ahead: Vec<DVec3> = f.iter().zip(&before).map(|(f, b)| *f + (*f - *b) * momentum).collect();
        let u = response(&ahead);
        let lacks: Vec<f64> = (0..m).map(|i| face[near[i]].pressed - u[i].dot(normal[i])).collect();
        let pressure = |closer: f64| -> Vec<f64> {
            let at = |i: usize| ahead[i].dot(normal[i]) + step * stiff[i] * (lacks[i] + closer);
            (0..m).map(|i| at(i).max(0.0)).collect()
        };
        // Newton's method on a piecewise linear function: the sum of the pressures stays.
        for _ in 0..4 {
            let p = pressure(closer);
            let slope: f64 = p.iter().zip(&stiff).filter(|(p, _)| **p > 0.0).map(|(_, s)| step * s).sum();
            closer += if slope > 0.0 { (whole - p.iter().sum::<f64>()) / slope } else { deepest };
        }
        let p = pressure(closer);
        let mut tangent: Vec<DVec3> = (0..m)
            .map(|i| {
                let flat = |v: DVec3| v - normal[i] * v.dot(normal[i]);
                let asked = face[near[i]].dragged - u[i];
                if p[i] > 0.0 { flat(ahead[i]) + flat(asked) * (step * stiff[i]) } else { DVec3::ZERO }
            })
            .collect();
        let held: f64 = p.iter().zip(&stiff).filter(|(p, _)| **p > 0.0).map(|(_, s)| *s).sum();
        let lost = (along - tangent.iter().sum::<DVec3>()) / held.max(1e-9);
        tangent.iter_mut().zip(&p).zip(&stiff).filter(|((_, p), _)| **p > 0.0).for_each(|((t, _), s)| *t += lost * *s);
        before = std::mem::replace(&mut f, (0..m).map(|i| normal[i] * p[i] + tangent[i]).collect());
    }
    near.iter().zip(&f).for_each(|(i, f)| forces[*i] = *f);
    (forces, closer)
}
