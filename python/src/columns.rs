//! Columns of the particle store as numpy arrays that share its memory. The store contains the data of all particles,
//! and a column is one property of each particle.
//!
//! An array shares the ownership of a store, and nothing changes this store as long as the array exists. Before an
//! engine moves particles, the simulation takes the store back if no array uses it. Otherwise the arrays keep the
//! store, and the simulation continues with a copy. So no array points to freed memory, and none is read while an
//! engine writes.

use diptych::{Particles, Vector3};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;

/// Column of a particle store (memory with the data of all particles): one property of each particle.
#[derive(Clone, Copy, Debug)]
pub enum Column {
    /// [m] position of the centre of each particle.
    Position,
    /// [m/s] velocity of the centre of each particle.
    Velocity,
    /// [rad/s] spin (angular velocity) of each particle.
    Spin,
    /// [m] radius of each particle.
    Radius,
    /// [kg] mass of each particle.
    Mass,
    /// Index of the species of each particle.
    Species,
    /// Number by which each particle is identified (id).
    Id,
}

/// Owner of the memory of a numpy array: one column of a particle store. The object has the array interface of numpy,
/// version 3, by which numpy finds the memory.
#[pyclass(frozen, module = "diptych._engine")]
pub struct ParticleColumn {
    particles: Arc<Particles>,
    column: Column,
}

// a vector must be three numbers without gaps in memory, because numpy reads vectors as rows of three numbers
const _: () = assert!(size_of::<Vector3<f64>>() == 3 * size_of::<f64>());

/// Place of a column in memory: address, type of its numbers in the notation of numpy (`f8` is a float of 8 bytes, `u2`
/// an unsigned whole number of 2 bytes), and count of numbers per particle.
fn place(particles: &Particles, column: Column) -> (usize, &'static str, usize) {
    let vectors = |rows: &[Vector3<f64>]| (rows.as_ptr() as usize, "f8", 3);
    match column {
        Column::Position => vectors(&particles.position),
        Column::Velocity => vectors(&particles.velocity),
        Column::Spin => vectors(particles.spins()),
        Column::Radius => (particles.radius.as_ptr() as usize, "f8", 1),
        Column::Mass => (particles.mass.as_ptr() as usize, "f8", 1),
        Column::Species => (particles.species.as_ptr() as usize, "u2", 1),
        Column::Id => (particles.id.as_ptr() as usize, "u4", 1),
    }
}

#[pymethods]
impl ParticleColumn {
    #[getter]
    fn __array_interface__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (address, kind, width) = place(&self.particles, self.column);
        let order = if cfg!(target_endian = "little") { '<' } else { '>' };
        let interface = PyDict::new(py);
        let count = self.particles.len();
        match width {
            1 => interface.set_item("shape", (count,))?,
            _ => interface.set_item("shape", (count, width))?,
        }
        interface.set_item("typestr", format!("{order}{kind}"))?;
        let is_read_only = true;
        interface.set_item("data", (address, is_read_only))?;
        interface.set_item("version", 3)?;
        Ok(interface)
    }
}

/// Array of numpy with one column of the particle store `particles`. The array shares the memory of the store, and
/// Python cannot write into it.
pub fn array<'py>(py: Python<'py>, particles: Arc<Particles>, column: Column) -> PyResult<Bound<'py, PyAny>> {
    let owner = Bound::new(py, ParticleColumn { particles, column })?;
    py.import("numpy")?.call_method1("asarray", (owner,))
}
