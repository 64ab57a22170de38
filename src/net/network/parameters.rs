//! Parameters of a network: named matrices in a fixed order, their initial values, and their file.

use crate::autodiff::tensor::{Matrix, Real, matrix, values};
use crate::matrix::product::PackedMatrix;
use base::error::{Error, Result};
use base::random::Random;
use dfdx::prelude::{HasShape, Shape};
use safetensors::tensor::{Dtype, SafeTensors, TensorView, serialize};
use std::path::Path;

/// Named matrices, in the order in which the network created them.
#[derive(Debug, Clone)]
pub struct Parameters<E: Real = f32> {
    names: Vec<String>,
    /// Matrices of the parameters.
    pub matrices: Vec<Matrix<E>>,
}

/// Index of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ParameterId(usize);

/// Builder of the parameters of a network, with random initial values.
#[derive(Debug)]
pub struct ParameterBuilder<E: Real = f32> {
    random: Option<Random>,
    parameters: Parameters<E>,
}

impl<E: Real> ParameterBuilder<E> {
    /// Creates a builder. Equal seeds yield equal parameters; without a seed weights are zero, to be loaded from a
    /// file.
    pub fn new(seed: Option<u64>) -> Self {
        Self { random: seed.map(Random::new), parameters: Parameters { names: Vec::new(), matrices: Vec::new() } }
    }

    fn add(&mut self, name: String, rows: usize, cols: usize, value: Vec<E>) -> ParameterId {
        self.parameters.names.push(name);
        self.parameters.matrices.push(matrix(rows, cols, value));
        ParameterId(self.parameters.matrices.len() - 1)
    }

    /// Adds a weight (rows, cols), uniform with variance `gain / rows` (He et al. 2015 for gain 2).
    pub fn weight(&mut self, name: &str, rows: usize, cols: usize, gain: f64) -> ParameterId {
        let limit = (3.0 * gain / rows as f64).sqrt();
        let mut one = || self.random.as_mut().map_or(0.0, |random| 2.0 * random.uniform() - 1.0);
        let value = (0..rows * cols).map(|_| E::of((one() * limit) as f32)).collect();
        self.add(name.into(), rows, cols, value)
    }

    /// Adds a row of equal values.
    pub fn row(&mut self, name: &str, cols: usize, value: f32) -> ParameterId {
        self.add(name.into(), 1, cols, vec![E::of(value); cols])
    }

    /// Returns all parameters.
    pub fn finish(self) -> Parameters<E> {
        self.parameters
    }
}

impl<E: Real> Parameters<E> {
    /// Returns the matrix `id`.
    pub fn get(&self, id: ParameterId) -> &Matrix<E> {
        &self.matrices[id.0]
    }

    /// Returns the matrix with this name.
    ///
    /// # Panics
    /// Panics if there is no such parameter.
    fn named(&self, name: &str) -> &Matrix<E> {
        let at = self.names.iter().position(|n| n == name);
        &self.matrices[at.unwrap_or_else(|| panic!("the network has no parameter `{name}`"))]
    }

    /// Returns a copy of the entries of the matrix with this name, row-major.
    ///
    /// # Panics
    /// Panics if there is no such parameter.
    pub fn entries(&self, name: &str) -> Vec<E> {
        values(self.named(name))
    }

    /// Returns the names, in the order of the matrices.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Returns the number of values in all matrices.
    pub fn count(&self) -> usize {
        self.matrices.iter().map(|m| m.shape().num_elements()).sum()
    }
}

impl Parameters {
    /// Returns the matrix with this name, packed for products.
    ///
    /// # Panics
    /// Panics if there is no such parameter.
    pub fn packed(&self, name: &str) -> PackedMatrix {
        PackedMatrix::new(&self.entries(name), self.named(name).shape().1)
    }

    /// Returns the content of a safetensors file: f32, row-major, (rows, cols).
    ///
    /// # Errors
    /// Fails if the matrices cannot be serialised.
    pub fn to_bytes(&self) -> Result<Vec<u8>> {
        let fail = |e: safetensors::SafeTensorError| Error::Solver(format!("the weights cannot be written: {e}"));
        let bytes: Vec<Vec<u8>> =
            self.matrices.iter().map(|m| values(m).iter().flat_map(|v| v.to_le_bytes()).collect()).collect();
        let views = self.names.iter().zip(&self.matrices).zip(&bytes).map(|((name, m), bytes)| {
            TensorView::new(Dtype::F32, vec![m.shape().0, m.shape().1], bytes).map(|view| (name.clone(), view))
        });
        let views = views.collect::<std::result::Result<Vec<_>, _>>().map_err(fail)?;
        serialize(views, None).map_err(fail)
    }

    /// Loads the values from `bytes`, the content of a file at `path` with exactly these parameters.
    ///
    /// # Errors
    /// Fails if the file is not safetensors, or if its names or shapes differ from those of this network or a number is
    /// not finite.
    pub fn load(&mut self, bytes: &[u8], path: &Path) -> Result<()> {
        let fail = |message: String| Error::file(path, message);
        let file = SafeTensors::deserialize(bytes).map_err(|e| fail(format!("is not a safetensors file: {e}")))?;
        if file.len() != self.names.len() {
            return Err(fail(format!("contains {} tensors, but the network has {}", file.len(), self.names.len())));
        }
        for (name, matrix) in self.names.iter().zip(&mut self.matrices) {
            let view = file.tensor(name).map_err(|_| fail(format!("has no tensor `{name}`")))?;
            let shape = *matrix.shape();
            if view.dtype() != Dtype::F32 || view.shape() != [shape.0, shape.1] {
                return Err(fail(format!("`{name}` is {:?} {:?}, not F32 {shape:?}", view.dtype(), view.shape())));
            }
            let value: Vec<f32> = view.data().as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
            if let Some(bad) = value.iter().find(|v| !v.is_finite()) {
                return Err(fail(format!("`{name}` contains {bad}; weights must be finite")));
            }
            matrix.copy_from(&value);
        }
        Ok(())
    }
}
