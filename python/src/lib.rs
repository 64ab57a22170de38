//! Python bindings of tactus: the compiled half of the package `tactus`.

mod arrays;
mod batch;
mod command;
mod dataset;
mod inputs;
mod predict;
mod progress;
mod run;
mod scene;
mod supervise;

use mimalloc::MiMalloc;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

#[global_allocator]
static ALLOCATOR: MiMalloc = MiMalloc;

/// What went wrong, as Python's `ValueError`. An option of the command line is an argument in Python: `--max-time` is `max_time`.
fn refused(error: impl std::fmt::Display) -> PyErr {
    let text = error.to_string();
    let mut parts = text.split("--");
    let mut said = parts.next().unwrap_or_default().to_string();
    for part in parts {
        let name = part.find(|c: char| !(c.is_ascii_lowercase() || c == '-')).unwrap_or(part.len());
        let whole = said.ends_with([' ', '`', '(', '\'']) || said.is_empty();
        if whole && name > 0 {
            said += &part[..name].replace('-', "_");
            said += &part[name..];
        } else {
            said += "--";
            said += part;
        }
    }
    PyValueError::new_err(said)
}

#[pymodule]
fn _tactus(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<batch::Batch>()?;
    module.add_class::<dataset::Files>()?;
    module.add_function(wrap_pyfunction!(command::command, module)?)?;
    module.add_class::<inputs::FaceInputs>()?;
    module.add_function(wrap_pyfunction!(dataset::make, module)?)?;
    module.add_function(wrap_pyfunction!(inputs::face_weights, module)?)?;
    module.add_function(wrap_pyfunction!(predict::predict, module)?)?;
    module.add_function(wrap_pyfunction!(run::run, module)?)?;
    module.add_function(wrap_pyfunction!(scene::objects, module)?)?;
    module.add_function(wrap_pyfunction!(scene::resolved, module)?)?;
    Ok(())
}
