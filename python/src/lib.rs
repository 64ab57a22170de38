//! Python bindings of tactus: the compiled half of the package `tactus`.

mod batch;
mod dataset;
mod inputs;
mod predict;
mod run;
mod supervise;

use mimalloc::MiMalloc;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

#[global_allocator]
static ALLOCATOR: MiMalloc = MiMalloc;

/// What went wrong, as Python's `ValueError`.
fn refused(error: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

#[pymodule]
fn _tactus(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<batch::Batch>()?;
    module.add_class::<dataset::DataSet>()?;
    module.add_class::<inputs::FaceInputs>()?;
    module.add_function(wrap_pyfunction!(dataset::make, module)?)?;
    module.add_function(wrap_pyfunction!(inputs::face_weights, module)?)?;
    module.add_function(wrap_pyfunction!(predict::predict, module)?)?;
    module.add_function(wrap_pyfunction!(run::objects, module)?)?;
    module.add_function(wrap_pyfunction!(run::resolved, module)?)?;
    module.add_function(wrap_pyfunction!(run::run, module)?)?;
    Ok(())
}
