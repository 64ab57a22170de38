//! Adam (Kingma and Ba 2015), with accessible moments, so that training resumes exactly.

use crate::network::parameters::Parameters;
use dfdx::tensor_ops::AdamConfig;

/// State of the optimiser.
#[derive(Debug, Clone, PartialEq)]
pub struct Adam {
    /// Number of steps taken.
    pub step: u64,
    /// First moments, one list per parameter.
    pub first: Vec<Vec<f32>>,
    /// Second moments.
    pub second: Vec<Vec<f32>>,
}

impl Adam {
    /// Creates the state before the first step.
    pub fn new(parameters: &Parameters) -> Self {
        let zeros: Vec<Vec<f32>> = parameters.matrices.iter().map(|m| vec![0.0; m.value().len()]).collect();
        Self { step: 0, first: zeros.clone(), second: zeros }
    }

    /// Takes one step with learning rate `rate` against `gradients`.
    pub fn update(&mut self, parameters: &mut Parameters, gradients: &[Vec<f32>], rate: f64) {
        // The constants of dfdx, whose own optimiser does not expose its moments.
        let AdamConfig { betas: [b1, b2], eps, .. } = AdamConfig::default();
        self.step += 1;
        let correct = |b: f64| 1.0 / (1.0 - b.powf(self.step as f64));
        let (c1, c2) = (correct(b1), correct(b2));
        let moments = self.first.iter_mut().zip(&mut self.second);
        for ((matrix, gradient), (m, v)) in parameters.matrices.iter_mut().zip(gradients).zip(moments) {
            let value = matrix.value_mut().iter_mut().zip(gradient);
            for ((x, g), (m, v)) in value.zip(m.iter_mut().zip(v)) {
                let g = f64::from(*g);
                let (first, second) = (b1 * f64::from(*m) + (1.0 - b1) * g, b2 * f64::from(*v) + (1.0 - b2) * g * g);
                (*m, *v) = (first as f32, second as f32);
                *x -= (rate * first * c1 / ((second * c2).sqrt() + eps)) as f32;
            }
        }
    }
}
