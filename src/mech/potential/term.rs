//! The terms of the incremental potential. A physical effect is one file that implements [`BodyTerm`]; the solver sees
//! only the sum.

use super::state::{BodyMotion, BodyView, Departure, MAX_RIGID};
use super::time_step::TimeStep;
use crate::mech::body::Body;
use crate::mech::body::pattern::{FIXED, Pattern};
use crate::mech::potential::cross::outer;
use glam::{DMat3, DVec3};

/// Gradient and Hessian of one body's terms, with its share of the rigid unknowns.
#[derive(Debug, Clone)]
pub struct BodyBlock {
    /// Energy gradient per node, N.
    pub gradient: Vec<DVec3>,
    /// Lower triangle of the body's Hessian in [`Pattern`] storage, N/m.
    pub values: Vec<f64>,
    /// Columns of the second derivatives of the energy in nodes and rigid unknowns, in elimination order, one after the other, N/m.
    pub coupling: Vec<f64>,
    /// Gradient of the rigid unknowns, N.
    pub rigid_gradient: [f64; MAX_RIGID],
    /// Hessian of the rigid unknowns, N/m.
    pub rigid_hessian: [[f64; MAX_RIGID]; MAX_RIGID],
    /// Sum of the squares of what lagged quantities still miss, N2.
    pub lag: f64,
    /// Sum of the norms of the forces that meet at the rigid unknowns (scale of the balance), N.
    pub activity: f64,
    /// Flag: Hessians are wanted; else those of the last time stay as they are.
    pub hessian: bool,
}

impl BodyBlock {
    /// Creates zeroed storage for `body` with `columns` rigid columns.
    pub fn new(body: &Body, columns: usize) -> Self {
        Self {
            values: vec![0.0; body.pattern().row_idx.len()],
            coupling: vec![0.0; columns * body.unknowns()],
            hessian: true,
            ..Self::gradients(body)
        }
    }

    /// Creates storage for gradients alone.
    pub fn gradients(body: &Body) -> Self {
        let gradient = vec![DVec3::ZERO; body.rest.len()];
        Self {
            gradient,
            values: Vec::new(),
            coupling: Vec::new(),
            rigid_gradient: [0.0; MAX_RIGID],
            rigid_hessian: [[0.0; MAX_RIGID]; MAX_RIGID],
            lag: 0.0,
            activity: 0.0,
            hessian: false,
        }
    }

    /// Sets gradients to zero, and Hessians if they are wanted anew.
    pub fn clear(&mut self, hessian: bool) {
        self.hessian = hessian;
        self.gradient.fill(DVec3::ZERO);
        self.rigid_gradient = [0.0; MAX_RIGID];
        if hessian {
            self.values.fill(0.0);
            self.coupling.fill(0.0);
            self.rigid_hessian = [[0.0; MAX_RIGID]; MAX_RIGID];
        }
        self.lag = 0.0;
        self.activity = 0.0;
    }

    /// Adds a term that acts between a material point of the body (`sum phi_a x_a`) and the rigid object.
    ///
    /// `force` is the gradient in the relative displacement `delta` of the point to the object, `torque` the gradient in
    /// the object's rotation; `dd`, `dw`, `ww` are the second derivatives (delta-delta, delta-rotation, rotation-rotation).
    pub fn add_pair(&mut self, body: &Body, view: &BodyView, stencil: &Stencil, pair: &Pair) {
        let pattern = body.pattern();
        let unknowns = pattern.unknowns();
        let (nodes, phi) = stencil.slices();
        for (&a, &pa) in nodes.iter().zip(phi) {
            self.gradient[a as usize] += pair.force * pa;
            let position = pattern.position[a as usize];
            if position == FIXED || !self.hessian {
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
            if let Some(c) = view.pose_column {
                for k in 0..3 {
                    column(c + k, pair.dd.col(k) * -pa);
                    column(c + 3 + k, pair.dw.col(k) * (pa / view.length));
                }
            }
        }
        self.add_rigid(view, pair);
    }

    /// Adds the second derivatives `form` of an interaction with the object's point at arm `r` (m from the origin).
    pub fn add_form<const K: usize>(&mut self, body: &Body, view: &BodyView, form: &Form<K>, r: DVec3) {
        let pattern = body.pattern();
        let unknowns = pattern.unknowns();
        let (columns, count) = rigid_columns(view);
        let rigid = columns.map(|(c, d, w)| (c, form.delta.map(|f| f.dot(d - w.cross(r)))));
        let free = form.nodes.iter().filter(|(node, _)| pattern.position[*node as usize] != FIXED);
        for (a, forms_a) in free.clone() {
            let position = pattern.position[*a as usize];
            let rows: [DVec3; K] = std::array::from_fn(|j| (0..K).map(|i| forms_a[i] * form.matrix[i][j]).sum());
            for (b, forms_b) in free.clone().filter(|(b, _)| pattern.position[*b as usize] <= position) {
                let block = rows.iter().zip(forms_b).map(|(row, f)| outer(*row, *f)).sum();
                Pattern::add(&mut self.values, pattern.slot(*a, *b), &block);
            }
            for (c, forms) in &rigid[..count] {
                let start = c * unknowns + 3 * position as usize;
                let v: DVec3 = rows.iter().zip(forms).map(|(row, f)| *row * *f).sum();
                self.coupling[start..start + 3].iter_mut().zip(v.to_array()).for_each(|(target, v)| *target += v);
            }
        }
        for (i, forms_i) in &rigid[..count] {
            for (j, forms_j) in &rigid[..count] {
                let along = |k: usize| (0..K).map(|l| form.matrix[k][l] * forms_j[l]).sum::<f64>();
                self.rigid_hessian[*i][*j] += (0..K).map(|k| forms_i[k] * along(k)).sum::<f64>();
            }
        }
    }

    /// Adds the part of [`BodyBlock::add_pair`] between rigid unknowns.
    fn add_rigid(&mut self, view: &BodyView, pair: &Pair) {
        let (columns, count) = rigid_columns(view);
        for (i, di, wi) in &columns[..count] {
            self.rigid_gradient[*i] += pair.force.dot(*di) + pair.torque.dot(*wi);
            if !self.hessian {
                continue;
            }
            let (left_d, left_w) = (pair.dd * *di + pair.dw * *wi, pair.dw.transpose() * *di + pair.ww * *wi);
            for (j, dj, wj) in &columns[..count] {
                self.rigid_hessian[*i][*j] += left_d.dot(*dj) + left_w.dot(*wj);
            }
        }
        self.activity += pair.force.length();
    }
}

/// Columns of the rigid unknowns that a point of a body and the object feel, and their number. Each column has its index, the
/// motion of the point relative to that of the object along it, and the turn of the object.
fn rigid_columns(view: &BodyView) -> ([(usize, DVec3, DVec3); 7], usize) {
    let mut columns = [(usize::MAX, DVec3::ZERO, DVec3::ZERO); 7];
    let mut count = 0;
    let mut push = |entry| {
        columns[count] = entry;
        count += 1;
    };
    if let Some(c) = view.travel_column {
        push((c, view.closing, DVec3::ZERO));
    }
    if let Some(c) = view.pose_column {
        for k in 0..3 {
            push((c + k, -DVec3::AXES[k], DVec3::ZERO));
        }
        for k in 0..3 {
            push((c + 3 + k, DVec3::ZERO, DVec3::AXES[k] / view.length));
        }
    }
    (columns, count)
}

/// Second derivatives `sum matrix_ij f_i f_j` in linear forms `f` of the motion of nodes and of a point of a body relative to the object.
#[derive(Debug, Clone)]
pub struct Form<const K: usize> {
    /// Contributions of the motion of each node to each form.
    pub nodes: Vec<(u32, [DVec3; K])>,
    /// Contributions of a motion of finger and object, by the relative displacement (m) that it makes.
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
    /// Creates a pair of a force alone: `force` is the gradient in the relative displacement (N), `r` the arm of the object's
    /// point (m).
    pub fn force(force: DVec3, r: DVec3) -> Self {
        Self { force, torque: -r.cross(force), dd: DMat3::ZERO, dw: DMat3::ZERO, ww: DMat3::ZERO }
    }
}

/// A material point of a body's surface: nodes and their shape function values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stencil {
    nodes: [u32; 6],
    phi: [f64; 6],
    len: u8,
}

impl Stencil {
    /// Stencil of no point.
    pub const NONE: Self = Self { nodes: [0; 6], phi: [0.0; 6], len: 0 };

    /// Creates a stencil from at most six nodes and weights; weights of zero are dropped.
    pub fn new(entries: impl Iterator<Item = (u32, f64)>) -> Self {
        let mut s = Self::NONE;
        for (node, phi) in entries.filter(|(_, phi)| *phi != 0.0).take(6) {
            s.nodes[s.len as usize] = node;
            s.phi[s.len as usize] = phi;
            s.len += 1;
        }
        s
    }

    /// Nodes and shape function values.
    #[inline]
    pub fn slices(&self) -> (&[u32], &[f64]) {
        (&self.nodes[..self.len as usize], &self.phi[..self.len as usize])
    }

    /// Position of the point for node positions `x`.
    #[inline]
    pub fn position(&self, x: &[DVec3]) -> DVec3 {
        let (nodes, phi) = self.slices();
        nodes.iter().zip(phi).fold(DVec3::ZERO, |s, (&n, &p)| s + x[n as usize] * p)
    }
}

/// Copies a term behind its trait object; every term that is `Clone` has it.
pub trait TermClone {
    /// Returns a copy with the same history.
    fn boxed_clone(&self) -> Box<dyn BodyTerm>;
}

impl<T: BodyTerm + Clone + 'static> TermClone for T {
    fn boxed_clone(&self) -> Box<dyn BodyTerm> {
        Box::new(self.clone())
    }
}

/// One physical effect on one body: value, gradient, Hessian, and what it must remember between accepted states.
pub trait BodyTerm: TermClone + Send + Sync {
    /// Energy, J; `+inf` where the state is not feasible. Quantities lagged by [`BodyTerm::assemble`] stay frozen.
    fn energy(&self, body: &Body, view: &BodyView) -> f64;
    /// Adds gradient and Hessian to `block`; refreshes lagged quantities. `project`: positive semidefinite parts only.
    fn assemble(&mut self, body: &Body, view: &BodyView, project: bool, block: &mut BodyBlock);
    /// Adds the change of the term's forces along a small `motion`, beyond what its (symmetric) Hessian says, to the gradients
    /// of `change`.
    fn couple(&self, _body: &Body, _view: &BodyView, _motion: &BodyMotion, _change: &mut BodyBlock) {}
    /// Begins an increment: the next solves depart from this accepted state.
    fn depart(&mut self, _from: &Departure) {}
    /// Begins a time step: the next solves are for its end.
    fn begin(&mut self, _step: &TimeStep) {}
    /// A distance that every point may move before the term must be looked at again, m.
    fn clearance(&self, _body: &Body, _view: &BodyView) -> f64 {
        f64::INFINITY
    }
    /// Takes over the history: the increment was accepted.
    fn commit(&mut self, _body: &Body, _view: &BodyView) {}
    /// Forgets what was learnt since the last commit: the increment was rejected.
    fn rollback(&mut self) {}
    /// Returns true if the converged state satisfies what the term promises beyond equilibrium (no penetration); if not, the
    /// term has strengthened itself and the solve goes on.
    fn satisfied(&mut self, _body: &Body, _view: &BodyView) -> bool {
        true
    }
    /// Sets the fraction `damping` by which lagged quantities move towards their goal in each assembly (1 = all the way).
    fn damp(&mut self, _damping: f64) {}
    /// Sets whether Hessians have all second derivatives, or leave out those that lead astray far from a solution.
    fn sharpen(&mut self, _sharp: bool) {}
    /// Returns the term for reading results back by type.
    fn as_any(&self) -> &dyn std::any::Any;
}

/// Elastic energy of the gel.
#[derive(Debug, Clone, Default)]
pub struct ElasticEnergy;

impl BodyTerm for ElasticEnergy {
    fn energy(&self, body: &Body, view: &BodyView) -> f64 {
        body.energy(view.x)
    }

    fn assemble(&mut self, body: &Body, view: &BodyView, project: bool, block: &mut BodyBlock) {
        match block.hessian {
            true => body.add_stiffness(view.x, project, &mut block.gradient, &mut block.values),
            false => body.add_gradient(view.x, &mut block.gradient),
        }
    }

    fn as_any(&self) -> &dyn std::any::Any {
        self
    }
}

/// Dead loads on nodes: potential `-sum f . x`.
#[derive(Debug, Clone)]
pub struct DeadLoad(pub Vec<DVec3>);

impl BodyTerm for DeadLoad {
    fn energy(&self, _: &Body, view: &BodyView) -> f64 {
        -self.0.iter().zip(view.x).map(|(f, x)| f.dot(*x)).sum::<f64>()
    }

    fn assemble(&mut self, _: &Body, _: &BodyView, _: bool, block: &mut BodyBlock) {
        for (g, f) in block.gradient.iter_mut().zip(&self.0) {
            *g -= *f;
        }
    }

    fn as_any(&self) -> &dyn std::any::Any {
        self
    }
}
