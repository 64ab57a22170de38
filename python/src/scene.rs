//! Resolved scenes for Python.

use crate::refusal::{raised, refused};
use crate::supervise::supervise;
use pyo3::prelude::*;
use tactus::scene::{load_object, load_set, to_ron};

/// Returns the names of the objects of a scene file.
#[pyfunction]
pub fn objects(py: Python<'_>, scene: String) -> PyResult<Vec<String>> {
    let set = supervise(py, Some(1), || load_set(scene))?;
    Ok(set.scenes.iter().map(|s| s.name.as_str().to_string()).collect())
}

/// Returns the scene of one object as RON with all defaults written out.
#[pyfunction]
pub fn resolved(scene: &str, object: Option<&str>) -> PyResult<String> {
    to_ron(&load_object(scene, object).map_err(raised)?.scene).map_err(refused)
}
