//! Gradients and Hessians to which the terms of the potential add: one block per body, and one of the rigid unknowns.

use super::cross::outer;
use super::state::{BodyView, MAX_RIGID, ObjectView};
use super::stencil::Stencil;
use crate::body::Body;
use crate::body::pattern::{FIXED, Pattern};
use glam::{DMat3, DVec3};

/// Gradient and Hessian in the rigid unknowns.
#[derive(Debug, Clone, Default)]
pub struct RigidBlock {
    /// Energy gradient per rigid column, N.
    pub gradient: [f64; MAX_RIGID],
    /// Second derivatives of the energy in the rigid columns, N/m.
    pub hessian: [[f64; MAX_RIGID]; MAX_RIGID],
    /// Sum of the squared lag errors, N2.
    pub lag: f64,
    /// Sum of the norms of the forces on the rigid unknowns (scale of the force tolerance), N.
    pub force_scale: f64,
    /// Flag: Hessians are assembled; else the previous ones are kept.
    pub wants_hessian: bool,
}

impl RigidBlock {
    /// Sets the gradient to zero, and the Hessian if it is to be assembled again.
    pub fn clear(&mut self, hessian: bool) {
        let kept = if hessian { [[0.0; MAX_RIGID]; MAX_RIGID] } else { self.hessian };
        *self = Self { hessian: kept, wants_hessian: hessian, ..Self::default() };
    }

    /// Adds an interaction of the object with a fixed body.
    pub fn add_object_pair(&mut self, view: &ObjectView, pair: &Pair) {
        self.add_pair(&RigidColumns::new(None, view), pair);
    }

    fn add_pair(&mut self, columns: &RigidColumns, pair: &Pair) {
        for (i, di, wi) in columns.slice() {
            self.gradient[*i] += pair.force.dot(*di) + pair.torque.dot(*wi);
            if !self.wants_hessian {
                continue;
            }
            let (left_d, left_w) = (pair.dd * *di + pair.dw * *wi, pair.dw.transpose() * *di + pair.ww * *wi);
            for (j, dj, wj) in columns.slice() {
                self.hessian[*i][*j] += left_d.dot(*dj) + left_w.dot(*wj);
            }
        }
        self.force_scale += pair.force.length();
    }
}

/// Gradient and Hessian of one body's terms, with their contribution to the rigid unknowns.
#[derive(Debug, Clone)]
pub struct BodyBlock {
    /// Energy gradient per node, N.
    pub gradient: Vec<DVec3>,
    /// Lower triangle of the body's Hessian in [`Pattern`] storage, N/m.
    pub values: Vec<f64>,
    /// Second derivatives of the energy in nodes (rows, in elimination order) and rigid unknowns (columns), column by
    /// column, N/m.
    pub coupling: Vec<f64>,
    /// Contribution to the rigid unknowns.
    pub rigid: RigidBlock,
}

impl BodyBlock {
    /// Creates zeroed storage for `body` with `columns` rigid columns.
    pub fn new(body: &Body, columns: usize) -> Self {
        Self {
            values: vec![0.0; body.pattern().row_idx.len()],
            coupling: vec![0.0; columns * body.unknowns()],
            rigid: RigidBlock { wants_hessian: true, ..RigidBlock::default() },
            ..Self::gradients(body)
        }
    }

    /// Creates storage for gradients alone.
    pub fn gradients(body: &Body) -> Self {
        let gradient = vec![DVec3::ZERO; body.rest.len()];
        Self { gradient, values: Vec::new(), coupling: Vec::new(), rigid: RigidBlock::default() }
    }

    /// Returns true if Hessians are assembled; else the previous ones are kept.
    pub fn wants_hessian(&self) -> bool {
        self.rigid.wants_hessian
    }

    /// Sets gradients to zero, and Hessians if they are to be assembled again.
    pub fn clear(&mut self, hessian: bool) {
        self.gradient.fill(DVec3::ZERO);
        self.rigid.clear(hessian);
        if hessian {
            self.values.fill(0.0);
            self.coupling.fill(0.0);
        }
    }

    /// Adds an interaction between a material point of the body (`sum phi_a x_a`) and the rigid object.
    pub fn add_pair(&mut self, body: &Body, view: &BodyView, stencil: &Stencil, pair: &Pair) {
        let pattern = body.pattern();
        let unknowns = pattern.unknowns();
        let (nodes, phi) = stencil.slices();
        for (&a, &pa) in nodes.iter().zip(phi) {
            self.gradient[a as usize] += pair.force * pa;
            let position = pattern.position[a as usize];
            if position == FIXED || !self.wants_hessian() {
                continue;
            }
            for (&b, &pb) in nodes.iter().zip(phi) {
                // Each unordered pair once: the pattern stores the lower triangle only.
                if pattern.position[b as usize] != FIXED && pattern.position[b as usize] <= position {
                    Pattern::add(&mut self.values, pattern.slot(a, b), &(pair.dd * (pa * pb)));
                }
            }
            let row = 3 * position as usize;
            let mut column = |c: usize, v: DVec3| {
                let start = c * unknowns + row;
                let target = &mut self.coupling[start..start + 3];
                target[0] += v.x;
                target[1] += v.y;
                target[2] += v.z;
            };
            if let Some(c) = view.travel_column {
                column(c, pair.dd * view.closing * pa);
            }
            if let Some(c) = view.object.column {
                for k in 0..3 {
                    column(c + k, pair.dd.col(k) * -pa);
                    column(c + 3 + k, pair.dw.col(k) * (pa / view.object.length));
                }
            }
        }
        self.rigid.add_pair(&RigidColumns::of(view), pair);
    }

    /// Adds the second derivatives `form` of an interaction with the object's point at arm `r` (m from the origin).
    pub fn add_form<const K: usize>(&mut self, body: &Body, view: &BodyView, form: &Form<K>, r: DVec3) {
        let pattern = body.pattern();
        let unknowns = pattern.unknowns();
        let columns = RigidColumns::of(view);
        let rigid = columns.columns.map(|(c, d, w)| (c, form.delta.map(|f| f.dot(d - w.cross(r)))));
        let rigid = &rigid[..columns.count];
        let free = form.nodes.iter().filter(|(node, _)| pattern.position[*node as usize] != FIXED);
        for (a, forms_a) in free.clone() {
            let position = pattern.position[*a as usize];
            let rows: [DVec3; K] = std::array::from_fn(|j| (0..K).map(|i| forms_a[i] * form.matrix[i][j]).sum());
            for (b, forms_b) in free.clone().filter(|(b, _)| pattern.position[*b as usize] <= position) {
                let block = rows.iter().zip(forms_b).map(|(row, f)| outer(*row, *f)).sum();
                Pattern::add(&mut self.values, pattern.slot(*a, *b), &block);
            }
            for (c, forms) in rigid {
                let start = c * unknowns + 3 * position as usize;
                let v: DVec3 = rows.iter().zip(forms).map(|(row, f)| *row * *f).sum();
                self.coupling[start..start + 3].iter_mut().zip(v.to_array()).for_each(|(target, v)| *target += v);
            }
        }
        for (i, forms_i) in rigid {
            for (j, forms_j) in rigid {
                let along = |k: usize| (0..K).map(|l| form.matrix[k][l] * forms_j[l]).sum::<f64>();
                self.rigid.hessian[*i][*j] += (0..K).map(|k| forms_i[k] * along(k)).sum::<f64>();
            }
        }
    }
}

/// Columns of the rigid unknowns that take part in an interaction. Each has its index, the motion along it of the
/// body's point relative to the object's, and the rotation of the object.
struct RigidColumns {
    columns: [(usize, DVec3, DVec3); 7],
    count: usize,
}

impl RigidColumns {
    /// Collects the columns of the object, and that of a finger's travel along its closing direction.
    fn new(travel: Option<(usize, DVec3)>, object: &ObjectView) -> Self {
        let mut all = Self { columns: [(usize::MAX, DVec3::ZERO, DVec3::ZERO); 7], count: 0 };
        let mut push = |entry| {
            all.columns[all.count] = entry;
            all.count += 1;
        };
        if let Some((c, closing)) = travel {
            push((c, closing, DVec3::ZERO));
        }
        if let Some(c) = object.column {
            for k in 0..3 {
                push((c + k, -DVec3::AXES[k], DVec3::ZERO));
            }
            for k in 0..3 {
                push((c + 3 + k, DVec3::ZERO, DVec3::AXES[k] / object.length));
            }
        }
        all
    }

    fn of(view: &BodyView) -> Self {
        Self::new(view.travel_column.map(|c| (c, view.closing)), &view.object)
    }

    fn slice(&self) -> &[(usize, DVec3, DVec3)] {
        &self.columns[..self.count]
    }
}

/// Second derivatives `sum matrix_ij f_i f_j` in linear forms `f` of the motion of nodes and of a point of a body
/// relative to the object.
#[derive(Debug, Clone)]
pub struct Form<const K: usize> {
    /// Contributions of the motion of each node to each form.
    pub nodes: Vec<(u32, [DVec3; K])>,
    /// Contributions of the motion of finger and object to each form, per relative displacement (m).
    pub delta: [DVec3; K],
    /// Symmetric matrix of the second derivatives in the forms.
    pub matrix: [[f64; K]; K],
}

/// First and second derivatives of an interaction between a point of a pad and the object.
#[derive(Debug, Clone, Copy)]
pub struct Pair {
    /// Gradient in the point's displacement relative to the object, N.
    pub force: DVec3,
    /// Gradient in the object's rotation (hand axes), N m.
    pub torque: DVec3,
    /// Second derivatives displacement-displacement, N/m, symmetric.
    pub dd: DMat3,
    /// Second derivatives displacement (rows) - rotation (columns), N.
    pub dw: DMat3,
    /// Second derivatives rotation-rotation, N m, symmetric.
    pub ww: DMat3,
}

impl Pair {
    /// Creates a pair of a force alone: `force` is the gradient in the relative displacement (N), `r` the arm of the
    /// object's point (m).
    pub fn force(force: DVec3, r: DVec3) -> Self {
        Self { force, torque: -r.cross(force), dd: DMat3::ZERO, dw: DMat3::ZERO, ww: DMat3::ZERO }
    }
}
