//! Matrices on a dfdx tape. Every operation of the network records its own backward kernel here.
//!
//! dfdx stores the tape and the gradients. A [`Matrix`] shares its entries, so that kernels read them as a slice
//! without a copy; its empty dfdx tensor only serves as its key among the gradients. Each pass has one tape, owned by
//! [`Tape`] and never by a tensor, so that no operation is recorded on a tape whose backward pass never runs.

use super::real::Real;
use dfdx::prelude::{Backward, Cpu, Gradients, OwnedTape, PutTape, Tape as _, Tensor, TensorFromVec};
use std::cell::RefCell;
use std::sync::Arc;

/// Dense matrix, row-major.
#[derive(Debug, Clone)]
pub struct Matrix<T: Real = f32> {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub cols: usize,
    value: Arc<Vec<T>>,
    name: Tensor<(usize, usize), T, Cpu>,
    tracked: bool,
}

impl<T: Real> Matrix<T> {
    /// Creates a constant matrix (without gradient).
    pub fn constant(rows: usize, cols: usize, value: Vec<T>) -> Self {
        assert_eq!(value.len(), rows * cols, "a matrix holds rows x cols numbers");
        Self { rows, cols, value: Arc::new(value), name: name(cols), tracked: false }
    }

    /// Creates a trainable matrix (with gradient).
    pub fn parameter(rows: usize, cols: usize, value: Vec<T>) -> Self {
        Self { tracked: true, ..Self::constant(rows, cols, value) }
    }

    /// Returns the entries.
    pub fn value(&self) -> &[T] {
        &self.value
    }

    /// Returns the entries for modification; the matrix keeps its identity on the tape.
    pub fn value_mut(&mut self) -> &mut Vec<T> {
        Arc::make_mut(&mut self.value)
    }

    /// Returns true if a gradient is computed for it.
    pub fn tracked(&self) -> bool {
        self.tracked
    }

    /// Returns the same entries, in row-major order, in another shape.
    pub(crate) fn shaped(&self, rows: usize, cols: usize, tracked: bool) -> Self {
        assert_eq!(rows * cols, self.rows * self.cols, "a reshaped matrix keeps its numbers");
        Self { rows, cols, value: self.value.clone(), name: name(cols), tracked }
    }
}

fn name<T: Real>(cols: usize) -> Tensor<(usize, usize), T, Cpu> {
    thread_local!(static DEVICE: Cpu = Cpu::default());
    DEVICE.with(|device| device.tensor_from_vec(Vec::new(), (0, cols)))
}

/// Gradients of a backward pass.
pub struct Grads<'a, T: Real = f32>(&'a mut Gradients<T, Cpu>);

impl<T: Real> Grads<'_, T> {
    /// Returns the gradient of `matrix` to accumulate into; None if it has none.
    pub fn of(&mut self, matrix: &Matrix<T>) -> Option<&mut [T]> {
        if !matrix.tracked {
            return None;
        }
        // On the CPU an allocation fails only by aborting the process.
        let slot = self.0.get_or_alloc_mut(&matrix.name).ok()?;
        slot.resize(matrix.rows * matrix.cols, T::of(0.0));
        Some(slot)
    }

    /// Adds `values` to the gradient of `matrix`, if it has one; the first contribution is moved, not copied.
    pub fn add(&mut self, matrix: &Matrix<T>, values: Vec<T>) {
        if !matrix.tracked {
            return;
        }
        let Ok(slot) = self.0.get_or_alloc_mut(&matrix.name) else { return };
        if slot.is_empty() {
            **slot = values;
        } else {
            slot.iter_mut().zip(values).for_each(|(d, g)| *d += g);
        }
    }
}

/// Record of the operations of a forward pass.
pub struct Tape<T: Real = f32>(Option<RefCell<OwnedTape<T, Cpu>>>);

impl<T: Real> Tape<T> {
    /// Creates a tape for training, which records operations.
    pub fn recording() -> Self {
        Self(Some(RefCell::default()))
    }

    /// Creates a tape for inference, which does not record.
    pub fn silent() -> Self {
        Self(None)
    }

    /// Returns true if the result of an operation on `inputs` has a gradient.
    pub fn tracks(&self, inputs: &[&Matrix<T>]) -> bool {
        self.0.is_some() && inputs.iter().any(|m| m.tracked)
    }

    /// Returns the result of an operation on `inputs`. `backward` takes the gradient of the result and adds to those of
    /// the inputs.
    pub fn result(
        &self,
        inputs: &[&Matrix<T>],
        (rows, cols): (usize, usize),
        value: Vec<T>,
        backward: impl FnOnce(&mut Grads<T>, Vec<T>) + 'static,
    ) -> Matrix<T> {
        let out = Matrix { tracked: self.tracks(inputs), ..Matrix::constant(rows, cols, value) };
        self.record(&out, backward);
        out
    }

    /// Records the backward kernel of `out`.
    pub(crate) fn record(&self, out: &Matrix<T>, backward: impl FnOnce(&mut Grads<T>, Vec<T>) + 'static) {
        let (Some(tape), true) = (&self.0, out.tracked) else { return };
        let name = out.name.clone();
        tape.borrow_mut().add_backward_op(move |gradients| {
            // The backward kernel of a matrix runs after those of all its uses: its gradient is complete and not needed
            // again.
            let own = std::mem::take(&mut **gradients.get_or_alloc_mut(&name)?);
            if !own.is_empty() {
                backward(&mut Grads(gradients), own);
            }
            Ok(())
        });
    }

    /// Returns the gradients of the 1 x 1 matrix `loss` with respect to `parameters`, in their order; zeros where
    /// `loss` does not depend on one.
    pub fn backward(self, loss: &Matrix<T>, parameters: &[Matrix<T>]) -> Vec<Vec<T>> {
        let mut tape = self.0.map(RefCell::into_inner).unwrap_or_default();
        let name = loss.name.clone();
        tape.add_backward_op(move |gradients| {
            **gradients.get_or_alloc_mut(&name)? = vec![T::of(1.0)];
            Ok(())
        });
        let end = Cpu::default().tensor_from_vec(vec![loss.value[0]], ());
        let mut gradients = end.put_tape(tape).backward();
        let mut of = |p: &Matrix<T>| Grads(&mut gradients).of(p).map_or_else(Vec::new, |g| g.to_vec());
        parameters.iter().map(&mut of).collect()
    }
}
