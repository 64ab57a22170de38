//! Gradients of every layer of the networks against central differences, to a relative 1e-6 in f64 and 1e-3 in f32.

use glam::{DMat3, DVec3};
use std::sync::Arc;
use tactus::base::random::Random;
use tactus::net::autodiff::ops::{
    Activation, apply, balanced, deviatoric_stress, displaced, layer_norm, linear, product, reshape, respond,
    root_error, share, sum, von_mises,
};
use tactus::net::autodiff::real::Real;
use tactus::net::autodiff::tape::{Matrix, Tape};
use tactus::net::linear_response::balance::{ObjectBalance, PadLoad};
use tactus::net::linear_response::compliance::Compliance;
use tactus::net::linear_response::deviator::{Deviator, PARTS};
use tactus::net::matrix::Sparse;

fn numbers(random: &mut Random, n: usize) -> Vec<f32> {
    (0..n).map(|_| (2.0 * random.unit() - 1.0) as f32).collect()
}

fn constants<T: Real>(random: &mut Random, n: usize) -> Vec<T> {
    numbers(random, n).into_iter().map(T::of).collect()
}

/// Compares directional derivatives along a random direction per parameter, relative to the norm of the gradient.
fn compare<T: Real>(
    name: &str,
    (step, tolerance): (f32, f64),
    shapes: &[(usize, usize)],
    f: impl Fn(&Tape<T>, &[Matrix<T>]) -> Matrix<T>,
) {
    let mut random = Random::new(7);
    let mut parameters: Vec<Matrix<T>> =
        shapes.iter().map(|(r, c)| Matrix::parameter(*r, *c, constants(&mut random, r * c))).collect();
    // With a random target every output contributes to the loss.
    let out = f(&Tape::silent(), &parameters);
    let target = numbers(&mut random, out.rows * out.cols);
    let weight: Vec<f32> = (0..out.rows).map(|_| 0.5 + random.unit() as f32).collect();
    let loss = |tape: &Tape<T>, p: &[Matrix<T>]| root_error(tape, &f(tape, p), &target, &weight, out.rows);
    let tape = Tape::recording();
    let value = loss(&tape, &parameters);
    let gradients = tape.backward(&value, &parameters);
    for k in 0..parameters.len() {
        let direction: Vec<T> = constants(&mut random, parameters[k].value().len());
        let along: f64 = gradients[k].iter().zip(&direction).map(|(g, d)| (*g * *d).f64()).sum();
        let start = parameters[k].value().to_vec();
        let mut at = |h: f32| {
            *parameters[k].value_mut() = start.iter().zip(&direction).map(|(x, d)| *x + T::of(h) * *d).collect();
            loss(&Tape::silent(), &parameters).value()[0].f64()
        };
        let h = step;
        // Richardson extrapolation: f32 requires a large step, and a large step a higher order.
        let (near, far) = ((at(h) - at(-h)) / f64::from(2.0 * h), (at(2.0 * h) - at(-2.0 * h)) / f64::from(4.0 * h));
        *parameters[k].value_mut() = start;
        let difference = (4.0 * near - far) / 3.0;
        let length = gradients[k].iter().map(|g| g.f64().powi(2)).sum::<f64>().sqrt();
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
        check!("linear", &[(5, 4), (4, 3), (1, 3)], |t, p| linear(t, &p[0], &p[1], Some(&p[2]), act));
        check!("linear without bias", &[(5, 4), (4, 3)], |t, p| linear(t, &p[0], &p[1], None, act));
    }
}

#[test]
fn sums_norms_and_shapes() {
    check!("sum", &[(4, 3), (4, 3)], |t, p| sum(t, &[&p[0], &p[1], &p[0]], Activation::Gated));
    check!("layer norm", &[(4, 6), (1, 6), (1, 6)], |t, p| layer_norm(t, &p[0], &p[1], &p[2]));
    check!("product", &[(4, 3), (4, 3)], |t, p| product(t, &p[0], &p[1]));
    check!("von Mises", &[(4, 5)], |t, p| von_mises(t, &p[0]));
    check!("reshape", &[(4, 6)], |t, p| sum(t, &[&reshape(t, &p[0], 8)], Activation::Gated));
}

#[test]
fn sparse_maps_and_shares() {
    let map = Sparse::new(&[vec![(0, 1.0), (2, -0.5)], vec![], vec![(1, 2.0)], vec![(2, 1.0)]], 3);
    check!("sparse, two blocks", &[(6, 3)], |t, p| apply(t, &map, &p[0]));
    check!("sparse, transposed", &[(8, 3)], |t, p| apply(t, &map.transposed(), &p[0]));
    check!("share", &[(8, 3)], |t, p| share(t, &p[0], 4));
}

#[test]
fn balances() {
    let mut random = Random::new(9);
    let mut balance = |force: f64| {
        let mut pad = |x: f64, rotation: DMat3| {
            let mut unit = || random.unit();
            let mut node = || {
                let at = DVec3::new(unit() - 0.5, unit() - 0.5, 0.0);
                (rotation * at + DVec3::X * x, unit())
            };
            PadLoad { force, rotation, nodes: (0..4).map(|_| node()).collect() }
        };
        let pads = [pad(-3.0, DMat3::from_rotation_y(1.5)), pad(3.0, DMat3::from_rotation_y(-1.6))];
        Arc::new(ObjectBalance::new(&pads, [DVec3::new(0.1, 0.2, 0.3), DVec3::Y]))
    };
    let two = [balance(0.5), balance(2.0)];
    for mirror in [[1.0, 1.0], [-1.0, 1.0], [1.0, -1.0]] {
        check!("balance, two levels", &[(16, 3)], |t, p| balanced(t, &p[0], &two, mirror));
    }
}

#[test]
fn linear_responses() {
    // Three nodes, the second one bonded; more loads than are processed in one block.
    let mut random = Random::new(5);
    let (slot, forces) = (vec![Some(0), None, Some(1)], 6);
    let parts = numbers(&mut random, 4 * PARTS).into();
    let deviator = Deviator { start: vec![0, 1, 2, 4], slot: vec![0, 1, 1, 0], parts };
    let response = numbers(&mut random, 6 * forces);
    let pad = Arc::new(Compliance::from_parts(slot, response.clone().into(), forces, deviator));
    check!("response", &[(11, 6)], |t, p| respond(t, &pad, &p[0]));
    check!("displacement", &[(11, 6)], |t, p| displaced(t, &pad, &p[0]));
    check!("stress", &[(11, 6)], |t, p| deviatoric_stress(t, &pad, &p[0]));
    let force = Matrix::constant(11, 6, constants::<f64>(&mut random, 66));
    let moved = respond(&Tape::silent(), &pad, &force);
    let dense = Matrix::constant(6, 6, (0..36).map(|i| f64::from(response[i % 6 * 6 + i / 6])).collect());
    let product = linear(&Tape::silent(), &force, &dense, None, Activation::None);
    for (a, b) in moved.value().iter().zip(product.value()) {
        assert!((a - b).abs() < 1e-12, "{a} against {b} from a product of matrices");
    }
}

#[test]
fn shares_sum_to_one() {
    let mut random = Random::new(3);
    let x = Matrix::constant(10, 3, numbers(&mut random, 30));
    let y = share(&Tape::silent(), &x, 5);
    for group in y.value().chunks_exact(15) {
        let sum: f32 = group.iter().step_by(3).sum();
        assert!((sum - 1.0).abs() < 1e-6, "the shares of a finger's force sum to {sum}");
    }
}

#[test]
fn a_matrix_used_twice_collects_both_gradients() {
    // The gradients of all branches that use the matrix must be added.
    check!("reuse", &[(3, 3)], |t, p| {
        let a = linear(t, &p[0], &p[0], None, Activation::Gated);
        sum(t, &[&a, &p[0]], Activation::None)
    });
}
