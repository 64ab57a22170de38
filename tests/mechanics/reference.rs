//! Elements and materials against CalculiX 2.20 and exact solutions, in the units of the reference files: mm, N, MPa.

use crate::common::{Random, close, elements, errors, reference, reference_mesh, vectors};
use glam::{DMat3, DQuat, DVec3};
use serde_json::Value;
use std::sync::{Arc, Mutex};
use tactus::geometry::mesh::quality::volumes;
use tactus::geometry::mesh::{TetMesh, grid, quadratic, surface};
use tactus::mech::body::pattern::Pattern;
use tactus::mech::body::{Body, Elements};
use tactus::mech::element::{Kernel, RestTet, TET4, TET10};
use tactus::mech::material::{Linear, Material, NeoHookean, von_mises};
use tactus::mech::newton::{Newton, NewtonTolerance};
use tactus::mech::potential::block::BodyBlock;
use tactus::mech::potential::state::{BodyView, RigidUnknowns, State};
use tactus::mech::potential::term::{Assembly, BodyTerm, ElasticEnergy, NodalLoads};

const YOUNG: f64 = 0.3;
const POISSON: f64 = 0.45;

fn neo_hookean() -> Arc<dyn Material> {
    Arc::new(NeoHookean::new(YOUNG, POISSON))
}

/// Reference cases whose results are a few numbers each.
fn cases() -> Value {
    serde_json::from_str(&reference("simple_cases.json")).expect("JSON")
}

fn number(v: &Value) -> f64 {
    v.as_f64().expect("number")
}

fn vector(v: &Value) -> DVec3 {
    DVec3::new(number(&v[0]), number(&v[1]), number(&v[2]))
}

/// Reads a 3 x 3 matrix given by rows.
fn matrix(v: &Value) -> DMat3 {
    DMat3::from_cols(vector(&v[0]), vector(&v[1]), vector(&v[2])).transpose()
}

/// Reads a symmetric tensor given as xx yy zz xy xz yz.
fn tensor(v: &Value) -> DMat3 {
    let [xx, yy, zz, xy, xz, yz] = std::array::from_fn(|i| number(&v[i]));
    DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz])
}

fn largest(m: &DMat3) -> f64 {
    m.to_cols_array().iter().fold(0.0, |a: f64, v| a.max(v.abs()))
}

/// Solver of a single body without object or finger.
struct Solver {
    newton: Newton,
    state: State,
}

impl Solver {
    fn new(body: Body, load: Option<Box<dyn BodyTerm>>) -> Self {
        let x = body.rest.clone();
        let mut terms: Vec<Box<dyn BodyTerm>> = vec![Box::new(ElasticEnergy)];
        terms.extend(load);
        let newton = Newton::new(vec![Arc::new(body)], vec![terms], RigidUnknowns::none(1)).expect("solver");
        Self {
            newton,
            state: State { x: vec![x], travel: vec![0.0], position: DVec3::ZERO, rotation: DQuat::IDENTITY },
        }
    }

    fn solve(&mut self) {
        let tolerance = NewtonTolerance {
            relative: 0.0,
            force: 1e-10,
            length: 1e-7,
            iterations: 60,
            max_motion: 1e3,
            intermediate: false,
            offset: 1e-5,
        };
        let solved = self.newton.solve(&self.state, self.state.clone(), &tolerance);
        self.state = solved.expect("converges").0;
    }

    fn displacement(&self) -> Vec<DVec3> {
        self.state.x[0].iter().zip(&self.newton.body(0).rest).map(|(x, r)| *x - *r).collect()
    }
}

/// Cube of 3 mm of irregular tetrahedra: its interior nodes are displaced by up to a quarter of a cell along each axis.
fn irregular_patch() -> TetMesh {
    let lines = [0.0, 1.0, 2.0, 3.0];
    let mut mesh = grid::structured([&lines; 3]).expect("grid");
    let mut random = Random(1);
    for p in mesh.nodes.iter_mut().filter(|p| p.to_array().iter().all(|c| *c > 0.0 && *c < 3.0)) {
        *p += 0.25 * random.vector();
    }
    let least = volumes(&mesh).into_iter().fold(f64::INFINITY, f64::min);
    assert!(least > 0.02, "no tetrahedron is inverted or flat: {least} mm3");
    mesh
}

/// Patch test: a linear displacement field prescribed on the boundary is reproduced inside to 1e-9 mm, and every
/// quadrature point has the exact stress to a relative 1e-9.
fn patch_test(law: Arc<dyn Material>, map: impl Fn(DVec3) -> DVec3, exact: DMat3) {
    let mesh = irregular_patch();
    let outer = surface::boundary_mesh(&mesh).1;
    for (order, mean_dilatation) in [(1, false), (2, false), (2, true)] {
        let (rest, elements) = elements(&mesh, order == 2);
        // Mid-edge nodes are prescribed if both ends are: on the boundary, and on the few interior edges between two
        // sides.
        let mut fixed: Vec<bool> = (0..rest.len()).map(|i| outer.contains(&(i as u32))).collect();
        if order == 2 {
            for (k, [a, b]) in quadratic::midpoint_edges(&mesh).into_iter().enumerate() {
                fixed[mesh.nodes.len() + k] = fixed[a as usize] && fixed[b as usize];
            }
        }
        let free = fixed.iter().filter(|f| !**f).count();
        assert!(free > 0, "there must be something to solve for");
        let body = Body::new(rest, elements, fixed, law.clone(), mean_dilatation);
        let mut solver = Solver::new(body, None);
        let prescribed = solver.newton.body(0).fixed.clone();
        for (x, fixed) in solver.state.x[0].iter_mut().zip(&prescribed) {
            if *fixed {
                *x = map(*x);
            }
        }
        solver.solve();
        let what = format!("{}, order {order}, mean dilatation {mean_dilatation}", law.name());
        let (rest, x) = (&solver.newton.body(0).rest, &solver.state.x[0]);
        let wrong = rest.iter().zip(x).map(|(r, x)| (*x - map(*r)).length()).fold(0.0, f64::max);
        assert!(wrong < 1e-9, "{what}: displacement off by {wrong:.1e} mm");

        let material = law.as_ref();
        let rest_of = |n: &[u32]| RestTet::new(std::array::from_fn(|k| rest[n[k] as usize]));
        let stresses: Vec<DMat3> = match &solver.newton.body(0).elements {
            Elements::Linear(e) => {
                let kernel = Kernel { shape: &TET4, material, mean_dilatation };
                e.iter().flat_map(|n| kernel.stress(&rest_of(n), &n.map(|i| x[i as usize]))).collect()
            }
            Elements::Quadratic(e) => {
                let kernel = Kernel { shape: &TET10, material, mean_dilatation };
                e.iter().flat_map(|n| kernel.stress(&rest_of(n), &n.map(|i| x[i as usize]))).collect()
            }
        };
        let wrong = stresses.iter().map(|s| largest(&(*s - exact))).fold(0.0, f64::max) / largest(&exact);
        assert!(wrong < 1e-9, "{what}: stress off by {wrong:.1e} of its largest entry");
        let recovered = solver.newton.body(0).stress(x);
        for value in recovered.element.iter().chain(&recovered.node) {
            close(&format!("{what}: recovered von Mises stress, MPa"), *value, von_mises(&exact), 1e-9);
        }
    }
}

#[test]
fn patch_of_infinitesimal_strain_is_exact() {
    let cases = cases();
    let case = &cases["patch"];
    let g = matrix(&case["G"]);
    patch_test(Arc::new(Linear::new(YOUNG, POISSON)), |p| p + g * p, tensor(&case["exact_stress_xx_yy_zz_xy_xz_yz"]));
}

#[test]
fn patch_of_finite_strain_is_exact() {
    let cases = cases();
    let case = &cases["patch_neohooke"];
    let f = matrix(&case["F"]);
    patch_test(neo_hookean(), |p| f * p, tensor(&case["exact_cauchy_xx_yy_zz_xy_xz_yz"]));
}

/// Single coordinates held at prescribed values by the augmented Lagrangian method: penalty spring plus multiplier.
#[derive(Clone)]
struct Rollers {
    held: Vec<(usize, usize, f64)>,
    /// Multiplier of each constraint, shared with the test, N.
    force: Arc<Mutex<Vec<f64>>>,
}

const ROLLER: f64 = 1e3;

impl Rollers {
    fn new(held: Vec<(usize, usize, f64)>) -> Self {
        Self { force: Arc::new(Mutex::new(vec![0.0; held.len()])), held }
    }

    fn off(&self, view: &BodyView, k: usize) -> f64 {
        let (node, axis, value) = self.held[k];
        view.x[node][axis] - value
    }
}

impl BodyTerm for Rollers {
    fn energy(&self, _: &Body, view: &BodyView) -> f64 {
        let force = self.force.lock().unwrap();
        let spring = |k| force[k] * self.off(view, k) + 0.5 * ROLLER * self.off(view, k).powi(2);
        (0..self.held.len()).map(spring).sum()
    }

    fn assemble(&mut self, body: &Body, view: &BodyView, _: Assembly, block: &mut BodyBlock) {
        let force = self.force.lock().unwrap();
        for (k, &(node, axis, _)) in self.held.iter().enumerate() {
            block.gradient[node][axis] += force[k] + ROLLER * self.off(view, k);
            let mut diagonal = DVec3::ZERO;
            diagonal[axis] = ROLLER;
            let slot = body.pattern().slot(node as u32, node as u32);
            Pattern::add(&mut block.values, slot, &DMat3::from_diagonal(diagonal));
        }
    }

    fn enforce_constraints(&mut self, _: &Body, view: &BodyView) -> bool {
        let off: Vec<f64> = (0..self.held.len()).map(|k| self.off(view, k)).collect();
        if off.iter().all(|o| o.abs() < 1e-9) {
            return true;
        }
        for (force, off) in self.force.lock().unwrap().iter_mut().zip(&off) {
            *force += ROLLER * off;
        }
        false
    }
}

#[test]
fn bar_in_uniaxial_tension_and_compression() {
    let (cases, mesh) = (cases(), reference_mesh("bar"));
    for row in cases["uniaxial_bar"]["rows"].as_array().expect("rows") {
        let stretch = number(&row["stretch"]);
        let mut held = Vec::new();
        for (i, p) in mesh.nodes.iter().enumerate() {
            held.extend((0..3).filter(|&c| p[c] == 0.0).map(|c| (i, c, 0.0)));
            held.extend((p.z == 6.0).then_some((i, 2, 6.0 * stretch)));
        }
        let fixed = vec![false; mesh.nodes.len()];
        let elements = Elements::Linear(mesh.tets.clone());
        let body = Body::new(mesh.nodes.clone(), elements, fixed, neo_hookean(), true);
        let rollers = Rollers::new(held);
        let mut solver = Solver::new(body, Some(Box::new(rollers.clone())));
        // The stretched bar as initial guess keeps the springs from inverting elements.
        solver.state.x[0].iter_mut().for_each(|x| x.z *= stretch);
        solver.solve();
        let multipliers = rollers.force.lock().unwrap();
        let top = rollers.held.iter().zip(&*multipliers).filter(|(h, _)| h.1 == 2 && h.2 > 0.0);
        // The multiplier is the negative of the pulling force.
        let force = -top.map(|(_, f)| f).sum::<f64>();
        close(&format!("force at stretch {stretch}, N"), force, number(&row["force_exact"]), 1e-6);
        let corner = mesh.nodes.iter().position(|p| *p == DVec3::new(2.0, 2.0, 6.0)).expect("corner");
        let lateral = solver.state.x[0][corner].truncate() / 2.0;
        for value in lateral.to_array() {
            close(&format!("lateral stretch at {stretch}"), value, number(&row["lateral_stretch_exact"]), 1e-6);
        }
    }
}

/// Nodal forces of a dead traction, N/mm2, on the face z = 24 of the cantilever.
fn end_traction(mesh: &TetMesh, quadratic: bool, nodes: usize, traction: DVec3) -> Vec<DVec3> {
    let mut load = vec![DVec3::ZERO; nodes];
    let edges = quadratic::midpoint_edges(mesh);
    for face in surface::boundary(mesh) {
        let corners = face.nodes.map(|i| mesh.nodes[i as usize]);
        if corners.iter().any(|p| p.z != 24.0) {
            continue;
        }
        let [a, b, c] = corners;
        let third = traction * (0.5 * (b - a).cross(c - a).length() / 3.0);
        for k in 0..3 {
            // Consistent nodal loads: at the corners of a linear face, at the mid-edge nodes of a quadratic one.
            let (i, j) = (face.nodes[k], face.nodes[(k + 1) % 3]);
            let middle = || mesh.nodes.len() + edges.binary_search(&[i.min(j), i.max(j)]).expect("an edge of the mesh");
            load[if quadratic { middle() } else { i as usize }] += third;
        }
    }
    load
}

/// Loads the cantilever with 4e-4 N/mm2 times each of `levels` in sequence; returns the displacements at each, mm.
fn cantilever(mesh: &TetMesh, quadratic: bool, mean: bool, law: Arc<dyn Material>, levels: &[f64]) -> Vec<Vec<DVec3>> {
    let (rest, elements) = elements(mesh, quadratic);
    let unit = end_traction(mesh, quadratic, rest.len(), DVec3::X * 4e-4);
    close("total force of load 1, N", unit.iter().map(|f| f.x).sum(), 0.0064, 1e-12);
    let fixed = rest.iter().map(|p| p.z == 0.0).collect();
    let body = Body::new(rest, elements, fixed, law, mean);
    let mut solver = Solver::new(body, Some(Box::new(NodalLoads(vec![]))));
    let mut load = 0.0;
    levels
        .iter()
        .map(|level| {
            while load < *level {
                load = (load + 0.5f64).min(*level);
                solver.newton.terms[0][1] = Box::new(NodalLoads(unit.iter().map(|f| *f * load).collect()));
                solver.solve();
            }
            let fixed = solver.newton.body(0).fixed.iter();
            let reaction: DVec3 =
                solver.newton.gradient(0).iter().zip(fixed).filter(|(_, f)| **f).map(|(g, _)| *g).sum();
            let off = (reaction + DVec3::X * 0.0064 * load).length();
            assert!(off < 1e-8, "the support carries the load to {off:.1e} N");
            solver.displacement()
        })
        .collect()
}

#[test]
fn cantilever_of_linear_tetrahedra_bends_as_in_calculix() {
    let (cases, mesh) = (cases(), reference_mesh("cant_c"));
    let bent = cantilever(&mesh, false, true, neo_hookean(), &[1.0, 5.0]);
    for (ours, name) in bent.iter().zip(["cant_c_nh_load1_U.txt", "cant_c_nh_load5_U.txt"]) {
        let (norm, node) = errors(ours, &vectors(name));
        println!("{name}: {norm:.1e} of the norm, {node:.1e} of the largest displacement");
        assert!(norm < 1e-5 && node < 1e-5, "{name}: off by {norm:.1e} of the norm, {node:.1e} of the largest");
    }
    let linear = cantilever(&mesh, false, true, Arc::new(Linear::new(YOUNG, POISSON)), &[0.05]);
    let tip = vector(&cases["cant_c"]["results"]["linear_load0.05"]["tip_u"]);
    let off = (linear[0][112] - tip).length() / tip.length();
    assert!(off < 1e-6, "Hooke's law: tip off by {off:.1e}");
}

/// The reference mesh splits the cells of the same beam differently: tips agree to the mesh error, 1.5 %.
#[test]
fn cantilever_of_quadratic_tetrahedra_bends_as_in_calculix() {
    let cases = cases();
    let lines = |n: usize, length: f64| (0..=n).map(|i| length * i as f64 / n as f64).collect::<Vec<_>>();
    let (across, along) = (lines(3, 4.0), lines(18, 24.0));
    let mesh = grid::structured([&across, &across, &along]).expect("grid");
    let nodes = quadratic::to_quadratic(&mesh).nodes;
    for mean in [false, true] {
        let bent = cantilever(&mesh, true, mean, neo_hookean(), &[1.0, 2.0, 5.0]);
        for (u, load) in bent.iter().zip(["1.0", "2.0", "5.0"]) {
            let end: Vec<DVec3> = nodes.iter().zip(u).filter(|(p, _)| p.z == 24.0).map(|(_, u)| *u).collect();
            let tip = end.iter().sum::<DVec3>() / end.len() as f64;
            let truth = vector(&cases["cant_q2"]["tip_u"][load]);
            let off = (tip - truth).length() / truth.length();
            println!("mean dilatation {mean}, load {load}: tip off by {:.2} %", 100.0 * off);
            assert!(off < 0.015, "mean dilatation {mean}, load {load}: tip {tip} against {truth} mm, {off:.2e} off");
        }
    }
}

#[test]
fn tied_punch_on_a_pad_pushes_and_shears_as_in_calculix() {
    let (cases, mesh) = (cases(), reference_mesh("pad_1k"));
    let case = &cases["tied_punch_pad_1k"];
    let disc: Vec<usize> = case["disc_nodes"].as_array().expect("nodes").iter().map(|v| number(v) as usize).collect();
    let fixed = (0..mesh.nodes.len()).map(|i| mesh.nodes[i].z == 0.0 || disc.contains(&i)).collect();
    let elements = Elements::Linear(mesh.tets.clone());
    let body = Body::new(mesh.nodes.clone(), elements, fixed, neo_hookean(), true);
    let mut solver = Solver::new(body, None);
    let steps = [(0.0, -0.25), (0.0, -0.5), (0.0, -1.0), (0.5, -1.0)];
    let files = [None, None, Some("tied_pad_1k_press1.0_U.txt"), Some("tied_pad_1k_press1.0_shear0.5_U.txt")];
    let mut now = DVec3::ZERO;
    for (k, ((ux, uz), file)) in steps.into_iter().zip(files).enumerate() {
        let goal = DVec3::new(ux, 0.0, uz);
        let from = now;
        // Increments of at most 0.25 mm, a fifth of an element.
        let parts = ((goal - from).length() / 0.25).ceil();
        for part in 1..=parts as u32 {
            now = from + (goal - from) * (f64::from(part) / parts);
            for &i in &disc {
                solver.state.x[0][i] = mesh.nodes[i] + now;
            }
            solver.solve();
        }
        let force: DVec3 = disc.iter().map(|&i| solver.newton.gradient(0)[i]).sum();
        let truth = vector(&case["force_on_disc"][k]);
        let off = (force - truth).length() / truth.length();
        let stress = solver.newton.body(0).stress(&solver.state.x[0]);
        let peak = stress.element.iter().copied().fold(0.0, f64::max);
        println!("step {k}: force off by {off:.1e}");
        assert!(off < 1e-5, "step {k}: force {force} against {truth} N, {off:.1e} off");
        close(&format!("step {k}: largest von Mises stress, MPa"), peak, number(&case["max_vonMises_cauchy"][k]), 1e-5);
        if let Some(name) = file {
            let (norm, node) = errors(&solver.displacement(), &vectors(name));
            println!("{name}: {norm:.1e} of the norm, {node:.1e} of the largest displacement");
            assert!(norm < 1e-5 && node < 1e-5, "{name}: off by {norm:.1e} of the norm, {node:.1e} of the largest");
        }
    }
}
