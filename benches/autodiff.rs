//! Cost of the layers of a training step, forward and backward on one thread, as dfdx has them and as operations of our
//! own on its tape, for a graph of 1,500 nodes and 12,000 edges with 48 values each: `cargo bench --bench autodiff`.

use dfdx::prelude::{
    Axis, BroadcastTo, Cpu, GatherTo, HasShape, MeanTo, PutTape, ReshapeTo, Shape, SumTo, TensorFromVec, TryMatMul,
};
use std::hint::black_box;
use std::time::Instant;
use tactus::base::random::Random;
use tactus::net::autodiff::ops::{Activation, layer_norm, linear, sparse_product, von_mises};
use tactus::net::autodiff::tensor::{Matrix, SharedTape, gradients, matrix, values};
use tactus::net::matrix::Sparse;
use tactus::net::network::layers::force_fractions;
use tactus::net::train::loss::bounded_relative_error;

const NODES: usize = 1500;
const EDGES: usize = 12_000;
const WIDTH: usize = 48;

/// Matrix with a tape.
type Traced = Matrix<f32, SharedTape>;
/// Function of matrices with a tape.
type Layer<'a> = &'a dyn Fn(&[Traced]) -> Traced;

/// Returns a random matrix.
fn random(rows: usize, cols: usize, seed: u64) -> Matrix {
    let mut random = Random::new(seed);
    matrix(rows, cols, (0..rows * cols).map(|_| (2.0 * random.uniform() - 1.0) as f32).collect())
}

/// Returns the shortest of nine times, ms.
fn shortest(once: impl Fn()) -> f64 {
    let time = || {
        let start = Instant::now();
        once();
        1e3 * start.elapsed().as_secs_f64()
    };
    (0..9).map(|_| time()).fold(f64::INFINITY, f64::min)
}

/// Returns the time of a pass, forward and backward, ms, and its result.
fn pass(inputs: &[Matrix], layer: Layer) -> (f64, Vec<f32>) {
    let traced = || {
        let tape = SharedTape::default();
        layer(&inputs.iter().map(|x| x.clone().put_tape(tape.clone())).collect::<Vec<_>>())
    };
    let time = shortest(|| drop(black_box(gradients(traced().mean(), inputs))));
    (time, values(&traced()))
}

/// Prints a line of the table; a layer that has no operation of our own is used as dfdx has it.
fn line(name: &str, inputs: &[Matrix], stock: Layer, own: Option<Layer>) {
    let (slow, a) = pass(inputs, stock);
    let Some(own) = own else { return println!("| {name} | {slow:.2} | | dfdx | |") };
    let (fast, b) = pass(inputs, own);
    let apart = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    println!("| {name} | {slow:.2} | {fast:.2} | own, {:.1} times as fast | {apart:.0e} |", slow / fast);
}

/// Gated unit of dfdx's operations.
fn gated(z: Traced) -> Traced {
    let root = (z.clone().square() + 1.0).sqrt();
    (z.clone() / root + 1.0) * z * 0.5
}

/// Returns a row (1, m) repeated to (n, m).
fn wide(row: &Matrix, rows: usize) -> Matrix {
    let (_, m) = *row.shape();
    row.clone().reshape_like(&(m,)).broadcast_like::<_, Axis<0>>(&(rows, m))
}

fn main() {
    println!("| layer | dfdx, ms | own, ms | used | largest difference |\n|---|---|---|---|---|");
    for (name, rows) in [("nodes", NODES), ("edges", EDGES)] {
        let inputs = [random(rows, WIDTH, 1), random(WIDTH, WIDTH, 2), random(1, WIDTH, 3), random(rows, WIDTH, 4)];
        let [_, w, b, _] = &inputs;
        line(
            &format!("linear layer and another term, gated; {name}"),
            &inputs,
            &|x| gated(x[0].clone().matmul(w.clone()) + x[3].clone() + wide(b, rows)),
            Some(&|x| linear(x[0].clone(), w, Some(b), vec![x[3].clone()], Activation::Gated)),
        );
        line(
            &format!("layer normalisation; {name}"),
            &inputs[..1],
            &|x| x[0].clone().normalize::<Axis<1>>(1e-5) * wide(b, rows) + wide(b, rows),
            Some(&|x| layer_norm(x[0].clone(), b, b)),
        );
        let two = [random(rows, WIDTH, 1), random(rows, WIDTH, 2)];
        line(&format!("residual; {name}"), &two, &|x| x[0].clone() + x[1].clone(), None);
    }
    let ends: Vec<usize> = (0..EDGES).map(|e| e * 7 % NODES).collect();
    let gather = Sparse::gather(ends.iter().copied(), NODES);
    let index = Cpu::default().tensor_from_vec(ends, (EDGES,));
    line(
        "nodes gathered at edges",
        &[random(NODES, WIDTH, 1)],
        &|x| x[0].clone().gather(index.clone()),
        Some(&|x| sparse_product(&gather, x[0].clone())),
    );
    let field = [random(12 * NODES, 3, 1), random(12 * NODES, 3, 2)];
    line("product of fields", &field, &|x| x[0].clone() * x[1].clone(), None);
    line(
        "loss of a field",
        &field[..1],
        &|x| {
            let rows = x[0].shape().0;
            let loss = bounded_relative_error(x[0].clone(), vec![0.0; 3 * rows], vec![1.0; rows], 12);
            loss.reshape_like(&(1, 1))
        },
        None,
    );
    line("shares of a force", &[random(NODES, 3, 1)], &|x| force_fractions(x[0].clone(), NODES / 10), None);
    let form = |i: usize| {
        if i / 5 == i % 5 {
            3.0
        } else if matches!(i, 1 | 5) {
            1.5
        } else {
            0.0
        }
    };
    let form = matrix(5, 5, (0..25).map(form).collect());
    line(
        "von Mises stress",
        &[random(12 * NODES, 5, 1)],
        &|x| {
            let square = (x[0].clone().matmul(form.clone()) * x[0].clone()).sum::<(usize,), Axis<1>>();
            (square + 1e-12).sqrt().reshape_like(&(12 * NODES, 1))
        },
        Some(&|x| von_mises(x[0].clone())),
    );
    let x = random(EDGES, WIDTH, 1);
    let numbers = x.shape().num_elements();
    let [iterated, copied] = [shortest(|| drop(black_box(x.as_vec()))), shortest(|| drop(black_box(values(&x))))];
    println!("| reading {numbers} numbers | {iterated:.2} | {copied:.2} | a copy of the memory | 0 |");
}
