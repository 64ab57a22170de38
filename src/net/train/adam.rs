//! State of dfdx's Adam (Kingma and Ba 2015), kept outside of it so that training resumes exactly.

use crate::autodiff::tensor::Values;
use crate::network::parameters::Parameters;
use dfdx::prelude::{Cpu, HasShape, Shape, Storage};
use dfdx::tensor_ops::AdamConfig;

/// State of the optimiser.
#[derive(Debug, Clone)]
pub struct Adam {
    /// Number of steps taken.
    pub step: u64,
    /// First moments, in the order of the parameters.
    pub first: Vec<Values<f32>>,
    /// Second moments.
    pub second: Vec<Values<f32>>,
}

impl Adam {
    /// Creates the state before the first step.
    pub fn new(parameters: &Parameters) -> Self {
        let zeros = || {
            let lengths = parameters.matrices.iter().map(|m| m.shape().num_elements());
            lengths.map(|n| Cpu::default().try_alloc_len(n).expect("memory for the moments")).collect()
        };
        Self { step: 0, first: zeros(), second: zeros() }
    }

    /// Takes one step with learning rate `rate` against `gradients`.
    pub fn update(&mut self, parameters: &mut Parameters, gradients: &[Values<f32>], rate: f64) {
        let config = AdamConfig { lr: rate, ..AdamConfig::default() };
        self.step += 1;
        let step = i32::try_from(self.step).unwrap_or(i32::MAX);
        let moments = self.first.iter_mut().zip(&mut self.second);
        for ((matrix, gradient), (first, second)) in parameters.matrices.iter_mut().zip(gradients).zip(moments) {
            config.try_update(step, matrix, first, second, gradient).expect("an update on the CPU allocates nothing");
        }
    }
}
