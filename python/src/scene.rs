//! Reads cases that Python gives as a path, a text or a dict, and initial states that it gives as arrays.

use crate::InputError;
use diptych::case::Case;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyMapping};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Reads a case either from `case` (a path, the name of a built-in case, or a dict) or from its text (`text`). `sets`
/// are changes of keys in the form `key=value`. `start` has arrays with the properties of the particles at the start,
/// by the names of these properties in `diptych.scenes.start_table`; `None` if the case gives the start.
///
/// # Errors
/// `InputError` with the message of the reader, if the case or the start is not valid. `ValueError` unless exactly one
/// of `case` and `text` is given.
pub fn read(
    py: Python<'_>,
    (case, text): (Option<Bound<'_, PyAny>>, Option<&str>),
    sets: &[String],
    start: Option<&Bound<'_, PyDict>>,
) -> PyResult<Case> {
    let scenes = py.import("diptych.scenes")?;
    let start = start.filter(|start| !start.is_empty());
    let refused = |why: diptych::case::Diagnostic| InputError::new_err(why.to_string());
    let read = match (case, text) {
        (Some(case), None) => match case.cast::<PyMapping>() {
            Ok(values) => {
                let own = |name| start.map(|start| start.get_item(name)).transpose().map(Option::flatten);
                let text: String =
                    scenes.call_method1("case_text", (values, own("radii")?, own("species")?))?.extract()?;
                Case::from_values(text.into(), sets)
            }
            Err(_) => Case::read(&case.extract::<PathBuf>()?, sets),
        },
        (None, Some(text)) => Case::from_text(Path::new("case.toml"), text.into(), sets),
        _ => return Err(PyValueError::new_err("give a case or its text")),
    };
    let case = read.map_err(refused)?;
    let Some(start) = start else { return Ok(case) };
    let table: String = scenes.call_method("start_table", (), Some(start))?.extract()?;
    case.with_start(Arc::from(table)).map_err(refused)
}
