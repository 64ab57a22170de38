//! Gradients of every layer of the networks against central differences, to a relative 1e-6 in f64 and 1e-3 in f32.

use dfdx::prelude::{HasShape, PutTape, ReshapeTo, TryMatMul};
use glam::{DMat3, DVec3};
use std::sync::Arc;
use tactus::base::random::Random;
use tactus::geometry::Wrench;
use tactus::net::autodiff::ops::{
    Activation, balance_contact_forces, deviatoric_stress, free_displacement, layer_norm, linear, scatter_to_nodes,
    sparse_product, von_mises,
};
use tactus::net::autodiff::tensor::{Matrix, NoneTape, Real, SharedTape, gradients, matrix, values};
use tactus::net::linear_response::balance::{ObjectBalance, PadLoad};
use tactus::net::linear_response::compliance::Compliance;
use tactus::net::linear_response::deviator::{DeviatoricStressMap, PARTS};
use tactus::net::matrix::Sparse;
use tactus::net::network::layers::force_fractions;
use tactus::net::train::loss::bounded_relative_error;

fn numbers(random: &mut Random, n: usize) -> Vec<f32> {
    (0..n).map(|_| (2.0 * random.uniform() - 1.0) as f32).collect()
}

fn constants<E: Real>(random: &mut Random, n: usize) -> Vec<E> {
    numbers(random, n).into_iter().map(E::of).collect()
}

/// Matrix with a tape.
type Traced<E> = Matrix<E, SharedTape<E>>;

/// Compares directional derivatives along a random direction per parameter, relative to the norm of the gradient.
fn compare<E: Real>(
    name: &str,
    (step, tolerance): (f32, f64),
    shapes: &[(usize, usize)],
    f: impl Fn(&[Traced<E>], &[Matrix<E>]) -> Traced<E>,
) {
    let mut random = Random::new(7);
    let mut parameters: Vec<Matrix<E>> =
        shapes.iter().map(|(r, c)| matrix(*r, *c, constants(&mut random, r * c))).collect();
    let pass = |p: &[Matrix<E>]| {
        let tape = SharedTape::default();
        f(&p.iter().map(|p| p.clone().put_tape(tape.clone())).collect::<Vec<_>>(), p)
    };
    // With a random target every output contributes to the loss.
    let (rows, cols) = *pass(&parameters).shape();
    let target = numbers(&mut random, rows * cols);
    let weight: Vec<f32> = (0..rows).map(|_| 0.5 + random.uniform() as f32).collect();
    let loss = |p: &[Matrix<E>]| bounded_relative_error(pass(p), target.clone(), weight.clone(), rows);
    let gradients = gradients(loss(&parameters), &parameters);
    for k in 0..parameters.len() {
        let start = values(&parameters[k]);
        let direction: Vec<E> = constants(&mut random, start.len());
        let along: f64 = gradients[k].iter().zip(&direction).map(|(g, d)| (*g * *d).into()).sum();
        let mut at = |h: f32| -> f64 {
            let moved: Vec<E> = start.iter().zip(&direction).map(|(x, d)| *x + E::of(h) * *d).collect();
            parameters[k].copy_from(&moved);
            loss(&parameters).as_vec()[0].into()
        };
        let h = step;
        // Richardson extrapolation: f32 requires a large step, and a large step a higher order.
        let (near, far) = ((at(h) - at(-h)) / f64::from(2.0 * h), (at(2.0 * h) - at(-2.0 * h)) / f64::from(4.0 * h));
        parameters[k].copy_from(&start);
        let difference = (4.0 * near - far) / 3.0;
        let length = gradients[k].iter().map(|g| Into::<f64>::into(*g).powi(2)).sum::<f64>().sqrt();
        assert!(length > 0.0, "{name}: the gradient of parameter {k} is zero");
        let error = (difference - along).abs() / length;
        assert!(
            error < tolerance,
            "{name}, parameter {k}: difference {difference}, gradient {along}, relative {error:.1e}"
        );
    }
}

/// Checks the same kernels in f64 to 1e-6 and in f32 to 1e-3.
macro_rules! check {
    ($name:expr, $shapes:expr, $f:expr) => {
        compare::<f64>($name, (1e-4, 1e-6), $shapes, $f);
        compare::<f32>($name, (5e-3, 1e-3), $shapes, $f);
    };
}

#[test]
fn linear_layers() {
    for act in [Activation::None, Activation::Gated, Activation::Positive, Activation::Relu] {
        check!("linear", &[(5, 4), (4, 3), (1, 3)], |t, p| linear(t[0].clone(), &p[1], Some(&p[2]), vec![], act));
        check!("linear with terms, one of them twice", &[(5, 4), (4, 3), (5, 3)], |t, p| {
            linear(t[0].clone(), &p[1], None, vec![t[2].clone(), t[2].clone()], act)
        });
    }
}

#[test]
fn norms_and_shapes() {
    check!("layer norm", &[(4, 6), (1, 6), (1, 6)], |t, p| layer_norm(t[0].clone(), &p[1], &p[2]));
    check!("product", &[(4, 3), (4, 3)], |t, _| t[0].clone() * t[1].clone());
    check!("von Mises", &[(4, 5)], |t, _| von_mises(t[0].clone()));
    check!("reshape", &[(10, 3)], |t, _| von_mises(t[0].clone().reshape_like(&(6, 5))));
}

#[test]
fn sparse_maps_and_shares() {
    let map = Sparse::new(&[vec![(0, 1.0), (2, -0.5)], vec![], vec![(1, 2.0)], vec![(2, 1.0)]], 3);
    check!("sparse, two blocks", &[(6, 3)], |t, _| sparse_product(&map, t[0].clone()));
    check!("sparse, transposed", &[(8, 3)], |t, _| sparse_product(&map.transposed(), t[0].clone()));
    check!("share", &[(8, 3)], |t, _| force_fractions(t[0].clone(), 4));
}

#[test]
fn balances() {
    let mut random = Random::new(9);
    let mut balance = |force: f64| {
        let mut pad = |x: f64, rotation: DMat3| {
            let mut unit = || random.uniform();
            let mut node = || {
                let at = DVec3::new(unit() - 0.5, unit() - 0.5, 0.0);
                (rotation * at + DVec3::X * x, unit())
            };
            PadLoad { force, rotation, nodes: (0..4).map(|_| node()).collect() }
        };
        let pads = [pad(-3.0, DMat3::from_rotation_y(1.5)), pad(3.0, DMat3::from_rotation_y(-1.6))];
        Arc::new(ObjectBalance::new(&pads, Wrench { force: DVec3::new(0.1, 0.2, 0.3), torque: DVec3::Y }))
    };
    let two = [balance(0.5), balance(2.0)];
    for mirror in [[1.0, 1.0], [-1.0, 1.0], [1.0, -1.0]] {
        check!("balance, two levels", &[(16, 3)], |t, _| balance_contact_forces(t[0].clone(), &two, mirror));
    }
}

#[test]
fn linear_responses() {
    // Three nodes, the second one bonded; more loads than are processed in one block.
    let mut random = Random::new(5);
    let (slot, forces) = (vec![Some(0), None, Some(1)], 6);
    let parts = numbers(&mut random, 4 * PARTS).into();
    let deviator = DeviatoricStressMap { start: vec![0, 1, 2, 4], slot: vec![0, 1, 1, 0], parts };
    let response = numbers(&mut random, 6 * forces);
    let pad = Arc::new(Compliance::from_parts(slot, response.clone().into(), forces, deviator));
    check!("response", &[(11, 6)], |t, _| free_displacement(&pad, t[0].clone()));
    check!("displacement", &[(11, 6)], |t, _| scatter_to_nodes(&pad, t[0].clone()));
    check!("stress", &[(11, 6)], |t, _| deviatoric_stress(&pad, t[0].clone()));
    let force = matrix(11, 6, constants::<f64>(&mut random, 66));
    let moved = free_displacement(&pad, force.clone());
    let dense = matrix(6, 6, (0..36).map(|i| f64::from(response[i % 6 * 6 + i / 6])).collect());
    let product: Matrix<f64> = force.matmul(dense);
    for (a, b) in values(&moved).iter().zip(values(&product)) {
        assert!((a - b).abs() < 1e-12, "{a} against {b} from a product of matrices");
    }
}

#[test]
fn shares_sum_to_one() {
    let mut random = Random::new(3);
    let y = force_fractions::<f32, NoneTape>(matrix(10, 3, numbers(&mut random, 30)), 5);
    for group in values(&y).chunks_exact(15) {
        let sum: f32 = group.iter().step_by(3).sum();
        assert!((sum - 1.0).abs() < 1e-6, "the shares of a finger's force sum to {sum}");
    }
}

#[test]
fn a_tensor_used_twice_collects_both_gradients() {
    // The gradients of all branches that use the tensor must be added.
    check!("reuse", &[(3, 3)], |t, p| {
        let a = linear(t[0].clone(), &p[0], None, vec![], Activation::Gated);
        a + t[0].clone()
    });
}
