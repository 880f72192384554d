//! Python module `diptych._engine`: simulations of the library, and the command line of the program.

mod columns;
mod moving;
mod own_drag;
mod scene;
mod simulation;

use pyo3::prelude::*;
use std::ffi::OsString;

pyo3::import_exception!(diptych.errors, InputError);
pyo3::import_exception!(diptych.errors, RunError);

/// Runs the program with the arguments of a command line, the first of which is the name of the program. Returns the
/// exit code.
#[pyfunction]
fn main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| diptych::program::main(arguments))
}

/// Simulations of diptych, and its command line.
#[pymodule]
fn _engine(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(main, module)?)?;
    module.add_class::<simulation::Simulation>()?;
    module.add_class::<columns::ParticleColumn>()
}
