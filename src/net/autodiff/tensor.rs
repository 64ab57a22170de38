//! Tensors of the network are dfdx tensors of rank two; operations that dfdx lacks are recorded on its tape.
//!
//! A pass has one tape, which all its tensors share: a tensor may be cloned and used several times. Parameters and
//! constants have none; every operation of a tensor with a tape records its own backward kernel there. Without a tape
//! ([`NoneTape`]) nothing is recorded: that is inference.

use dfdx::prelude::{
    Backward, Cpu, Device, Dtype, HasErr, HasShape, Merge, PutTape, SplitTape, Storage, Tape as DfdxTape, TensorFromVec,
};
pub use dfdx::prelude::{Gradients, NoneTape, OwnedTape, Rank0, Tensor};
use std::cell::RefCell;
use std::ops::DerefMut;
use std::rc::Rc;

/// Number type of a tensor: f32 in use, f64 where gradients are checked.
pub trait Real:
    Dtype + num_traits::Float + faer::traits::ComplexField + From<f32> + Into<f64> + std::iter::Sum
{
    /// Device that holds the tensors.
    type Device: Device<Self> + Storage<Self, Vec: DerefMut<Target = Vec<Self>>> + Send + Sync;

    /// Converts `x` exactly.
    fn of(x: f32) -> Self {
        x.into()
    }
}

impl Real for f32 {
    type Device = Cpu;
}

impl Real for f64 {
    type Device = Cpu;
}

/// Memory of a tensor or a gradient.
pub type Values<E> = <<E as Real>::Device as Storage<E>>::Vec;

/// Dense matrix (rows, cols), row-major.
pub type Matrix<E = f32, T = NoneTape> = Tensor<(usize, usize), E, <E as Real>::Device, T>;

/// Tape of a pass: [`SharedTape`] for training, [`NoneTape`] for inference.
pub trait Tape<E: Real>: DfdxTape<E, E::Device> + Clone + 'static {}

impl<E: Real, T: DfdxTape<E, E::Device> + Clone + 'static> Tape<E> for T {}

/// dfdx tape shared by all tensors of a pass.
#[derive(Debug)]
pub struct SharedTape<E: Real = f32>(Rc<RefCell<OwnedTape<E, E::Device>>>);

impl<E: Real> Default for SharedTape<E> {
    fn default() -> Self {
        Self(Rc::default())
    }
}

impl<E: Real> Clone for SharedTape<E> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<E: Real> DfdxTape<E, E::Device> for SharedTape<E> {
    const OWNS_TAPE: bool = true;

    fn add_backward_op<F>(&mut self, operation: F)
    where
        F: 'static + FnOnce(&mut Gradients<E, E::Device>) -> Result<(), <E::Device as HasErr>::Err>,
    {
        self.0.borrow_mut().add_backward_op(operation);
    }
}

impl<E: Real> Merge<NoneTape> for SharedTape<E> {
    fn merge(self, _: NoneTape) -> Self {
        self
    }
}

impl<E: Real> Merge<SharedTape<E>> for SharedTape<E> {
    /// Returns the tape with the operations of both: operations of dfdx may start a tape of their own.
    fn merge(self, other: Self) -> Self {
        if !Rc::ptr_eq(&self.0, &other.0) {
            let both = self.0.take().merge(other.0.take());
            self.0.replace(both);
        }
        self
    }
}

/// Creates a matrix without a tape.
pub fn matrix<E: Real>(rows: usize, cols: usize, values: Vec<E>) -> Matrix<E> {
    E::Device::default().tensor_from_vec(values, (rows, cols))
}

/// Creates a constant row without a tape.
pub fn row<E: Real>(values: impl IntoIterator<Item = f32>) -> Tensor<(usize,), E, E::Device> {
    let values: Vec<E> = values.into_iter().map(E::of).collect();
    let shape = (values.len(),);
    E::Device::default().tensor_from_vec(values, shape)
}

/// Returns a copy of the entries, row-major. `x` must be contiguous, which all results but those of `broadcast` and
/// `permute` are.
pub fn values<E: Real, T: Tape<E>>(x: &Matrix<E, T>) -> Vec<E> {
    let (rows, cols) = *x.shape();
    let mut out = vec![E::default(); rows * cols];
    x.copy_into(&mut out);
    out
}

/// Gradients of a backward pass.
pub struct Grads<'a, E: Real>(&'a mut Gradients<E, E::Device>);

impl<E: Real> Grads<'_, E> {
    /// Returns the gradient of `x`, to be added to.
    pub fn of(&mut self, x: &Matrix<E>) -> &mut [E] {
        self.0.get_or_alloc_mut(x).unwrap_or_else(|e| panic!("a gradient cannot be allocated: {e}"))
    }
}

/// Returns the result of an operation of our own, and records its backward kernel, which takes the gradient of the
/// result and adds to those of the inputs.
pub fn record<E: Real, T: Tape<E>>(
    mut tape: T,
    (rows, cols): (usize, usize),
    result: Vec<E>,
    backward: impl FnOnce(&mut Grads<E>, Vec<E>) + 'static,
) -> Matrix<E, T> {
    let result = matrix(rows, cols, result);
    let key = result.clone();
    tape.add_backward_op(move |gradients| {
        // The kernel runs after those of all uses of the result: its gradient is complete, and not needed again.
        let own = std::mem::take(&mut **gradients.get_or_alloc_mut(&key)?);
        backward(&mut Grads(gradients), own);
        Ok(())
    });
    result.put_tape(tape)
}

/// Returns the gradients of `loss` with respect to `parameters`, in their order; zeros where it does not depend on one.
pub fn gradients<E: Real>(
    loss: Tensor<Rank0, E, E::Device, SharedTape<E>>,
    parameters: &[Matrix<E>],
) -> Vec<Values<E>> {
    let (loss, tape) = loss.split_tape();
    let mut gradients = loss.put_tape(tape.0.take()).backward();
    let mut of = |p: &Matrix<E>| {
        let own: &mut Values<E> = gradients.get_or_alloc_mut(p).expect("memory for a gradient");
        std::mem::replace(own, <E::Device as Storage<E>>::try_alloc_len(p.device(), 0).expect("memory"))
    };
    parameters.iter().map(&mut of).collect()
}
