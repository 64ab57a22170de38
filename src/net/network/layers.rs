//! Layers that networks share: which parameters they have, and what they compute.

use super::parameters::{ParameterBuilder, ParameterId, Parameters};
use crate::autodiff::ops::{Activation, layer_norm, linear};
use crate::autodiff::tensor::{Matrix, Real, Tape, row};
use dfdx::prelude::{Axis, BroadcastTo, HasShape, ReshapeTo};

/// Linear layer `x W + b`, or `x W`.
#[derive(Debug, Clone, Copy)]
pub struct LinearLayer {
    weight: ParameterId,
    bias: Option<ParameterId>,
}

impl LinearLayer {
    /// Creates the layer `name.weight` (rows, cols) and `name.bias`, with a gain for [`ParameterBuilder::weight`] and
    /// an initial bias.
    pub fn new<E: Real>(
        maker: &mut ParameterBuilder<E>,
        name: &str,
        shape: (usize, usize),
        gain: f64,
        bias: f32,
    ) -> Self {
        Self::named(maker, [&format!("{name}.weight"), &format!("{name}.bias")], shape, gain, bias)
    }

    /// Creates the layer as [`Self::new`] does, with the parameters `weight` and `bias`.
    pub fn named<E: Real>(
        maker: &mut ParameterBuilder<E>,
        [weight, bias]: [&str; 2],
        shape: (usize, usize),
        gain: f64,
        start: f32,
    ) -> Self {
        let weight = Self::without_bias(maker, weight, shape, gain);
        Self { bias: Some(maker.row(bias, shape.1, start)), ..weight }
    }

    /// Creates the layer with the weight `name` and no bias.
    pub fn without_bias<E: Real>(
        maker: &mut ParameterBuilder<E>,
        name: &str,
        (rows, cols): (usize, usize),
        gain: f64,
    ) -> Self {
        Self { weight: maker.weight(name, rows, cols, gain), bias: None }
    }

    /// Computes the output for x (n, rows): (n, cols).
    pub fn apply<E: Real, T: Tape<E>>(self, p: &Parameters<E>, x: Matrix<E, T>) -> Matrix<E, T> {
        self.apply_with_terms(p, x, Vec::new(), Activation::None)
    }

    /// Computes the activation of the output.
    pub fn apply_activated<E: Real, T: Tape<E>>(
        self,
        p: &Parameters<E>,
        x: Matrix<E, T>,
        act: Activation,
    ) -> Matrix<E, T> {
        self.apply_with_terms(p, x, Vec::new(), act)
    }

    /// Computes the activation of the sum of the output and other `terms` (n, cols).
    pub fn apply_with_terms<E: Real, T: Tape<E>>(
        self,
        p: &Parameters<E>,
        x: Matrix<E, T>,
        terms: Vec<Matrix<E, T>>,
        act: Activation,
    ) -> Matrix<E, T> {
        linear(x, p.get(self.weight), self.bias.map(|bias| p.get(bias)), terms, act)
    }
}

/// Layer normalisation with a gain and a shift.
#[derive(Debug, Clone, Copy)]
pub struct LayerNorm {
    gain: ParameterId,
    shift: ParameterId,
}

impl LayerNorm {
    /// Creates the layer for rows of `cols` values, with the parameters `name.gain` and `name.shift`.
    pub fn new<E: Real>(maker: &mut ParameterBuilder<E>, name: &str, cols: usize) -> Self {
        let gain = maker.row(&format!("{name}.gain"), cols, 1.0);
        Self { gain, shift: maker.row(&format!("{name}.shift"), cols, 0.0) }
    }

    /// Computes the output for x (n, cols).
    pub fn apply<E: Real, T: Tape<E>>(self, p: &Parameters<E>, x: Matrix<E, T>) -> Matrix<E, T> {
        layer_norm(x, p.get(self.gain), p.get(self.shift))
    }
}

/// Computes the fractions of the force in every group of `size` rows of x (n, 3): a softmax of column 0, times (1,
/// column 1, column 2).
///
/// The fractions of a group are positive and sum to one, so contact forces made of them sum exactly to the force of the
/// finger.
pub fn force_fractions<E: Real, T: Tape<E>>(x: Matrix<E, T>, size: usize) -> Matrix<E, T> {
    let shape = *x.shape();
    assert!(shape.1 == 3 && shape.0.is_multiple_of(size), "fractions need complete groups of three columns");
    let logits = x.clone().slice((.., 0..1)).reshape_like(&(shape.0 / size, size));
    let fractions = logits.softmax::<Axis<1>>().reshape_like(&(shape.0,)).broadcast_like::<_, Axis<1>>(&shape);
    let [tangential, normal] = [[0.0, 1.0, 1.0], [1.0, 0.0, 0.0]].map(row);
    let wide = |row| BroadcastTo::broadcast_like::<_, Axis<0>>(row, &shape);
    fractions * (x * wide(tangential) + wide(normal))
}
