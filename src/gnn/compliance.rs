//! The linear response of a pad: how all its nodes give to small forces on its sensing face.
//!
//! One factorisation of the stiffness at rest and a solve per force component, once per pad: the network learns what large
//! strains and the true pressure change. Over the thickness per `E t^2`, pad frame.

use super::tape::Matrix;
use crate::error::{Error, Result};
use crate::fem::body::Body;
use crate::fem::cholesky::Factor;
use crate::model::FingerModel;
use crate::record::PadTopology;
use glam::DVec3;
use std::collections::BTreeMap;

/// Displacement over the thickness that is small enough for a linear response.
const SMALL: f64 = 1e-6;
/// Right-hand sides that are solved for at once.
const COLUMNS: usize = 96;

/// Responses to unit forces.
#[derive(Debug, Clone)]
pub struct Compliance {
    /// (face nodes * 3, nodes * 3): how every component gives to each force component, spread on the face around its node.
    pub response: Matrix,
    /// (face nodes * 3, nodes * 5): deviatoric stress (xx, yy, xy, yz, zx; hand axes) over `E`.
    pub stress: Matrix,
}

impl Compliance {
    /// Of the pad of `finger` to forces on its nodes `face`; `thickness` in m.
    ///
    /// # Errors
    /// A stiffness that is not positive definite.
    pub fn new(finger: &FingerModel, face: &[u32], thickness: f64) -> Result<Self> {
        let (body, turn) = (&finger.body, finger.placement.rotation);
        let (pattern, symbolic) = (&body.pattern, &body.symbolic);
        let (free, n) = (pattern.unknowns(), body.rest.len());
        let mut values = vec![0.0; pattern.row_idx.len()];
        body.add_stiffness(&body.rest, true, &mut vec![DVec3::ZERO; n], &mut values);
        let mut factor = Factor::new(symbolic, COLUMNS);
        if !factor.factorize(symbolic, pattern, &values) {
            return Err(Error::Mesh("the pad has no stiffness at rest: is any of its nodes bonded?".into()));
        }
        let place = |node: usize| pattern.position[node] as usize;
        let held = |node: usize| place(node) >= free / 3;
        let unit = body.material.moduli().young * thickness;
        let mut rows = Vec::with_capacity(9 * face.len() * n);
        let mut stress = Vec::with_capacity(15 * face.len() * n);
        let forces: Vec<(usize, DVec3)> =
            face.iter().flat_map(|i| [turn.x_axis, turn.y_axis, turn.z_axis].map(|axis| (*i as usize, axis))).collect();
        for some in forces.chunks(COLUMNS) {
            let mut solved = vec![0.0; free * some.len()];
            for (column, (node, axis)) in solved.chunks_exact_mut(free).zip(some).filter(|(_, f)| !held(f.0)) {
                column[3 * place(*node)..][..3].copy_from_slice(&axis.to_array());
            }
            factor.solve(symbolic, &mut solved, some.len());
            for column in solved.chunks_exact(free) {
                let moved = |node: usize| {
                    if held(node) { DVec3::ZERO } else { DVec3::from_slice(&column[3 * place(node)..]) }
                };
                let u: Vec<DVec3> = (0..n).map(moved).collect();
                rows.extend(u.iter().flat_map(|u| (turn.transpose() * *u * unit).to_array().map(|v| v as f32)));
                stress.extend(deviators(body, &u, thickness).flat_map(|s| s.map(|v| v as f32)));
            }
        }
        let [response, stress] = [(rows, 3 * n), (stress, 5 * n)]
            .map(|(rows, width)| Matrix::constant(3 * face.len(), width, spread(&finger.topology, face, &rows, width)));
        Ok(Self { response, stress })
    }

    /// Displacement of the nodes `face` under forces on them.
    pub fn on_face(&self, face: &[u32], forces: &[DVec3]) -> Vec<DVec3> {
        let mut u = vec![0.0_f32; 3 * face.len()];
        let components = forces.iter().flat_map(|f| f.to_array()).enumerate();
        for (component, force) in components.filter(|(_, f)| *f != 0.0) {
            let row = &self.response.value()[component * self.response.cols..][..self.response.cols];
            for (u, node) in u.as_chunks_mut::<3>().0.iter_mut().zip(face) {
                u.iter_mut().zip(&row[3 * *node as usize..]).for_each(|(u, r)| *u += r * force as f32);
            }
        }
        u.as_chunks::<3>().0.iter().map(|u| DVec3::from_array(u.map(f64::from))).collect()
    }
}

/// Deviatoric stress on every node under a displacement per force `u`, m/N, in the limit of small ones; over `E` per `E t^2`.
fn deviators(body: &Body, u: &[DVec3], thickness: f64) -> impl Iterator<Item = [f64; 5]> {
    let most = u.iter().map(|u| u.length()).fold(1e-300, f64::max);
    let small = SMALL * thickness / most;
    let x: Vec<DVec3> = body.rest.iter().zip(u).map(|(x, u)| *x + *u * small).collect();
    let [_, node] = body.cauchy(&x);
    // Per newton, then per E t^2, over E.
    let scale = thickness * thickness / small;
    node.into_iter().map(move |s| {
        let s = s * scale;
        let mean = (s.x_axis.x + s.y_axis.y + s.z_axis.z) / 3.0;
        [s.x_axis.x - mean, s.y_axis.y - mean, s.x_axis.y, s.y_axis.z, s.z_axis.x]
    })
}

/// Responses to forces that are spread on the face around their node, instead of acting on the node alone: on a face of
/// 6-node triangles an even pressure loads no corner.
fn spread(pad: &PadTopology, face: &[u32], rows: &[f32], width: usize) -> Vec<f32> {
    if pad.elements.width() == 4 {
        return rows.to_vec();
    }
    let own: BTreeMap<u32, usize> = face.iter().enumerate().map(|(i, n)| (*n, i)).collect();
    // Per node: area, and how much of a unit traction there each node takes.
    let (mut area, mut taken) = (vec![0.0; face.len()], vec![BTreeMap::new(); face.len()]);
    // A 6-node triangle is listed as its four parts: those at the corners, then the middle.
    for parts in pad.sensing.as_chunks::<4>().0 {
        let [a, b, c] = [parts[0][0], parts[1][1], parts[2][2]];
        let [ab, bc, ca] = parts[3];
        for (part, at) in parts.iter().zip(CENTRES) {
            let [p, q, r] = part.map(|n| pad.rest[n as usize]);
            let third = (q - p).cross(r - p).length() / 6.0;
            let [u, v, w] = at;
            let shape = [
                (a, u * (2.0 * u - 1.0)),
                (b, v * (2.0 * v - 1.0)),
                (c, w * (2.0 * w - 1.0)),
                (ab, 4.0 * u * v),
                (bc, 4.0 * v * w),
                (ca, 4.0 * w * u),
            ];
            for from in part.map(|n| own[&n]) {
                area[from] += third;
                shape.iter().for_each(|(n, s)| *taken[from].entry(own[n]).or_insert(0.0) += third * s);
            }
        }
    }
    let mut out = vec![0.0; rows.len()];
    for (i, (area, taken)) in area.iter().zip(&taken).enumerate() {
        for (j, part) in taken {
            let part = (part / area) as f32;
            for k in 0..3 {
                let target = &mut out[(3 * i + k) * width..(3 * i + k + 1) * width];
                target.iter_mut().zip(&rows[(3 * j + k) * width..]).for_each(|(t, r)| *t += part * r);
            }
        }
    }
    out
}

/// Barycentric coordinates of the centres of the four parts of a triangle.
const CENTRES: [[f64; 3]; 4] = [
    [2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0],
    [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0],
    [1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0],
    [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0],
];
