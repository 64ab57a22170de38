//! The springs of one finger: how they move, and what they add to the equilibrium of the grasp.

use super::foundation::Foundation;
use super::springs::{NORMAL, Rest, Spring, TANGENTIAL, UNKNOWNS, Vector};
use glam::{DMat3, DVec3};
use std::ops::Range;

/// The springs of a finger, number by number: the loops over them run in registers.
#[derive(Debug, Clone)]
pub(super) struct Side {
    springs: Range<usize>,
    pub closing: DVec3,
    normal: [Vec<f64>; 3],
    at: [Vec<f64>; 3],
    area: Vec<f64>,
    /// What each spring adds to the stiffness by its normal, and by its tangent: see [`parts`].
    stiffness: Vec<[Parts; 2]>,
    /// Pressed along the closing direction by themselves.
    pub alone: Foundation,
}

/// `M` (xx, xy, xz, yy, yz, zz), `M A` by rows, `A' M A` like `M`, filled up: `M` is the stiffness of a spring, and `A r` how
/// it slides when the object turns by `-r`.
type Parts = [f64; 24];

impl Side {
    pub fn new(springs: &[Spring], finger: usize, closing: DVec3) -> Self {
        let first = springs.partition_point(|s| s.finger < finger);
        let range = first..first + springs[first..].partition_point(|s| s.finger == finger);
        let own = &springs[range.clone()];
        let (gap, area): (Vec<f64>, Vec<f64>) =
            own.iter().filter(|s| s.normal != DVec3::ZERO).map(|s| (s.gap, s.area)).unzip();
        Self {
            springs: range,
            closing,
            normal: [0, 1, 2].map(|k| own.iter().map(|s| s.normal[k]).collect()),
            at: [0, 1, 2].map(|k| own.iter().map(|s| s.at[k]).collect()),
            area: own.iter().map(|s| s.area).collect(),
            stiffness: own.iter().map(parts).collect(),
            alone: Foundation::new(&gap, &area),
        }
    }

    /// The springs of `now` when the finger has closed by `travel` since `before` and the object has moved by `object`
    /// (translation, rotation vector); whether other springs touch than before the call.
    #[inline(always)]
    pub fn slide(&self, travel: f64, object: &[f64], before: &Rest, now: &mut Rest) -> bool {
        let own = self.springs.clone();
        let n = own.len();
        let [nx, ny, nz] = self.normal.each_ref().map(|v| &v[..n]);
        let [ax, ay, az] = self.at.each_ref().map(|v| &v[..n]);
        let old = &before.pressed[own.clone()];
        let [ox, oy, oz] = before.drag.each_ref().map(|v| &v[own.clone()]);
        let pressed = &mut now.pressed[own.clone()];
        let [dx, dy, dz] = now.drag.each_mut().map(|v| &mut v[own.clone()]);
        let by = self.closing * travel - DVec3::from_slice(object);
        let turn = DVec3::from_slice(&object[3..]);
        let mut changed = 0_u64;
        for i in 0..n {
            let x = by.x - (turn.y * az[i] - turn.z * ay[i]);
            let y = by.y - (turn.z * ax[i] - turn.x * az[i]);
            let z = by.z - (turn.x * ay[i] - turn.y * ax[i]);
            let into = -(nx[i] * x + ny[i] * y + nz[i] * z);
            let is = old[i] + into;
            changed += u64::from((is > 0.0) != (pressed[i] > 0.0));
            pressed[i] = is;
            let part = touching(old[i], is);
            // The object drags the node against the way that the node would have gone.
            dx[i] = (ox[i] - (x + nx[i] * into)) * part;
            dy[i] = (oy[i] - (y + ny[i] * into)) * part;
            dz[i] = (oz[i] - (z + nz[i] * into)) * part;
        }
        changed > 0
    }

    /// Adds what the touching springs do: `gradient` and `stiffness` of (travels, translation, rotation).
    pub fn add(
        &self,
        travel: usize,
        before: &Rest,
        now: &Rest,
        gradient: &mut Vector,
        stiffness: &mut [[f64; UNKNOWNS]; UNKNOWNS],
    ) {
        let (mut sum, mut force, mut torque) = ([0.0; 24], DVec3::ZERO, DVec3::ZERO);
        for (i, global) in self.springs.clone().enumerate().filter(|(_, g)| now.pressed[*g] > 0.0) {
            let part = touching(before.pressed[global], now.pressed[global]);
            let [normal, along] = &self.stiffness[i];
            for ((sum, normal), along) in sum.iter_mut().zip(normal).zip(along) {
                *sum += normal + part * along;
            }
            let vector = |v: &[Vec<f64>; 3]| DVec3::from_array([0, 1, 2].map(|k| v[k][i]));
            let pull = vector(&self.normal) * (NORMAL * self.area[i] * now.pressed[global])
                + now.dragged(global) * (TANGENTIAL * self.area[i]);
            force += pull;
            torque += vector(&self.at).cross(pull);
        }
        gradient[travel] -= force.dot(self.closing);
        for k in 0..3 {
            gradient[2 + k] += force[k];
            gradient[5 + k] += torque[k];
        }
        let c = self.closing.to_array();
        let symmetric = |from: usize, a: usize, b: usize| sum[from + [[0, 1, 2], [1, 3, 4], [2, 4, 5]][a][b]];
        for a in 0..3 {
            for b in 0..3 {
                let (m, turned) = (symmetric(0, a, b), sum[6 + 3 * a + b]);
                stiffness[travel][travel] += c[a] * m * c[b];
                stiffness[travel][2 + b] -= c[a] * m;
                stiffness[2 + b][travel] -= c[a] * m;
                stiffness[travel][5 + b] -= c[a] * turned;
                stiffness[5 + b][travel] -= c[a] * turned;
                stiffness[2 + a][2 + b] += m;
                stiffness[2 + a][5 + b] += turned;
                stiffness[5 + b][2 + a] += turned;
                stiffness[5 + a][5 + b] += symmetric(15, a, b);
            }
        }
    }
}

/// [`Parts`] of a spring: by its normal, and by its tangent.
fn parts(s: &Spring) -> [Parts; 2] {
    let outer = DMat3::from_cols(s.normal * s.normal.x, s.normal * s.normal.y, s.normal * s.normal.z);
    // The columns of A: axis x at.
    let slid = DMat3::from_cols(DVec3::X.cross(s.at), DVec3::Y.cross(s.at), DVec3::Z.cross(s.at));
    [outer * (NORMAL * s.area), (DMat3::IDENTITY - outer) * (TANGENTIAL * s.area)].map(|m| {
        let (turned, twice) = (m * slid, slid.transpose() * m * slid);
        let upper = |m: DMat3| [m.x_axis.x, m.x_axis.y, m.x_axis.z, m.y_axis.y, m.y_axis.z, m.z_axis.z];
        let rows = turned.transpose().to_cols_array();
        let mut all = upper(m).into_iter().chain(rows).chain(upper(twice));
        std::array::from_fn(|_| all.next().unwrap_or(0.0))
    })
}

/// Part of a step during which a spring touches.
#[inline(always)]
fn touching(before: f64, now: f64) -> f64 {
    if now <= 0.0 {
        0.0
    } else if before >= 0.0 {
        1.0
    } else {
        now / (now - before)
    }
}
