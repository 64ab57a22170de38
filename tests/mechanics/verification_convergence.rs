//! Observed order of convergence by the method of manufactured solutions (Roache 2002): a smooth displacement field of
//! finite strain is prescribed on the boundary of a block, with the corresponding body force inside; under refinement
//! the solution must converge to it at the order of the element.

use crate::common::elements;
use glam::{DMat3, DQuat, DVec3};
use std::sync::Arc;
use tactus::geometry::mesh::grid;
use tactus::mech::body::{Body, Elements};
use tactus::mech::element::{EDGES, RestTet};
use tactus::mech::material::{Material, NeoHookean};
use tactus::mech::newton::{Newton, NewtonTolerance};
use tactus::mech::potential::state::{RigidUnknowns, State};
use tactus::mech::potential::term::{BodyTerm, ElasticEnergy, NodalLoads};

/// Displacement, m, as a function of the point of the unit cube.
type Field = fn(DVec3) -> DVec3;

fn wave(v: f64) -> f64 {
    (1.7 * v + 0.3).sin()
}

/// Displacement with strains of up to 20 %.
fn general(p: DVec3) -> DVec3 {
    let second = wave(p.y) * (p.z + 0.5 * p.x).cos();
    0.06 * DVec3::new(wave(p.x) * wave(p.y + p.z), second, wave(p.z - p.x) * wave(p.y))
}

/// Isochoric displacement of similar magnitude: two successive shears, det F = 1 exactly.
fn isochoric(p: DVec3) -> DVec3 {
    0.1 * DVec3::new(wave(p.y) * wave(2.0 * p.z), wave(1.5 * p.z), 0.0)
}

/// Returns the deformation gradient of `field` at `p` by central differences of fourth order.
fn gradient(field: Field, p: DVec3) -> DMat3 {
    let h = 1e-3;
    let along = |e: DVec3| {
        let d = |k: f64| field(p + e * (k * h));
        ((d(1.0) - d(-1.0)) * 8.0 - (d(2.0) - d(-2.0))) / (12.0 * h)
    };
    DMat3::from_cols(along(DVec3::X), along(DVec3::Y), along(DVec3::Z)) + DMat3::IDENTITY
}

/// Returns the first Piola-Kirchhoff stress of the law at `f`.
fn stress(law: &dyn Material, f: &DMat3) -> DMat3 {
    let kind = law.dilatation();
    law.distortional_stress(f) + kind.gradient(f) * law.volumetric(kind.value(f))[1]
}

/// Returns barycentric points and weights (for unit volume) exact to degree 5: Gauss-Legendre on a collapsed cube.
fn quadrature() -> Vec<([f64; 4], f64)> {
    let inner = (3.0 / 7.0 - 2.0 / 7.0 * 1.2f64.sqrt()).sqrt();
    let outer = (3.0 / 7.0 + 2.0 / 7.0 * 1.2f64.sqrt()).sqrt();
    let (wi, wo) = ((18.0 + 30f64.sqrt()) / 72.0, (18.0 - 30f64.sqrt()) / 72.0);
    let line = [(-outer, wo), (-inner, wi), (inner, wi), (outer, wo)].map(|(x, w)| (0.5 * (1.0 + x), w));
    let mut rule = Vec::new();
    for (u, wu) in line {
        for (v, wv) in line {
            for (w, ww) in line {
                let l = [u, v * (1.0 - u), w * (1.0 - u) * (1.0 - v)];
                let weight = 6.0 * wu * wv * ww * (1.0 - u).powi(2) * (1.0 - v);
                rule.push(([1.0 - l[0] - l[1] - l[2], l[0], l[1], l[2]], weight));
            }
        }
    }
    rule
}

/// Returns the shape functions and their barycentric derivatives at `l`.
fn shape(nodes: usize, l: &[f64; 4]) -> Vec<(f64, [f64; 4])> {
    let unit = |k: usize, v: f64| std::array::from_fn(|j| if j == k { v } else { 0.0 });
    if nodes == 4 {
        return (0..4).map(|k| (l[k], unit(k, 1.0))).collect();
    }
    let corners = (0..4).map(|k| (l[k] * (2.0 * l[k] - 1.0), unit(k, 4.0 * l[k] - 1.0)));
    let middles = EDGES.iter().map(|&[i, j]| {
        let mut d = [0.0; 4];
        (d[i], d[j]) = (4.0 * l[j], 4.0 * l[i]);
        (4.0 * l[i] * l[j], d)
    });
    corners.chain(middles).collect()
}

/// Returns the relative L2 error of the displacement on a cube with `n` cells per side.
fn error(field: Field, n: usize, quadratic: bool, mean_dilatation: bool, poisson: f64) -> f64 {
    let lines: Vec<f64> = (0..=n).map(|i| i as f64 / n as f64).collect();
    let mesh = grid::structured([&lines, &lines, &lines]).expect("grid");
    let (rest, elements) = elements(&mesh, quadratic);
    let lists: Vec<Vec<u32>> = match &elements {
        Elements::Linear(e) => e.iter().map(|n| n.to_vec()).collect(),
        Elements::Quadratic(e) => e.iter().map(|n| n.to_vec()).collect(),
    };
    let law: Arc<dyn Material> = Arc::new(NeoHookean::new(1.0, poisson));
    let rule = quadrature();
    let at = |tet: &[u32], l: &[f64; 4]| (0..4).map(|k| rest[tet[k] as usize] * l[k]).sum::<DVec3>();
    // Nodal forces of the body force by integration by parts: virtual work of the exact stress.
    let mut load = vec![DVec3::ZERO; rest.len()];
    for tet in &lists {
        let geometry = RestTet::new(std::array::from_fn(|k| rest[tet[k] as usize]));
        for (l, weight) in &rule {
            let p = stress(law.as_ref(), &gradient(field, at(tet, l)));
            for (&node, (_, d)) in tet.iter().zip(shape(tet.len(), l)) {
                let slope: DVec3 = (0..4).map(|k| geometry.gradient[k] * d[k]).sum();
                load[node as usize] += p * slope * (weight * geometry.volume);
            }
        }
    }
    let outside = |p: &DVec3| p.min_element() < 1e-9 || p.max_element() > 1.0 - 1e-9;
    let fixed = rest.iter().map(outside).collect();
    let body = Body::new(rest.clone(), elements, fixed, law.clone(), mean_dilatation);
    let terms: Vec<Box<dyn BodyTerm>> = vec![Box::new(ElasticEnergy), Box::new(NodalLoads(load))];
    let mut newton = Newton::new(vec![Arc::new(body)], vec![terms], RigidUnknowns::none(1)).expect("solver");
    let x = rest.iter().map(|p| *p + field(*p)).collect();
    let start = State { x: vec![x], travel: vec![0.0], position: DVec3::ZERO, rotation: DQuat::IDENTITY };
    let tolerance = NewtonTolerance {
        relative: 0.0,
        force: 1e-9,
        length: 1e-8,
        iterations: 40,
        max_motion: 1e3,
        intermediate: false,
        offset: 1e-5,
    };
    let (state, _) = newton.solve(&start.clone(), start, &tolerance).expect("converges");
    let (mut wrong, mut right) = (0.0, 0.0);
    for tet in &lists {
        let volume = RestTet::new(std::array::from_fn(|k| rest[tet[k] as usize])).volume;
        for (l, weight) in &rule {
            let exact = field(at(tet, l));
            let ours: DVec3 = tet
                .iter()
                .zip(shape(tet.len(), l))
                .map(|(&i, (phi, _))| (state.x[0][i as usize] - rest[i as usize]) * phi)
                .sum();
            wrong += weight * volume * (ours - exact).length_squared();
            right += weight * volume * exact.length_squared();
        }
    }
    (wrong / right).sqrt()
}

/// Computes the errors on meshes of `cells`, each refined by two, and returns the order between the last two.
fn order(name: &str, field: Field, cells: [usize; 3], quadratic: bool, mean_dilatation: bool, poisson: f64) -> f64 {
    let errors = cells.map(|n| error(field, n, quadratic, mean_dilatation, poisson));
    let orders = [0, 1].map(|k| (errors[k] / errors[k + 1]).log2());
    println!("{name}: errors {}, orders {orders:.2?}", errors.map(|e| format!("{e:.2e}")).join(" "));
    orders[1]
}

/// Linear tetrahedra converge by the second order, quadratic ones by the third. With mean dilatation, one pressure per
/// element limits the order to two, also near incompressibility.
#[test]
fn errors_converge_by_the_order_of_the_elements() {
    for (name, field, cells, quadratic, mean_dilatation, poisson, least) in [
        ("linear", general as Field, [4, 8, 16], false, false, 0.3, 1.9),
        ("quadratic", general, [2, 4, 8], true, false, 0.3, 2.8),
        ("mean dilatation, general", general, [2, 4, 8], true, true, 0.3, 1.9),
        ("mean dilatation, isochoric", isochoric, [2, 4, 8], true, true, 0.49, 1.9),
    ] {
        let order = order(&format!("{name}, nu {poisson}"), field, cells, quadratic, mean_dilatation, poisson);
        assert!(order >= least, "{name}, nu {poisson}: observed order {order}, at least {least}");
    }
}
