//! Python bindings of tactus: the compiled part of the package `tactus`.

mod arrays;
mod batch;
mod command;
mod dataset;
mod inputs;
mod predict;
mod progress;
mod refusal;
mod run;
mod scene;
mod supervise;

use mimalloc::MiMalloc;
use pyo3::prelude::*;
use tactus::net::DEFAULT_MODEL;

#[global_allocator]
static ALLOCATOR: MiMalloc = MiMalloc;

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
    module.add("SHIPPED", (DEFAULT_MODEL,))
}
