//! Layers that networks share: which parameters they have, and what they compute.

use super::parameters::{Id, ParameterBuilder, Parameters};
use crate::autodiff::ops::{Activation, activate, layer_norm};
use crate::autodiff::tensor::{Matrix, Real, Tape};
use dfdx::prelude::TryMatMul;

/// Linear layer `x W + b`, or `x W`.
#[derive(Debug, Clone, Copy)]
pub struct Linear {
    weight: Id,
    bias: Option<Id>,
}

impl Linear {
    /// Creates the layer `name.weight` (rows, cols) and `name.bias`, with a gain for [`ParameterBuilder::weight`] and an
    /// initial bias.
    pub fn new<E: Real>(
        maker: &mut ParameterBuilder<E>,
        name: &str,
        (rows, cols): (usize, usize),
        gain: f64,
        bias: f32,
    ) -> Self {
        let weight = maker.weight(&format!("{name}.weight"), rows, cols, gain);
        Self { weight, bias: Some(maker.row(&format!("{name}.bias"), cols, bias)) }
    }

    /// Creates the layer with the weight `name` and no bias.
    pub fn bare<E: Real>(
        maker: &mut ParameterBuilder<E>,
        name: &str,
        (rows, cols): (usize, usize),
        gain: f64,
    ) -> Self {
        Self { weight: maker.weight(name, rows, cols, gain), bias: None }
    }

    /// Computes the output for x (n, rows): (n, cols).
    pub fn apply<E: Real, T: Tape<E>>(self, p: &Parameters<E>, x: Matrix<E, T>) -> Matrix<E, T> {
        self.activated(p, x, Activation::None)
    }

    /// Computes the activation of the output.
    pub fn activated<E: Real, T: Tape<E>>(
        self,
        p: &Parameters<E>,
        x: Matrix<E, T>,
        act: Activation,
    ) -> Matrix<E, T> {
        let y = x.matmul(p.get(self.weight).clone());
        match (self.bias, act) {
            (None, Activation::None) => y,
            (bias, _) => activate([y], bias.map(|bias| p.get(bias)), act),
        }
    }
}

/// Layer normalisation with a gain and a shift.
#[derive(Debug, Clone, Copy)]
pub struct Norm {
    gain: Id,
    shift: Id,
}

impl Norm {
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
