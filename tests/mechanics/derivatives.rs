//! Gradients and Hessians of every energy against finite differences of high order, to 1e-7 of the largest entry.

use crate::common::{Random, elements};
use glam::{DMat3, DQuat, DVec3};
use std::sync::Arc;
use tactus::backend::fem::condensed::CondensedEnergy;
use tactus::geometry::Pose;
use tactus::geometry::mesh::TetMesh;
use tactus::geometry::shape::cuboid::Cuboid;
use tactus::geometry::shape::ellipsoid::Ellipsoid;
use tactus::geometry::shape::sphere::Sphere;
use tactus::geometry::shape::{MassProperties, SignedDistance};
use tactus::mech::body::{Body, Elements};
use tactus::mech::contact::law::ContactLaw;
use tactus::mech::contact::surface::{SurfaceFace, face_frame};
use tactus::mech::contact::{ContactSurface, ContactVertex, EdgeState, GroundContact, PointContact, VertexContact};
use tactus::mech::element::{Kernel, RestTet, ShapeFunctions, Stiffness, TET4, TET10};
use tactus::mech::material::{Dilatation, FixedCorotated, Linear, Material, NeoHookean, Tangent};
use tactus::mech::potential::block::BodyBlock;
use tactus::mech::potential::drive::Drive;
use tactus::mech::potential::inversion_barrier::inversion_barrier;
use tactus::mech::potential::pad_inertia::PadInertia;
use tactus::mech::potential::point_load::PointLoad;
use tactus::mech::potential::rigid_inertia::RigidInertia;
use tactus::mech::potential::state::{BodyView, IncrementStart, MAX_RIGID, NewtonStep, RigidUnknowns, State};
use tactus::mech::potential::term::{Assembly, BodyTerm, ElasticEnergy, NodalLoads, ObjectTerm, Stencil};
use tactus::mech::potential::time_step::TimeStep;
use tactus::mech::potential::viscosity::Viscosity;

/// All material laws; the tests of laws and elements run for each of them.
fn laws() -> Vec<Arc<dyn Material>> {
    vec![
        Arc::new(NeoHookean::new(3.0, 0.45)),
        Arc::new(FixedCorotated::new(3.0, 0.45)),
        Arc::new(Linear::new(3.0, 0.45)),
    ]
}

/// Largest error allowed, relative to the largest entry.
const TOLERANCE: f64 = 1e-7;

/// Returns the derivative of `f` at 0 by central differences of fourth order.
fn slope(step: f64, f: impl Fn(f64) -> f64) -> f64 {
    (8.0 * (f(step) - f(-step)) - (f(2.0 * step) - f(-2.0 * step))) / (12.0 * step)
}

/// Returns the second derivative of `f` at 0 by central differences of sixth order.
fn bend(step: f64, f: impl Fn(f64) -> f64) -> f64 {
    let pair = |k: f64| f(k * step) + f(-k * step);
    (270.0 * pair(1.0) - 27.0 * pair(2.0) + 2.0 * pair(3.0) - 490.0 * f(0.0)) / (180.0 * step * step)
}

/// Returns the largest difference relative to the largest magnitude in `b`, or to `floor` if that is larger.
fn deviation(a: &[f64], b: &[f64], floor: f64) -> f64 {
    assert_eq!(a.len(), b.len());
    let scale = b.iter().fold(floor, |m, v| m.max(v.abs()));
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / scale
}

/// Deformation gradients at which a law is tested: (name, strain, F with det F > 0.2).
fn gradients() -> Vec<(String, f64, DMat3)> {
    let mut random = Random(1);
    let mut list = Vec::new();
    for (name, strain) in [("near identity", 1e-3), ("small", 2e-2), ("moderate", 0.2), ("large", 0.6)] {
        let mut count = 0;
        while count < 6 {
            let f = DMat3::IDENTITY + random.matrix() * strain;
            let turned = DMat3::from_quat(random.rotation()) * f;
            if f.determinant() > 0.2 {
                // Every second one is followed by a large rotation.
                list.push((format!("{name} {count}"), strain, if count % 2 == 0 { f } else { turned }));
                count += 1;
            }
        }
    }
    list
}

/// Returns `f` with `d` added to entry `c` (column-major).
fn changed(f: &DMat3, c: usize, d: f64) -> DMat3 {
    let mut entries = f.to_cols_array();
    entries[c] += d;
    DMat3::from_cols_array(&entries)
}

/// Finite-difference step: a fraction of the strain, and a power of two to limit the rounding of `x + step`.
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
            // `E * strain` is the order of magnitude of the stress; it scales the error where the stress is small.
            let error = deviation(&numeric, &stress, law.moduli().young * strain);
            assert!(error < TOLERANCE, "{}, {name}: stress off by {error:.1e}", law.name());

            let tangent = law.distortional_tangent(&f);
            let column =
                |b: usize, a: usize| slope(h, |d| law.distortional_stress(&changed(&f, b, d)).to_cols_array()[a]);
            let numeric: Vec<f64> = (0..81).map(|k| column(k % 9, k / 9)).collect();
            let error = deviation(&numeric, &tangent.concat(), 0.0);
            assert!(error < TOLERANCE, "{}, {name}: tangent off by {error:.1e}", law.name());
            for (a, b) in (0..9).flat_map(|a| (0..a).map(move |b| (a, b))) {
                let asymmetry = (tangent[a][b] - tangent[b][a]).abs();
                assert!(
                    asymmetry < 1e-12 * law.moduli().young,
                    "{}, {name}: asymmetric by {asymmetry:.1e}",
                    law.name()
                );
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

/// Checks gradient and stiffness of one element type with one law, with and without mean dilatation.
fn check_element<const N: usize, const Q: usize>(shape: &ShapeFunctions<N, Q>, law: &dyn Material) {
    let mut random = Random(N as u64);
    // An irregular tetrahedron with straight edges: mid-edge nodes at the midpoints.
    let corners = [[0.1, 0.0, -0.1], [1.1, 0.2, 0.1], [0.2, 0.9, 0.0], [0.3, 0.1, 1.2]].map(DVec3::from_array);
    let rest = RestTet::new(corners);
    let straight: [DVec3; N] = std::array::from_fn(|a| match a.checked_sub(4) {
        None => corners[a],
        Some(e) => (corners[tactus::mech::element::EDGES[e][0]] + corners[tactus::mech::element::EDGES[e][1]]) * 0.5,
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
                let mut sum = Stiffness::default();
                kernel.stiffness([&rest], &[x], project, &mut sum);
                let difference =
                    sum.gradient[0].iter().zip(&gradient).map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max);
                assert!(difference < 1e-12 * law.moduli().young, "{what}: two gradients");
                let entry = |r: usize, c: usize| {
                    let (r, c) = if r / 3 <= c / 3 { (r, c) } else { (c, r) };
                    sum.block(0, r / 3, c / 3).col(c % 3)[r % 3]
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

/// Gradient and stiffness of an element have the same bits when it is evaluated alone and in a batch.
#[test]
fn stiffness_does_not_depend_on_the_elements_beside() {
    let mut random = Random(11);
    let corners = [[0.1, 0.0, -0.1], [1.1, 0.2, 0.1], [0.2, 0.9, 0.0], [0.3, 0.1, 1.2]].map(DVec3::from_array);
    let rest = RestTet::new(corners);
    let straight: [DVec3; 10] = std::array::from_fn(|a| match a.checked_sub(4) {
        None => corners[a],
        Some(e) => corners[tactus::mech::element::EDGES[e][0]].midpoint(corners[tactus::mech::element::EDGES[e][1]]),
    });
    for law in laws() {
        let kernel = Kernel { shape: &TET10, material: law.as_ref(), mean_dilatation: true };
        let x: [[DVec3; 10]; 5] = std::array::from_fn(|_| straight.map(|p| p + random.vector() * 0.05));
        let mut beside = Stiffness::default();
        kernel.stiffness([&rest; 5], &x, false, &mut beside);
        for l in 0..5 {
            let mut alone = Stiffness::default();
            kernel.stiffness([&rest], &[x[l]], false, &mut alone);
            assert_eq!(alone.gradient[0], beside.gradient[l], "{}: N", law.name());
            for (a, b) in (0..10).flat_map(|a| (a..10).map(move |b| (a, b))) {
                assert_eq!(alone.block(0, a, b), beside.block(l, a, b), "{}, nodes {a} and {b}: N/m", law.name());
            }
        }
    }
}

/// Asserts that no eigenvalue is below -1e-10 of the largest.
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

/// Two tetrahedra with fixed nodes, one finger whose travel is an unknown, and a free object: every kind of coordinate.
struct Scene {
    body: Body,
    rigid: RigidUnknowns,
    state: State,
}

impl Scene {
    fn new(quadratic: bool, random: &mut Random) -> Self {
        let corners = [[-1.0, -1.0, 0.0], [1.0, -0.9, 0.1], [0.1, 1.0, -0.1], [0.0, 0.1, -1.0], [0.1, 0.2, 1.1]];
        let mesh = TetMesh { nodes: corners.map(DVec3::from_array).to_vec(), tets: vec![[0, 2, 1, 3], [0, 1, 2, 4]] };
        let (rest, elements) = elements(&mesh, quadratic);
        let fixed = (0..rest.len()).map(|i| i == 3 || i == 8).collect();
        let body = Body::new(rest, elements, fixed, laws().remove(0), true);
        let rigid = RigidUnknowns::new(vec![DVec3::new(0.6, 0.0, 0.8)], true, true, 0.7);
        let x = body.rest.iter().map(|p| *p + random.vector() * 0.05).collect();
        let position = DVec3::new(0.3, -0.2, 1.2) + random.vector() * 0.2;
        let state = State { x: vec![x], travel: vec![0.1], position, rotation: random.rotation() };
        Self { body, rigid, state }
    }

    /// Returns the state as the start of an increment, over the time step `step` if there is one.
    fn increment_start(&self, step: Option<TimeStep>) -> IncrementStart {
        IncrementStart::new(Arc::new(self.state.clone()), 0, &self.rigid, step)
    }

    /// Moves every coordinate at random by up to `drag`, those of nodes by up to a fifth of it.
    fn shake(&mut self, drag: f64, random: &mut Random) {
        let n = 3 * self.body.rest.len();
        for c in 0..self.size() {
            let by = random.number() * if c < n { 0.2 * drag } else { drag };
            self.state = self.moved(c, by, c, 0.0);
        }
    }

    /// Number of coordinates: those of all nodes, free or fixed, then the rigid unknowns.
    fn size(&self) -> usize {
        3 * self.body.rest.len() + self.rigid.size
    }

    /// Returns the state with coordinate `a` moved by `d` and `b` by `e`, with the solver's update.
    fn moved(&self, a: usize, d: f64, b: usize, e: f64) -> State {
        self.state.moved(&self.rigid, &self.step(a, d, b, e), 1.0)
    }

    /// Returns the step that moves coordinate `a` by `d` and `b` by `e`.
    fn step(&self, a: usize, d: f64, b: usize, e: f64) -> NewtonStep {
        let n = 3 * self.body.rest.len();
        let mut step = NewtonStep { x: vec![vec![DVec3::ZERO; n / 3]], rigid: [0.0; MAX_RIGID] };
        for (c, by) in [(a, d), (b, e)] {
            if c < n { step.x[0][c / 3][c % 3] += by } else { step.rigid[c - n] += by }
        }
        step
    }

    fn energy(&self, term: &dyn BodyTerm, state: &State) -> f64 {
        term.energy(&self.body, &state.view(0, &self.rigid))
    }

    fn assemble(&self, term: &mut dyn BodyTerm, how: Assembly) -> BodyBlock {
        let mut block = BodyBlock::new(&self.body, self.rigid.size);
        term.assemble(&self.body, &self.state.view(0, &self.rigid), how, &mut block);
        block
    }

    /// Returns the gradient with respect to all coordinates.
    fn gradient(&self, block: &BodyBlock) -> Vec<f64> {
        let nodes = block.gradient.iter().flat_map(|g| g.to_array());
        nodes.chain(block.rigid.gradient[..self.rigid.size].iter().copied()).collect()
    }

    /// Returns the coordinates that are unknowns: those of free nodes and the rigid unknowns.
    fn unknowns(&self) -> Vec<usize> {
        let n = 3 * self.body.rest.len();
        (0..self.size()).filter(|c| *c >= n || !self.body.fixed[c / 3]).collect()
    }

    /// Returns the Hessian with respect to all unknowns, row-major.
    fn hessian(&self, block: &BodyBlock) -> Vec<f64> {
        let (n, pattern) = (3 * self.body.rest.len(), self.body.pattern());
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
            (Some(a), Some(b)) => block.rigid.hessian[a][b],
        };
        let unknowns = self.unknowns();
        unknowns.iter().flat_map(|a| unknowns.iter().map(move |b| entry(*a, *b))).collect()
    }

    /// Returns the finite-difference Hessian of `energy` with respect to the coordinates `columns`, row-major.
    fn second_differences(&self, columns: &[usize], energy: &dyn Fn(&State) -> f64) -> Vec<f64> {
        let h = STEP;
        let at = |a, d, b, e| energy(&self.moved(a, d, b, e));
        // 2 H_ab = E'' along a + b minus E'' along a and along b.
        let along: Vec<f64> = columns.iter().map(|&a| bend(h, |d| at(a, d, a, 0.0))).collect();
        let mut numeric = vec![0.0; columns.len() * columns.len()];
        for (i, &a) in columns.iter().enumerate() {
            for (j, &b) in columns.iter().enumerate().take(i + 1) {
                let mixed = || 0.5 * (bend(h, |d| at(a, d, b, d)) - along[i] - along[j]);
                let value = if i == j { along[i] } else { mixed() };
                (numeric[i * columns.len() + j], numeric[j * columns.len() + i]) = (value, value);
            }
        }
        numeric
    }

    /// Checks the gradient of a term against differences of its energy; one assembly fixes its lagged quantities.
    fn check_gradient(&self, what: &str, term: &mut dyn BodyTerm) {
        let gradient = self.gradient(&self.assemble(term, Assembly::COMPLETE));
        let energy = |c, d| self.energy(term, &self.moved(c, d, c, 0.0));
        let numeric: Vec<f64> = (0..self.size()).map(|c| slope(STEP, |d| energy(c, d))).collect();
        let error = deviation(&numeric, &gradient, 0.0);
        assert!(error < TOLERANCE, "{what}: gradient off by {error:.1e}");
    }

    /// Checks gradient and Hessian. Projection must give a positive semidefinite Hessian and the same gradient.
    fn check(&self, what: &str, term: &mut dyn BodyTerm) {
        let unknowns = self.unknowns();
        let projected = self.assemble(term, Assembly::PROJECTED);
        assert_positive(what, unknowns.len(), &self.hessian(&projected));
        self.check_gradient(what, term);
        let block = self.assemble(term, Assembly::COMPLETE);
        let difference = deviation(&self.gradient(&projected), &self.gradient(&block), 0.0);
        assert!(difference < 1e-13, "{what}: projection changes the gradient");
        let numeric = self.second_differences(&unknowns, &|state| self.energy(term, state));
        let error = deviation(&numeric, &self.hessian(&block), 0.0);
        assert!(error < TOLERANCE, "{what}: Hessian off by {error:.1e}");
    }
}

#[test]
fn elastic_energy_and_dead_loads_have_their_derivatives_in_the_solvers_storage() {
    let mut random = Random(5);
    for quadratic in [false, true] {
        let scene = Scene::new(quadratic, &mut random);
        scene.check("elastic", &mut ElasticEnergy);
        let load = (0..scene.body.rest.len()).map(|_| random.vector()).collect();
        let mut term = NodalLoads(load);
        let gradient = scene.gradient(&scene.assemble(&mut term, Assembly::COMPLETE));
        let slope_at = |c| slope(0.25, |d| scene.energy(&term, &scene.moved(c, d, c, 0.0)));
        let numeric: Vec<f64> = (0..scene.size()).map(slope_at).collect();
        assert!(deviation(&numeric, &gradient, 0.0) < 1e-12, "dead load");
    }
}

#[test]
fn barriers_of_crushed_elements_have_their_derivatives() {
    let mut random = Random(7);
    let mut scene = Scene::new(true, &mut random);
    let (nodes, centers) = inversion_barrier();
    let mut terms: [Box<dyn BodyTerm>; 2] = [Box::new(nodes), Box::new(centers)];
    for term in &mut terms {
        assert!(term.enforce_constraints(&scene.body, &scene.state.view(0, &scene.rigid)), "nothing is crushed");
    }
    // Inverted elements, so that no difference crosses the kink at which the barrier becomes active.
    scene.state.x[0].iter_mut().for_each(|x| x.z *= -0.2);
    for term in &mut terms {
        assert!(
            !term.enforce_constraints(&scene.body, &scene.state.view(0, &scene.rigid)),
            "both elements are crushed"
        );
        assert!(term.enforce_constraints(&scene.body, &scene.state.view(0, &scene.rigid)), "both have their barrier");
        assert!(scene.energy(term.as_ref(), &scene.state) > 0.0);
        scene.check("barrier", term.as_mut());
    }
}

#[test]
fn the_energy_of_a_condensed_pad_has_its_derivatives() {
    let mut random = Random(6);
    let mut scene = Scene::new(true, &mut random);
    let patch: Vec<u32> = (0..scene.body.rest.len() as u32).filter(|n| n % 2 == 1 && *n != 3).collect();
    scene.body = scene.body.condensed(&patch);
    let size = 3 * patch.len();
    let root = faer::Mat::<f64>::from_fn(size, size, |_, _| random.number());
    let center = patch.iter().map(|&n| scene.body.rest[n as usize] + random.vector() * 0.1).collect();
    let mut term = CondensedEnergy { center, patch: patch.into(), stiffness: Arc::new(&root * root.transpose()) };
    scene.check("condensed", &mut term);
}

/// Finite-difference step for energies of a [`Scene`].
const STEP: f64 = 1.0 / 1024.0;
/// Distance from a kink that excludes a scene: three steps in each of two coordinates move a point by less.
const MARGIN: f64 = 0.02;

/// Contact law for lengths of order one; its pressure has a second branch at gaps below a quarter of the offset.
fn contact_law(offset: f64, friction: f64) -> ContactLaw {
    ContactLaw { stiffness: 4.0, offset, friction, tangential: 3.0 }
}

/// Returns whether a gap is near one of the two kinks of the pressure.
fn near_kink(law: &ContactLaw, gap: f64) -> bool {
    (gap - law.offset).abs() < MARGIN || (gap - 0.25 * law.offset).abs() < MARGIN
}

/// Returns whether a contact edge under pressure is near the friction limit, at `slip` from its anchor.
fn near_slip(law: &ContactLaw, e: &EdgeState, slip: DVec3) -> bool {
    let limit = law.friction * e.pressure / law.tangential;
    law.friction > 0.0 && e.pressure > 0.0 && (slip.length() - limit).abs() < MARGIN
}

/// Returns whether a point of the pad is near a jump of the second derivative (change of contact, branch or slip).
fn near_jump(
    scene: &Scene,
    contact: &PointContact,
    surface: &ContactSurface,
    law: &ContactLaw,
    object: &dyn SignedDistance,
) -> bool {
    let view = scene.state.view(0, &scene.rigid);
    let (position, rotation) = (view.object.position, view.object.rotation);
    contact.active_points().any(|i| {
        let (e, own) = (contact.edge(i), contact.law_of(i));
        let relative = surface.points[i].position(view.x) + view.offset - position;
        let slip = across(relative - rotation * e.anchor.unwrap_or_default(), e.normal) * e.active_fraction;
        // Skipped edges have no stored gap.
        let gap = object.distance(rotation.transpose() * relative);
        // Deep inside the object the closest point is discontinuous.
        near_kink(&own, gap) || near_slip(&own, e, slip) || gap < -law.offset
    })
}

/// Numbers of contact edges that a check covered, by pressure branch and friction state.
#[derive(Debug, Default, Clone, Copy)]
struct Covered {
    soft: usize,
    hard: usize,
    stuck: usize,
    slipping: usize,
}

impl Covered {
    fn add<'a>(&mut self, law: &ContactLaw, edges: impl Iterator<Item = (usize, &'a EdgeState)>) {
        for (_, e) in edges.filter(|(_, e)| e.pressure > 0.0) {
            let branch = if e.gap > 0.25 * law.offset { &mut self.soft } else { &mut self.hard };
            *branch += 1;
            let friction = if e.slips { &mut self.slipping } else { &mut self.stuck };
            *friction += usize::from(law.friction > 0.0);
        }
    }
}

/// Checks the contact term on random scenes in which no point is near a change of state (contact, branch, slip), where
/// the second derivative jumps. `friction` is the coefficient, `drag` the motion after the anchors are set, m.
fn check_contact(friction: f64, drag: f64) -> Covered {
    let objects: [Arc<dyn SignedDistance>; 2] =
        [Arc::new(Sphere { radius: 0.8 }), Arc::new(Ellipsoid { semi: DVec3::new(0.9, 0.7, 0.8) })];
    let mut covered = Covered::default();
    for (seed, object) in (0..90).flat_map(|s| objects.iter().map(move |o| (s, o))) {
        let mut random = Random(seed);
        let mut scene = Scene::new(seed % 2 == 1, &mut random);
        let surface = Arc::new(ContactSurface::with_subdivision(&scene.body, 2));
        let law = contact_law(0.4, friction);
        let mut contact = PointContact::new(law, surface.clone(), object.clone());
        // Set the anchors here, then move on; deeply penetrating points are stiffened.
        scene.assemble(&mut contact, Assembly::COMPLETE);
        contact.enforce_constraints(&scene.body, &scene.state.view(0, &scene.rigid));
        contact.commit(&scene.body, &scene.state.view(0, &scene.rigid));
        contact.begin_increment(&scene.increment_start(None));
        scene.shake(drag, &mut random);
        scene.assemble(&mut contact, Assembly::COMPLETE);
        let kink = near_jump(&scene, &contact, &surface, &law, object.as_ref());
        if kink || !contact.edges().any(|(_, e)| e.pressure > 0.0) {
            continue;
        }
        contact.edges().for_each(|edge| covered.add(&contact.law_of(edge.0), std::iter::once(edge)));
        scene.check(&format!("contact, friction {friction}, seed {seed}, {object:?}"), &mut contact);
    }
    println!("friction {friction}: {covered:?}");
    covered
}

/// Returns the part of `s` perpendicular to `normal`.
fn across(s: DVec3, normal: DVec3) -> DVec3 {
    s - normal * normal.dot(s)
}

/// Without friction the Hessian is exact, including the object's curvature and the second order of the rotation
/// `exp(w) R` at `w = 0`. With friction the limit `mu p` and the normal are lagged: assembly fixes them, and gradient
/// and Hessian are those of the lagged potential, which `energy` returns until the next assembly. `couple` adds the
/// dependence of friction on the pressure.
#[test]
fn contact_with_and_without_friction_has_its_derivatives_in_nodes_travel_and_pose() {
    let pressing = |c: &Covered| c.soft > 30 && c.hard > 30;
    let sticking = |c: &Covered| c.stuck > 50 && c.slipping == 0;
    let slipping = |c: &Covered| c.slipping > 50;
    type Meant = fn(&Covered) -> bool;
    for (name, friction, drag, meant) in [
        ("pressure", 0.0, 0.05, pressing as Meant),
        ("sticking", 5.0, 0.03, sticking),
        ("slipping", 0.02, 0.2, slipping),
    ] {
        let covered = check_contact(friction, drag);
        assert!(meant(&covered), "{name}: {covered:?}");
    }
}

/// A term whose candidate list dates from an earlier state has the same energy, forces and clearance, bit for bit, as a
/// newly created term, however far pad and object have moved since.
#[test]
fn points_that_are_not_listed_do_not_matter() {
    let object: Arc<dyn SignedDistance> = Arc::new(Ellipsoid { semi: DVec3::new(0.9, 0.7, 0.8) });
    let mut touched = 0;
    for seed in 0..60 {
        let mut random = Random(seed);
        let mut scene = Scene::new(seed % 2 == 1, &mut random);
        let surface = Arc::new(ContactSurface::with_subdivision(&scene.body, 4));
        let new = || PointContact::new(contact_law(0.01, 0.0), surface.clone(), object.clone());
        let mut known = new();
        for motion in [0.0, 1e-3, 1e-2, 0.05, 0.3, 1e-2] {
            scene.shake(motion, &mut random);
            let mut fresh = new();
            let view = scene.state.view(0, &scene.rigid);
            let same = |known: &PointContact, fresh: &PointContact| {
                let of = |term: &PointContact| [term.energy(&scene.body, &view), term.clearance(&scene.body, &view)];
                assert_eq!(of(known).map(f64::to_bits), of(fresh).map(f64::to_bits), "seed {seed}, motion {motion}");
            };
            same(&known, &fresh);
            let [forces, expected] =
                [&mut known, &mut fresh].map(|term| scene.assemble(term, Assembly::COMPLETE).gradient);
            assert_eq!(forces, expected, "seed {seed}, motion {motion}");
            touched += usize::from(forces.iter().any(|f| *f != DVec3::ZERO));
            same(&known, &fresh);
        }
    }
    assert!(touched > 60, "{touched} states with contact");
}

/// The derivative of the true gradient along every coordinate except the object's rotation is the Hessian of the lagged
/// potential plus the terms of `couple`: friction limits depend on the pressure, and the active fraction of a point
/// that comes into contact within the increment grows with its depth. The object is a slab with constant normals.
#[test]
fn forces_of_slipping_and_of_touching_points_follow_the_pressure() {
    let object: Arc<dyn SignedDistance> = Arc::new(Cuboid { core: DVec3::new(9.0, 9.0, 0.8), radius: 0.0 });
    let (mut covered, mut touching) = (Covered::default(), 0);
    for seed in 0..10000 {
        let mut random = Random(seed);
        let mut scene = Scene::new(seed % 2 == 1, &mut random);
        let surface = Arc::new(ContactSurface::with_subdivision(&scene.body, 1));
        let law = contact_law(0.4, 0.3);
        let mut contact = PointContact::new(law, surface.clone(), object.clone());
        scene.assemble(&mut contact, Assembly::COMPLETE);
        contact.commit(&scene.body, &scene.state.view(0, &scene.rigid));
        let here = scene.state.clone();
        if seed % 3 == 0 {
            // No contact at the start of the increment: the slab was farther away.
            contact = PointContact::new(law, surface.clone(), object.clone());
            scene.state.position.z += if seed % 2 == 0 { 0.5 } else { -0.5 };
        }
        contact.begin_increment(&scene.increment_start(None));
        scene.state = here;
        scene.shake(0.2, &mut random);
        let block = scene.assemble(&mut contact, Assembly::COMPLETE);
        let view = scene.state.view(0, &scene.rigid);
        let kink = near_jump(&scene, &contact, &surface, &law, object.as_ref());
        // Differences are accurate only where gap and slip are well above the step.
        let small = |e: &EdgeState| {
            e.slips && e.limit < 0.05 * law.tangential
                || e.initial_gap.is_some_and(|clear| clear > law.offset && clear - e.gap < 0.15)
        };
        if contact.edges().any(|(_, e)| small(e)) {
            continue;
        }
        let is_touching =
            |e: &EdgeState| e.pressure > 0.0 && e.active_fraction > 0.0 && e.active_fraction < 1.0 && !e.slips;
        if kink || !contact.edges().any(|(_, e)| e.slips || is_touching(e)) {
            continue;
        }
        covered.add(&law, contact.edges());
        touching += contact.edges().filter(|(_, e)| is_touching(e)).count();
        let (unknowns, hessian) = (scene.unknowns(), scene.hessian(&block));
        let turning = scene.size() - 3;
        for (j, &c) in unknowns.iter().enumerate().filter(|(_, c)| **c < turning) {
            let step = scene.step(c, 1.0, c, 0.0);
            let mut change = BodyBlock::new(&scene.body, scene.rigid.size);
            contact.add_nonsymmetric_change(&scene.body, &view, &step.motion(0, &view), &mut change);
            let coupled = scene.gradient(&change);
            let expected: Vec<f64> =
                unknowns.iter().enumerate().map(|(i, &r)| hessian[i * unknowns.len() + j] + coupled[r]).collect();
            let gradient = |d: f64| {
                let mut block = BodyBlock::new(&scene.body, scene.rigid.size);
                let state = scene.moved(c, d, c, 0.0);
                contact.clone().assemble(&scene.body, &state.view(0, &scene.rigid), Assembly::COMPLETE, &mut block);
                scene.gradient(&block)
            };
            let numeric: Vec<f64> = unknowns.iter().map(|&r| slope(STEP, |d| gradient(d)[r])).collect();
            let error = deviation(&numeric, &expected, 1e-3);
            assert!(error < TOLERANCE, "seed {seed}, coordinate {c}: off by {error:.1e}");
        }
    }
    println!("{covered:?}, {touching} touching");
    assert!(covered.slipping > 30 && touching > 10, "{covered:?}, {touching} touching");
}

/// Creates scenes away from kinks with contact vertices of the object over interior points of the pad's faces, so that
/// each presses on a single face. Returns the scene, the law, the term (assembled and committed at the state of its
/// anchors, then assembled at the current state), and the same term without friction.
fn feature_scenes(sharp: bool, friction: f64, drag: f64) -> Vec<(Scene, ContactLaw, VertexContact, VertexContact)> {
    let mut scenes = Vec::new();
    for seed in 0..60 {
        let mut random = Random(1000 + seed);
        let mut scene = Scene::new(seed % 2 == 1, &mut random);
        let surface = Arc::new(ContactSurface::new(&scene.body));
        let felt = contact_law(0.4, friction);
        // A smooth vertex is active with a reduced contact offset.
        let law = ContactLaw { offset: if sharp { felt.offset } else { felt.offset / 0.3 }, ..felt };
        let view = scene.state.view(0, &scene.rigid);
        let mut feature = |face: &SurfaceFace| {
            let l = [0, 1, 2].map(|_| 1.0 + 0.25 * random.number());
            let l = l.map(|v| v / l.iter().sum::<f64>());
            let (foot, normal) = face_frame(face, view.x, l);
            let point = foot + normal * felt.offset * random.number() + view.offset;
            let position = view.object.rotation.transpose() * (point - view.object.position);
            ContactVertex { position, sharp, segment: None }
        };
        let features: Arc<[ContactVertex]> = surface.faces.iter().map(&mut feature).collect();
        let mut terms = [friction, 0.0]
            .map(|friction| VertexContact::new(ContactLaw { friction, ..law }, surface.clone(), features.clone()));
        for term in &mut terms {
            scene.assemble(term, Assembly::COMPLETE);
            term.commit(&scene.body, &scene.state.view(0, &scene.rigid));
            term.begin_increment(&scene.increment_start(None));
        }
        let [mut with, mut without] = terms;
        let mut stuck = vec![Stencil::NONE; features.len()];
        with.edge_readings(&view).iter().for_each(|edge| stuck[edge.number] = edge.touched);
        scene.shake(drag, &mut random);
        scene.assemble(&mut with, Assembly::COMPLETE);
        scene.assemble(&mut without, Assembly::COMPLETE);
        let view = scene.state.view(0, &scene.rigid);
        let kink = with.edges().any(|(i, e)| {
            let arm = view.object.rotation * features[i].position;
            let relative = stuck[i].position(view.x) + view.offset - view.object.position - arm;
            let slip = across(relative + e.anchor.unwrap_or_default(), e.normal) * e.active_fraction;
            near_kink(&felt, e.gap) || near_slip(&law, e, slip) || e.gap < -0.8 * felt.offset
        });
        if !kink && with.edges().any(|(_, e)| e.pressure > 0.0) {
            scenes.push((scene, felt, with, without));
        }
    }
    scenes
}

/// Gap and normal are those at the closest point of the pad's faces, which may be curved. The Hessian is exact:
/// `H = k dg dg - p d2g` with the gap `g`; the second part accounts for curvature and rotation of the pad's face and for
/// the sliding of the closest point.
#[test]
fn pressure_at_features_has_its_derivatives() {
    for sharp in [true, false] {
        let (mut covered, mut quadratic) = (Covered::default(), 0);
        for (scene, law, mut term, _) in feature_scenes(sharp, 0.0, 0.03) {
            covered.add(&law, term.edges());
            quadratic += usize::from(matches!(scene.body.elements, Elements::Quadratic(_)));
            scene.check("pressure at features", &mut term);
        }
        println!("sharp {sharp}: {covered:?}");
        assert!(covered.soft > 20 && covered.hard > 20, "sharp {sharp}: {covered:?}");
        assert!(quadratic > 5, "sharp {sharp}: {quadratic} scenes with bent faces");
    }
}

#[test]
fn projected_hessian_of_pressure_at_features_is_that_of_gauss_and_newton() {
    for (scene, law, mut term, _) in feature_scenes(true, 0.0, 0.03) {
        let unknowns = scene.unknowns();
        let block = scene.assemble(&mut term, Assembly::PROJECTED);
        assert_positive("features", unknowns.len(), &scene.hessian(&block));
        let mut expected = vec![0.0; unknowns.len() * unknowns.len()];
        let readings = term.edge_readings(&scene.state.view(0, &scene.rigid));
        for reading in readings.iter().filter(|reading| reading.state.pressure > 0.0) {
            let (i, e) = (reading.number, term.edge(reading.number));
            let gap = |state: &State| {
                let mut moved = term.clone();
                moved.assemble(
                    &scene.body,
                    &state.view(0, &scene.rigid),
                    Assembly::COMPLETE,
                    &mut BodyBlock::new(&scene.body, scene.rigid.size),
                );
                moved.edge(i).gap
            };
            let slopes: Vec<f64> = unknowns.iter().map(|&c| slope(STEP, |d| gap(&scene.moved(c, d, c, 0.0)))).collect();
            let area = reading.force.dot(e.normal) / e.pressure;
            let stiffness = law.pressure(e.gap, e.scale).1 * area;
            for (k, value) in expected.iter_mut().enumerate() {
                *value += stiffness * slopes[k / unknowns.len()] * slopes[k % unknowns.len()];
            }
        }
        let error = deviation(&expected, &scene.hessian(&block), 0.0);
        assert!(error < TOLERANCE, "Hessian off by {error:.1e}");
    }
}

/// Checks friction at contact vertices alone: the difference between the term with friction and the same term without.
fn check_feature_friction(friction: f64, drag: f64) -> Covered {
    let mut covered = Covered::default();
    for (scene, law, mut with, mut without) in feature_scenes(true, friction, drag) {
        covered.add(&law, with.edges());
        let projected = [&mut with, &mut without].map(|t| scene.hessian(&scene.assemble(t, Assembly::PROJECTED)));
        let difference = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<_>>();
        let unknowns = scene.unknowns();
        assert_positive("friction at features", unknowns.len(), &difference(&projected[0], &projected[1]));
        let blocks = [&mut with, &mut without].map(|t| scene.assemble(t, Assembly::COMPLETE));
        let [gradient, gradient_without] = [0, 1].map(|k| scene.gradient(&blocks[k]));
        let [hessian, hessian_without] = [0, 1].map(|k| scene.hessian(&blocks[k]));
        let energy = |state: &State| scene.energy(&with, state) - scene.energy(&without, state);
        let numeric: Vec<f64> =
            (0..scene.size()).map(|c| slope(STEP, |d| energy(&scene.moved(c, d, c, 0.0)))).collect();
        let error = deviation(&numeric, &difference(&gradient, &gradient_without), 0.0);
        assert!(error < TOLERANCE, "gradient off by {error:.1e}");
        let numeric = scene.second_differences(&unknowns, &energy);
        let error = deviation(&numeric, &difference(&hessian, &hessian_without), 0.0);
        assert!(error < TOLERANCE, "Hessian off by {error:.1e}");
    }
    println!("friction {friction}: {covered:?}");
    covered
}

/// Friction is lagged as at the pad's points; since sticking point and normal are held fixed, the Hessian is exact on
/// curved faces too.
#[test]
fn sticking_and_slipping_friction_at_features_have_their_derivatives() {
    let covered = check_feature_friction(5.0, 0.03);
    assert!(covered.stuck > 20 && covered.slipping == 0, "sticking: {covered:?}");
    let covered = check_feature_friction(0.02, 0.15);
    assert!(covered.slipping > 20, "slipping: {covered:?}");
}

/// Adapter of an object term to a body term for the same checks; its derivatives in nodes and travel must vanish.
#[derive(Clone)]
struct OfObject<T> {
    term: T,
    /// Function that begins a time step of the term.
    begin: fn(&mut T, &TimeStep),
}

impl<T: ObjectTerm + Clone + 'static> BodyTerm for OfObject<T> {
    fn energy(&self, _: &Body, view: &BodyView) -> f64 {
        self.term.energy(&view.object)
    }

    fn assemble(&mut self, _: &Body, view: &BodyView, how: Assembly, block: &mut BodyBlock) {
        self.term.assemble(&view.object, how, &mut block.rigid);
    }

    fn begin_increment(&mut self, from: &IncrementStart) {
        from.step.iter().for_each(|step| (self.begin)(&mut self.term, step));
    }

    fn commit(&mut self, _: &Body, view: &BodyView) {
        self.term.commit(&view.object);
    }
}

/// Returns a hand at a random pose.
fn hand(random: &mut Random) -> Pose {
    Pose { position: random.vector(), rotation: random.rotation() }
}

/// Creates a scene, a term at its state with a random hand, and a step in which hand and state move by about `drag`.
fn stepped<T: BodyTerm>(seed: u64, drag: f64, term: impl Fn(&Scene, Pose, &mut Random) -> T) -> (Scene, T, TimeStep) {
    let mut random = Random(seed);
    let mut scene = Scene::new(seed % 2 == 1, &mut random);
    let start = hand(&mut random);
    let mut term = term(&scene, start, &mut random);
    let turn = DQuat::from_scaled_axis(random.vector() * drag);
    let moved = Pose { position: start.position + random.vector() * drag, rotation: start.rotation * turn };
    let step = TimeStep { size: 0.7, hand: moved };
    term.begin_increment(&scene.increment_start(Some(step)));
    scene.shake(drag, &mut random);
    (scene, term, step)
}

#[test]
fn a_dead_force_has_its_derivatives() {
    for seed in 0..6 {
        let make = |scene: &Scene, _: Pose, random: &mut Random| {
            let term = PointLoad::new(random.vector(), random.vector(), scene.state.position);
            OfObject { term, begin: |_, _| {} }
        };
        let (scene, mut term, _) = stepped(seed, 0.2, make);
        scene.check("dead force", &mut term);
    }
}

#[test]
fn inertia_of_pads_viscosity_and_drive_have_their_derivatives() {
    for seed in 0..6 {
        let make = |scene: &Scene, hand: Pose, random: &mut Random| {
            PadInertia::new(&scene.body, 0.4, random.vector(), hand, &scene.state.view(0, &scene.rigid))
        };
        let (scene, mut term, _) = stepped(seed, 0.2, make);
        scene.check("inertia of pads", &mut term);
        let make = |scene: &Scene, _: Pose, _: &mut Random| Viscosity::new(&scene.body, 0.3, &scene.state.x[0]);
        let (scene, mut term, _) = stepped(seed, 0.2, make);
        scene.check("viscosity", &mut term);
        // Within the stroke and beyond its end.
        for end in [5.0, -5.0] {
            let make = |scene: &Scene, _: Pose, _: &mut Random| Drive::new(1e-5, 2.0, end, 1e-5, scene.state.travel[0]);
            let (scene, mut term, _) = stepped(seed, 0.2, make);
            scene.check("drive", &mut term);
        }
    }
}

/// The rotation vector is relative to the last assembly, at which the check starts.
#[test]
fn inertia_of_a_rigid_object_has_its_derivatives() {
    for seed in 0..12 {
        let make = |scene: &Scene, hand: Pose, random: &mut Random| {
            let mut mass = MassProperties::of_ellipsoid(DVec3::new(0.9, 0.7, 0.4));
            mass.center = random.vector();
            let moving = (random.vector(), random.vector());
            let view = scene.state.object_view(&scene.rigid);
            let term = RigidInertia::new(&mass, 0.5, random.vector(), moving, hand, &view);
            OfObject { term, begin: RigidInertia::begin_step }
        };
        let (scene, mut term, _) = stepped(seed, 0.3, make);
        scene.check("rigid inertia", &mut term);
    }
}

/// Checks contact of six object points with a plane of the world in scenes with no point near a change of state.
fn check_ground(friction: f64, drag: f64) -> Covered {
    let mut covered = Covered::default();
    for seed in 0..400 {
        let law = contact_law(0.4, friction);
        let mut scatter = Random(9000 + seed);
        let vertices: Arc<[DVec3]> = (0..6).map(|_| scatter.vector() * 0.5).collect();
        let make = |scene: &Scene, hand: Pose, random: &mut Random| {
            let view = scene.state.view(0, &scene.rigid);
            let normal = random.vector().normalize();
            let lowest =
                vertices.iter().map(|v| normal.dot(hand.transform(view.object.position + view.object.rotation * *v)));
            let height = lowest.fold(f64::INFINITY, f64::min) - 0.1;
            let term = GroundContact::new(vertices.clone(), law, normal, height, hand, &view.object);
            let mut term = OfObject { term, begin: GroundContact::begin_step };
            // Set the anchors here; the step then moves on.
            scene.assemble(&mut term, Assembly::COMPLETE);
            term.commit(&scene.body, &view);
            term
        };
        let (scene, mut term, step) = stepped(seed, drag, make);
        scene.assemble(&mut term, Assembly::COMPLETE);
        let kink = term.term.edges().any(|(i, e)| {
            let point = scene.state.position + scene.state.rotation * vertices[i];
            let slip =
                across(step.hand.inverse_transform(e.anchor.unwrap_or_default()) - point, e.normal) * e.active_fraction;
            near_kink(&law, e.gap) || near_slip(&law, e, slip)
        });
        if kink || !term.term.edges().any(|(_, e)| e.pressure > 0.0) {
            continue;
        }
        covered.add(&law, term.term.edges());
        scene.check(&format!("ground, friction {friction}, seed {seed}"), &mut term);
    }
    println!("ground, friction {friction}: {covered:?}");
    covered
}

#[test]
fn contact_with_the_ground_has_its_derivatives() {
    let covered = check_ground(0.0, 0.1);
    assert!(covered.soft > 20 && covered.hard > 5, "{covered:?}");
    let covered = check_ground(8.0, 0.02);
    assert!(covered.stuck > 20 && covered.slipping == 0, "{covered:?}");
    let covered = check_ground(0.2, 0.2);
    assert!(covered.slipping > 10, "{covered:?}");
}
