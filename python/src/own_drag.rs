//! A drag law written in Python, which is called once per window. A window is the time between two exchanges of
//! momentum with the gas. A kick is a change of the velocities without motion; a half-kick is the kick for half a
//! window.
//!
//! A window begins and ends with a half-kick by this law. The half-kick at the end needs the accelerations at the end,
//! which depend on the velocities after this half-kick. The half-kick is therefore made with the accelerations of the
//! previous call first (prediction). After the next call of the function, the difference is added (correction). This is
//! the velocity-Verlet scheme with predicted velocities of Groot and Warren (1997), J. Chem. Phys. 107, 4423. Their
//! factor λ is 1: the prediction covers the whole window. The scheme is of second order in the window.

use crate::moving::RunEnd;
use diptych::{Particles, Vector3};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

/// [-] largest remainder of a run after a window, divided by the length of this window, that is computed together with
/// the window. Such remainders are left by rounding.
const REST: f64 = 1e-6;

/// Drag law as a function of Python that returns the accelerations of the particles, with the accelerations of its
/// latest call.
pub struct OwnDrag {
    /// Function of Python that is called with the simulation.
    pub function: Py<PyAny>,
    /// [m/s²] accelerations of the latest call, by the ids of the particles. Particles that have entered the box since
    /// this call have no entry.
    pub by_id: Vec<Vector3<f64>>,
    /// True if the stored accelerations belong to the present time, so that the function need not be called.
    pub is_current: bool,
    /// [s] duration of the predicted half-kick (change of velocities in half a window) that is corrected after the next
    /// call; 0 if no half-kick was predicted.
    pub predicted: f64,
}

impl OwnDrag {
    /// Stores a function of Python. The function is called for the first time before the next window (time between two
    /// exchanges with the gas).
    ///
    /// # Errors
    /// `TypeError` if the object cannot be called.
    pub fn new(function: Bound<'_, PyAny>) -> PyResult<Self> {
        if !function.is_callable() {
            return Err(PyTypeError::new_err("drag is a function of the simulation, or None"));
        }
        Ok(Self { function: function.unbind(), by_id: Vec::new(), is_current: false, predicted: 0.0 })
    }

    /// Stores the accelerations `rows` [m/s²] of a call, in the order of `particles`. Returns the differences from the
    /// accelerations of the previous call [m/s²], by the ids of the particles.
    pub fn keep(&mut self, particles: &Particles, rows: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let most = particles.id.iter().max().map_or(0, |id| *id as usize + 1);
        let last = std::mem::replace(&mut self.by_id, vec![Vector3::zeros(); most]);
        for (id, row) in particles.id.iter().zip(rows) {
            self.by_id[*id as usize] = *row;
        }
        self.is_current = true;
        let differences = self.by_id.iter().enumerate();
        differences.map(|(id, row)| row - last.get(id).copied().unwrap_or_default()).collect()
    }
}

/// Next piece of a run that ends at `end`: a window (time between two exchanges with the gas), or the part of a window
/// up to the end of the run. Returns the piece with its length [s], or `None` at the end of the run.
///
/// # Errors
/// `ValueError` if the case has no windows.
pub fn next_piece(simulation: &diptych::Simulation, end: RunEnd) -> PyResult<Option<(RunEnd, f64)>> {
    let window = simulation.end_of_window().map(|end| (end, end - simulation.time));
    let (window_end, window) = window.ok_or_else(|| PyValueError::new_err("the case lasts 0 s and has no windows"))?;
    Ok(match end {
        RunEnd::Time(time) if time <= simulation.time => None,
        RunEnd::Time(time) if time - window_end <= REST * window => Some((end, time - simulation.time)),
        RunEnd::Time(_) | RunEnd::Window => Some((RunEnd::Window, window)),
    })
}

/// [m/s²] accelerations from an array of numpy, which must have three numbers for each of the `particles`.
///
/// # Errors
/// `ValueError` if the array has another shape, or if a number is not finite.
pub fn rows_of_three(found: &Bound<'_, PyAny>, particles: &Particles) -> PyResult<Vec<Vector3<f64>>> {
    let array = found.py().import("numpy")?.call_method1("ascontiguousarray", (found, "<f8"))?;
    let shape: Vec<usize> = array.getattr("shape")?.extract()?;
    if shape != [particles.len(), 3] {
        let wanted = particles.len();
        return Err(PyValueError::new_err(format!("drag returned an array of shape {shape:?}, not [{wanted}, 3]")));
    }
    let bytes = array.call_method0("tobytes")?;
    let number = |bytes: &[u8]| bytes.try_into().map_or(f64::NAN, f64::from_le_bytes);
    let numbers: Vec<f64> = bytes.cast::<PyBytes>()?.as_bytes().chunks_exact(8).map(number).collect();
    let rows: Vec<Vector3<f64>> = numbers.chunks_exact(3).map(Vector3::from_column_slice).collect();
    if let Some(place) = rows.iter().position(|row| !row.iter().all(|number| number.is_finite())) {
        let (id, row) = (particles.id[place], rows[place]);
        let message = format!("drag returned ({}, {}, {}) m/s^2 for the particle {id}", row.x, row.y, row.z);
        return Err(PyValueError::new_err(message));
    }
    Ok(rows)
}
