//! Every energy has the gradient and the Hessian it claims: differences of high order, to 1e-7 of the largest entry.

mod common;

use common::{Random, elements};
use glam::{DMat3, DVec3};
use std::sync::Arc;
use tactus::contact::{Contact, ContactSurface, law::Law};
use tactus::element::{Kernel, RestTet, Shape, TET4, TET10};
use tactus::fem::body::Body;
use tactus::fem::state::{Border, MAX_BORDER, State, Step};
use tactus::fem::term::{Block, BodyTerm, DeadLoad, Elastic};
use tactus::material::{Dilatation, FixedCorotated, Linear, Material, NeoHookean, Tangent};
use tactus::mesh::TetMesh;
use tactus::shape::{SignedDistance, ellipsoid::Ellipsoid, sphere::Sphere};

/// Every law is tested by every test of this file. A new law is one line here.
fn laws() -> Vec<Arc<dyn Material>> {
    vec![
        Arc::new(NeoHookean::new(3.0, 0.45)),
        Arc::new(FixedCorotated::new(3.0, 0.45)),
        Arc::new(Linear::new(3.0, 0.45)),
    ]
}

/// Relative to the largest entry.
const TOLERANCE: f64 = 1e-7;

/// Derivative at 0 of `f`, by central differences of fourth order.
fn slope(step: f64, f: impl Fn(f64) -> f64) -> f64 {
    (8.0 * (f(step) - f(-step)) - (f(2.0 * step) - f(-2.0 * step))) / (12.0 * step)
}

/// Second derivative at 0 of `f`, sixth order.
fn bend(step: f64, f: impl Fn(f64) -> f64) -> f64 {
    let pair = |k: f64| f(k * step) + f(-k * step);
    (270.0 * pair(1.0) - 27.0 * pair(2.0) + 2.0 * pair(3.0) - 490.0 * f(0.0)) / (180.0 * step * step)
}

/// Largest difference over the largest entry of `b`, and of `floor`.
fn deviation(a: &[f64], b: &[f64], floor: f64) -> f64 {
    assert_eq!(a.len(), b.len());
    let scale = b.iter().fold(floor, |m, v| m.max(v.abs()));
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / scale
}

/// The deformation gradients a law is tested at: (name, strain, F with det F > 0.1, rotated).
fn gradients() -> Vec<(String, f64, DMat3)> {
    let mut random = Random(1);
    let mut list = Vec::new();
    for (name, strain) in [("near identity", 1e-3), ("small", 2e-2), ("moderate", 0.2), ("large", 0.6)] {
        let mut count = 0;
        while count < 6 {
            let f = DMat3::IDENTITY + random.matrix() * strain;
            let turned = DMat3::from_quat(random.rotation()) * f;
            if f.determinant() > 0.2 {
                // Half of them turned by a large rotation.
                list.push((format!("{name} {count}"), strain, if count % 2 == 0 { f } else { turned }));
                count += 1;
            }
        }
    }
    list
}

/// `f` with entry `c` (column-major) changed by `d`.
fn changed(f: &DMat3, c: usize, d: f64) -> DMat3 {
    let mut entries = f.to_cols_array();
    entries[c] += d;
    DMat3::from_cols_array(&entries)
}

/// Steps are powers of two, so that `x + step` is exact, and a fraction of the strain.
fn step_for(strain: f64) -> f64 {
    if strain < 0.01 { 2f64.powi(-12) } else { 2f64.powi(-9) }
}

#[test]
fn stress_is_the_gradient_of_the_distortional_energy_and_the_tangent_that_of_the_stress() {
    for law in laws() {
        for (name, strain, f) in gradients() {
            let h = step_for(strain);
            let stress = law.distortional_stress(&f).to_cols_array();
            let numeric: [f64; 9] = std::array::from_fn(|c| slope(h, |d| law.distortional_energy(&changed(&f, c, d))));
            // A stress of E * strain is what this F can cause; rotations alone cause none.
            let error = deviation(&numeric, &stress, law.young() * strain);
            assert!(error < TOLERANCE, "{}, {name}: stress off by {error:.1e}", law.name());

            let tangent = law.distortional_tangent(&f);
            let column =
                |b: usize, a: usize| slope(h, |d| law.distortional_stress(&changed(&f, b, d)).to_cols_array()[a]);
            let numeric: Vec<f64> = (0..81).map(|k| column(k % 9, k / 9)).collect();
            let error = deviation(&numeric, &tangent.concat(), 0.0);
            assert!(error < TOLERANCE, "{}, {name}: tangent off by {error:.1e}", law.name());
            for (a, b) in (0..9).flat_map(|a| (0..a).map(move |b| (a, b))) {
                let asymmetry = (tangent[a][b] - tangent[b][a]).abs();
                assert!(asymmetry < 1e-12 * law.young(), "{}, {name}: asymmetric by {asymmetry:.1e}", law.name());
            }
        }
    }
}

#[test]
fn volumetric_energy_has_its_pressure_and_modulus() {
    for law in laws() {
        for theta in [-0.7, -0.2, -1e-3, 0.0, 1e-3, 0.3, 1.5] {
            let h = 2f64.powi(-9);
            let [_, pressure, modulus] = law.volumetric(theta);
            let numeric = [slope(h, |d| law.volumetric(theta + d)[0]), slope(h, |d| law.volumetric(theta + d)[1])];
            let error = (numeric[0] - pressure).abs().max((numeric[1] - modulus).abs()) / modulus;
            assert!(error < TOLERANCE, "{} at theta = {theta}: {error:.1e} of the modulus", law.name());
        }
        assert_eq!(law.volumetric(0.0)[..2], [0.0, 0.0], "{}: no energy and no pressure at rest", law.name());
    }
}

#[test]
fn dilatations_have_their_gradient_and_hessian() {
    for kind in [Dilatation::Determinant, Dilatation::Trace] {
        for (name, _, f) in gradients() {
            let h = 2f64.powi(-8);
            let numeric: [f64; 9] = std::array::from_fn(|c| slope(h, |d| kind.value(&changed(&f, c, d))));
            let error = deviation(&numeric, &kind.gradient(&f).to_cols_array(), 0.0);
            assert!(error < TOLERANCE, "{kind:?}, {name}: gradient off by {error:.1e}");
            let mut hessian: Tangent = [[0.5; 9]; 9];
            kind.add_hessian(&f, 3.0, &mut hessian);
            let column = |b: usize, a: usize| slope(h, |d| kind.gradient(&changed(&f, b, d)).to_cols_array()[a]);
            let numeric: Vec<f64> = (0..81).map(|k| 0.5 + 3.0 * column(k % 9, k / 9)).collect();
            let error = deviation(&numeric, &hessian.concat(), 0.0);
            assert!(error < TOLERANCE, "{kind:?}, {name}: hessian off by {error:.1e}");
        }
    }
}

/// Checks one element type under one law, with and without mean dilatation.
fn check_element<const N: usize, const Q: usize>(shape: &Shape<N, Q>, law: &dyn Material) {
    let mut random = Random(N as u64);
    // A crooked tetrahedron; mid-edge nodes where they belong.
    let corners = [[0.1, 0.0, -0.1], [1.1, 0.2, 0.1], [0.2, 0.9, 0.0], [0.3, 0.1, 1.2]].map(DVec3::from_array);
    let rest = RestTet::new(corners);
    let straight: [DVec3; N] = std::array::from_fn(|a| match a.checked_sub(4) {
        None => corners[a],
        Some(e) => (corners[tactus::element::EDGES[e][0]] + corners[tactus::element::EDGES[e][1]]) * 0.5,
    });
    for mean_dilatation in [false, true] {
        for (strain, trial) in [(1e-2, 0), (0.1, 1), (0.1, 2), (0.2, 3)] {
            let what = format!("{}, {N} nodes, mean dilatation {mean_dilatation}, case {trial}", law.name());
            let kernel = Kernel { shape, material: law, mean_dilatation };
            let turn = random.rotation();
            let x = straight.map(|p| turn * (p + random.vector() * strain) + DVec3::new(1.0, 2.0, 3.0));
            assert!(kernel.energy(&rest, &x).is_finite(), "{what}");
            let moved = |c: usize, d: f64| {
                let mut x = x;
                x[c / 3][c % 3] += d;
                x
            };
            let gradient_at = |x: &[DVec3; N]| {
                let mut g = [DVec3::ZERO; N];
                kernel.add_gradient(&rest, x, &mut g);
                g
            };
            let h = 2f64.powi(-10);
            let gradient = gradient_at(&x);
            let flat: Vec<f64> = gradient.iter().flat_map(|g| g.to_array()).collect();
            let numeric: Vec<f64> = (0..3 * N).map(|c| slope(h, |d| kernel.energy(&rest, &moved(c, d)))).collect();
            let error = deviation(&numeric, &flat, 0.0);
            assert!(error < TOLERANCE, "{what}: gradient off by {error:.1e}");

            for project in [false, true] {
                let (mut again, mut blocks) = ([DVec3::ZERO; N], [[DMat3::ZERO; N]; N]);
                kernel.stiffness(&rest, &x, project, &mut again, &mut blocks);
                let difference = again.iter().zip(&gradient).map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max);
                assert!(difference < 1e-12 * law.young(), "{what}: two gradients");
                let entry = |r: usize, c: usize| {
                    let (r, c) = if r / 3 <= c / 3 { (r, c) } else { (c, r) };
                    blocks[r / 3][c / 3].col(c % 3)[r % 3]
                };
                let stiffness: Vec<f64> = (0..9 * N * N).map(|k| entry(k / (3 * N), k % (3 * N))).collect();
                if project {
                    assert_positive(&what, 3 * N, &stiffness);
                    continue;
                }
                let column = |c: usize, r: usize| slope(h, |d| gradient_at(&moved(c, d))[r / 3][r % 3]);
                let numeric: Vec<f64> = (0..9 * N * N).map(|k| column(k % (3 * N), k / (3 * N))).collect();
                let error = deviation(&numeric, &stiffness, 0.0);
                assert!(error < TOLERANCE, "{what}: stiffness off by {error:.1e}");
            }
        }
    }
}

/// No eigenvalue below -1e-10 of the largest.
fn assert_positive(what: &str, n: usize, matrix: &[f64]) {
    let matrix = faer::Mat::<f64>::from_fn(n, n, |i, j| matrix[n * i + j]);
    let eigen = matrix.self_adjoint_eigenvalues(faer::Side::Lower).expect("eigenvalues");
    let (low, high) = (eigen[0], eigen[n - 1]);
    assert!(low >= -1e-10 * high, "{what}: the projected Hessian has the eigenvalue {low:.2e}, largest {high:.2e}");
}

#[test]
fn nodal_forces_are_the_gradient_of_the_element_energy_and_the_stiffness_that_of_the_forces() {
    for law in laws() {
        check_element(&TET4, law.as_ref());
        check_element(&TET10, law.as_ref());
    }
}

/// A block with two fixed nodes, one finger whose travel is an unknown, and a free object: every coordinate there is.
struct Scene {
    body: Body,
    border: Border,
    state: State,
}

impl Scene {
    fn new(quadratic: bool, random: &mut Random) -> Self {
        let corners = [[-1.0, -1.0, 0.0], [1.0, -0.9, 0.1], [0.1, 1.0, -0.1], [0.0, 0.1, -1.0], [0.1, 0.2, 1.1]];
        let mesh = TetMesh { nodes: corners.map(DVec3::from_array).to_vec(), tets: vec![[0, 2, 1, 3], [0, 1, 2, 4]] };
        let (rest, elements) = elements(&mesh, quadratic);
        let fixed = (0..rest.len()).map(|i| i == 3 || i == 8).collect();
        let body = Body::new(rest, elements, fixed, laws().remove(0), true).expect("body");
        let border = Border::new(vec![DVec3::new(0.6, 0.0, 0.8)], true, true, 0.7);
        let x = body.rest.iter().map(|p| *p + random.vector() * 0.05).collect();
        let position = DVec3::new(0.3, -0.2, 1.2) + random.vector() * 0.2;
        let state = State { x: vec![x], travel: vec![0.1], position, rotation: random.rotation() };
        Self { body, border, state }
    }

    /// Number of coordinates: every node, free or fixed, then the border.
    fn size(&self) -> usize {
        3 * self.body.rest.len() + self.border.size
    }

    /// Moves coordinate `a` by `d` and `b` by `e`, as the solver would.
    fn moved(&self, a: usize, d: f64, b: usize, e: f64) -> State {
        let n = 3 * self.body.rest.len();
        let mut step = Step { x: vec![vec![DVec3::ZERO; n / 3]], border: [0.0; MAX_BORDER] };
        for (c, by) in [(a, d), (b, e)] {
            if c < n { step.x[0][c / 3][c % 3] += by } else { step.border[c - n] += by }
        }
        self.state.moved(&self.border, &step, 1.0)
    }

    fn energy(&self, term: &dyn BodyTerm, state: &State) -> f64 {
        term.energy(&self.body, &state.view(0, &self.border))
    }

    fn assemble(&self, term: &mut dyn BodyTerm, project: bool) -> Block {
        let mut block = Block::new(&self.body, self.border.size);
        term.assemble(&self.body, &self.state.view(0, &self.border), project, &mut block);
        block
    }

    /// Gradient in all coordinates.
    fn gradient(&self, block: &Block) -> Vec<f64> {
        let nodes = block.gradient.iter().flat_map(|g| g.to_array());
        nodes.chain(block.border_gradient[..self.border.size].iter().copied()).collect()
    }

    /// Coordinates that are unknowns: those of free nodes and the border.
    fn unknowns(&self) -> Vec<usize> {
        let n = 3 * self.body.rest.len();
        (0..self.size()).filter(|c| *c >= n || !self.body.fixed[c / 3]).collect()
    }

    /// Hessian between all unknowns, row-major.
    fn hessian(&self, block: &Block) -> Vec<f64> {
        let (n, pattern) = (3 * self.body.rest.len(), &self.body.pattern);
        let row = |c: usize| 3 * pattern.position[c / 3] as usize + c % 3;
        let inner = |a: usize, b: usize| {
            let (r, c) = (row(a).max(row(b)), row(a).min(row(b)));
            let range = pattern.col_ptr[c]..pattern.col_ptr[c + 1];
            pattern.row_idx[range.clone()].binary_search(&r).map_or(0.0, |k| block.values[range.start + k])
        };
        let entry = |a: usize, b: usize| match (a.checked_sub(n), b.checked_sub(n)) {
            (None, None) => inner(a, b),
            (Some(a), None) => block.coupling[a * pattern.unknowns() + row(b)],
            (None, Some(b)) => block.coupling[b * pattern.unknowns() + row(a)],
            (Some(a), Some(b)) => block.border_hessian[a][b],
        };
        let unknowns = self.unknowns();
        unknowns.iter().flat_map(|a| unknowns.iter().map(move |b| entry(*a, *b))).collect()
    }

    /// Gradient and Hessian of a term against differences of its energy, with what it lags frozen by one assembly. With
    /// `project`, the projected Hessian must be positive semidefinite and the gradient the same.
    fn check(&self, what: &str, term: &mut dyn BodyTerm) {
        let unknowns = self.unknowns();
        let projected = self.assemble(term, true);
        assert_positive(what, unknowns.len(), &self.hessian(&projected));
        let block = self.assemble(term, false);
        let gradient = self.gradient(&block);
        assert!(
            deviation(&self.gradient(&projected), &gradient, 0.0) < 1e-13,
            "{what}: projection changes the gradient"
        );
        let h = 2f64.powi(-9);
        let energy = |a, d, b, e| self.energy(term, &self.moved(a, d, b, e));
        let numeric: Vec<f64> = (0..self.size()).map(|c| slope(h, |d| energy(c, d, c, 0.0))).collect();
        let error = deviation(&numeric, &gradient, 0.0);
        assert!(error < TOLERANCE, "{what}: gradient off by {error:.1e}");
        // 2 H_ab = E'' along a + b minus E'' along a and along b.
        let along: Vec<f64> = unknowns.iter().map(|&a| bend(h, |d| energy(a, d, a, 0.0))).collect();
        let mut numeric = Vec::new();
        for (i, &a) in unknowns.iter().enumerate() {
            for (j, &b) in unknowns.iter().enumerate() {
                let mixed = || 0.5 * (bend(h, |d| energy(a, d, b, d)) - along[i] - along[j]);
                numeric.push(if i == j { along[i] } else { mixed() });
            }
        }
        let hessian = self.hessian(&block);
        let error = deviation(&numeric, &hessian, 0.0);
        assert!(error < TOLERANCE, "{what}: Hessian off by {error:.1e}");
    }
}

#[test]
fn elastic_energy_and_dead_loads_have_their_derivatives_in_the_solvers_storage() {
    let mut random = Random(5);
    for quadratic in [false, true] {
        let scene = Scene::new(quadratic, &mut random);
        scene.check("elastic", &mut Elastic);
        let load = (0..scene.body.rest.len()).map(|_| random.vector()).collect();
        let mut term = DeadLoad(load);
        let gradient = scene.gradient(&scene.assemble(&mut term, false));
        let slope_at = |c| slope(0.25, |d| scene.energy(&term, &scene.moved(c, d, c, 0.0)));
        let numeric: Vec<f64> = (0..scene.size()).map(slope_at).collect();
        assert!(deviation(&numeric, &gradient, 0.0) < 1e-12, "dead load");
    }
}

/// Runs the contact check on random scenes with no point within reach of a change of its state (touch, slip), where the
/// second derivative jumps. `friction` is the coefficient, `drag` the motion after sticking, m; returns the numbers of touching
/// and slipping points checked.
fn check_contact(friction: f64, drag: f64) -> (usize, usize) {
    let objects: [Arc<dyn SignedDistance>; 2] =
        [Arc::new(Sphere { radius: 0.8 }), Arc::new(Ellipsoid { semi: DVec3::new(0.9, 0.7, 0.8) })];
    let (mut touching, mut slipping) = (0, 0);
    for (seed, object) in (0..24).flat_map(|s| objects.iter().map(move |o| (s, o))) {
        let mut random = Random(seed);
        let mut scene = Scene::new(seed % 2 == 1, &mut random);
        let surface = Arc::new(ContactSurface::new(&scene.body));
        let law = Law { stiffness: 4.0, offset: 0.01, friction, tangential: 3.0 };
        let mut contact = Contact::new(law, surface, object.clone());
        // Stick here and keep multipliers, then move on.
        scene.assemble(&mut contact, false);
        contact.commit(&scene.body, &scene.state.view(0, &scene.border));
        let n = 3 * scene.body.rest.len();
        for c in 0..scene.size() {
            let by = random.number() * if c < n { 0.2 * drag } else { drag };
            scene.state = scene.moved(c, by, c, 0.0);
        }
        scene.assemble(&mut contact, false);
        // Three steps of 2^-9 in each of two coordinates move a point by less than 0.03.
        let margin = 0.03;
        let kink = contact.edges.iter().any(|e| {
            let trial = e.lambda_hand - slip_of(&scene, &contact, e) * law.tangential;
            let to_slip = (trial.length() - friction * e.pressure).abs() / law.tangential;
            let touches = e.pressure > 0.0;
            (e.gap - law.reach(e.lambda)).abs() < margin || (friction > 0.0 && touches && to_slip < margin)
        });
        if kink || !contact.edges.iter().any(|e| e.pressure > 0.0) {
            continue;
        }
        touching += contact.edges.iter().filter(|e| e.pressure > 0.0).count();
        slipping += contact.edges.iter().filter(|e| e.pressure > 0.0 && e.slips).count();
        scene.check(&format!("contact, friction {friction}, seed {seed}, {object:?}"), &mut contact);
    }
    (touching, slipping)
}

/// Slip of an edge against its anchor, m.
fn slip_of(scene: &Scene, contact: &Contact, edge: &tactus::contact::ContactEdge) -> DVec3 {
    let Some(anchor) = edge.anchor else { return DVec3::ZERO };
    let index = contact.edges.iter().position(|e| std::ptr::eq(e, edge)).expect("an edge of this term");
    let view = scene.state.view(0, &scene.border);
    let point = contact.surface().points[index].position(view.x) + view.offset;
    let s = point - view.position - view.rotation * anchor;
    s - edge.normal * edge.normal.dot(s)
}

/// Exact Hessian including the curvature of the object and the second order of the rotation `exp(w) R` at `w = 0`.
#[test]
fn contact_pressure_has_its_derivatives_in_nodes_travel_and_pose() {
    let (touching, _) = check_contact(0.0, 0.05);
    assert!(touching > 50, "only {touching} touching points were checked");
}

/// The limit `mu p` and the normal are lagged by design: assembly freezes them, and gradient and Hessian are those of the frozen
/// potential, which `energy` returns until the next assembly. That the true friction force also changes with the pressure is left to
/// the next iteration.
#[test]
fn sticking_friction_has_its_derivatives_in_nodes_travel_and_pose() {
    let (touching, slipping) = check_contact(5.0, 0.03);
    assert!(touching > 50 && slipping == 0, "{touching} touching, {slipping} slipping points were checked");
}

#[test]
fn slipping_friction_has_its_derivatives_in_nodes_travel_and_pose() {
    let (_, slipping) = check_contact(0.05, 0.2);
    assert!(slipping > 50, "only {slipping} slipping points were checked");
}
