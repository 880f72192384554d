//! The Python class `Simulation`.

use crate::columns::{self, Column};
use crate::moving::{Interruption, MovingParticles, RunEnd};
use crate::{InputError, RunError};
use diptych::case::Case;
use diptych::memory;
use diptych::{Experiment, Model, Particles};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, TryLockError};

/// Models by name.
const MODELS: [Model; 4] = [Model::Soft, Model::Hard, Model::Hybrid, Model::Dsmc];

/// One case with one collision model, at rest between the calls that move it.
#[pyclass(frozen, subclass, module = "diptych._engine")]
pub struct Simulation {
    moving: Mutex<MovingParticles>,
    experiment: Experiment,
}

/// Times at which an observer is called.
enum Every {
    Sample,
    Window,
    Seconds(f64),
}

impl Every {
    fn of(every: Option<Bound<'_, PyAny>>) -> PyResult<Self> {
        let Some(every) = every else { return Ok(Self::Sample) };
        let refuse = || PyValueError::new_err("every is \"sample\", \"window\" or a positive number of seconds");
        match every.cast::<PyString>() {
            Ok(word) if word == "sample" => Ok(Self::Sample),
            Ok(word) if word == "window" => Ok(Self::Window),
            Ok(_) => Err(refuse()),
            Err(_) => every.extract().ok().filter(|every: &f64| *every > 0.0).map(Self::Seconds).ok_or_else(refuse),
        }
    }

    /// [s] time of the next call; `begun` [s] is the time at which the run began, `calls` the number of calls so far.
    fn next(&self, simulation: &diptych::Simulation, begun: f64, calls: u64) -> f64 {
        let next = match self {
            Self::Sample => simulation.next_sample(),
            Self::Window => simulation.end_of_window(),
            Self::Seconds(every) => Some(begun + (calls + 1) as f64 * every),
        };
        next.unwrap_or(f64::INFINITY)
    }
}

fn read(case: Option<PathBuf>, text: Option<&str>, sets: &[String]) -> PyResult<Case> {
    let read = match (case, text) {
        (Some(path), None) => Case::read(&path, sets),
        (None, Some(text)) => Case::from_text(Path::new("case.toml"), text.into(), sets),
        _ => return Err(PyValueError::new_err("give a case or its text")),
    };
    read.map_err(|why| InputError::new_err(why.to_string()))
}

fn model_of(name: &str) -> PyResult<Model> {
    let found = MODELS.into_iter().find(|model| model.name() == name);
    let names = MODELS.map(Model::name).join(", ");
    found.ok_or_else(|| PyValueError::new_err(format!("no model is called \"{name}\"; the models are {names}")))
}

impl Simulation {
    /// The particles and their engine, unless another thread moves them. Waiting would hold the interpreter, which the
    /// other thread may need to stop.
    fn at_rest(&self) -> PyResult<MutexGuard<'_, MovingParticles>> {
        self.moving.try_lock().map_err(|why| {
            PyRuntimeError::new_err(match why {
                TryLockError::WouldBlock => "another thread runs this simulation",
                TryLockError::Poisoned(_) => "this simulation was ended by an error of the library",
            })
        })
    }

    fn array<'py>(&self, py: Python<'py>, column: Column) -> PyResult<Bound<'py, PyAny>> {
        columns::array(py, self.particles()?, column)
    }

    fn particles(&self) -> PyResult<Arc<Particles>> {
        self.at_rest()?.lend().map_err(|failure| RunError::new_err(failure.to_string()))
    }

    fn run_to(&self, py: Python<'_>, end: RunEnd) -> PyResult<()> {
        self.at_rest()?.run(py, end).map_err(|why| match why {
            Interruption::Failed(failure) => RunError::new_err(failure.to_string()),
            Interruption::Signal(signal) => signal,
        })
    }
}

#[pymethods]
impl Simulation {
    #[new]
    #[pyo3(signature = (case=None, *, text=None, model=None, set=None, seed=None, threads=None))]
    fn new(
        py: Python<'_>,
        case: Option<PathBuf>,
        text: Option<&str>,
        model: Option<&str>,
        set: Option<&Bound<'_, PyDict>>,
        seed: Option<u64>,
        threads: Option<usize>,
    ) -> PyResult<Self> {
        let sets = set.into_iter().flatten().map(|(key, value)| Ok(format!("{key}={}", value.str()?)));
        let case = read(case, text, &sets.collect::<PyResult<Vec<String>>>()?)?;
        let model = model.map(model_of).transpose()?;
        let checked = case.experiment(model, seed).map_err(|why| InputError::new_err(why.to_string()));
        let (experiment, warnings) = checked?;
        for warning in warnings {
            py.import("warnings")?.call_method1("warn", (warning.to_string(),))?;
        }
        if let Some((why, help)) = memory::refusal(&experiment) {
            return Err(InputError::new_err(format!("error: {why}\nhelp: {help}")));
        }
        let made = py.detach(|| diptych::Simulation::from_start(&experiment));
        let simulation = made.map_err(|why| InputError::new_err(format!("error: {why}")))?;
        let moving = MovingParticles::new(simulation, threads.unwrap_or(0));
        let moving = moving.map_err(|why| PyRuntimeError::new_err(why.to_string()))?;
        Ok(Self { moving: Mutex::new(moving), experiment })
    }

    /// Runs until `time` [s]. `observer(simulation)` is called at every sample of the case, at the end of every window
    /// (`every="window"`), or every so many seconds.
    #[pyo3(signature = (time, observer=None, *, every=None))]
    fn run_until(
        slf: &Bound<'_, Self>,
        time: f64,
        observer: Option<Bound<'_, PyAny>>,
        every: Option<Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let (py, this) = (slf.py(), slf.get());
        if !time.is_finite() {
            return Err(PyValueError::new_err(format!("cannot run until {time} s")));
        }
        let Some(observer) = observer else { return this.run_to(py, RunEnd::Time(time)) };
        let (every, begun) = (Every::of(every)?, this.time()?);
        let mut calls = 0;
        while this.time()? < time {
            let next = every.next(this.at_rest()?.simulation(), begun, calls);
            let is_window = matches!(every, Every::Window) && next < time;
            this.run_to(py, if is_window { RunEnd::Window } else { RunEnd::Time(next.min(time)) })?;
            observer.call1((slf,))?;
            calls += 1;
            if next >= time {
                break;
            }
        }
        Ok(())
    }

    /// Runs `windows` windows of the schedule. Windows are the times between two exchanges with the gas.
    #[pyo3(signature = (windows=1))]
    fn step(&self, py: Python<'_>, windows: u64) -> PyResult<()> {
        for _ in 0..windows {
            if self.at_rest()?.simulation().end_of_window().is_none() {
                return Err(PyValueError::new_err("the case lasts 0 s and has no windows"));
            }
            self.run_to(py, RunEnd::Window)?;
        }
        Ok(())
    }

    #[getter]
    fn time(&self) -> PyResult<f64> {
        Ok(self.at_rest()?.simulation().time)
    }

    #[getter]
    fn duration(&self) -> f64 {
        self.experiment.run.duration
    }

    #[getter]
    fn model(&self) -> &'static str {
        self.experiment.model().name()
    }

    #[getter]
    fn windows(&self) -> PyResult<u64> {
        Ok(self.at_rest()?.simulation().windows)
    }

    #[getter]
    fn species_names(&self) -> Vec<&str> {
        self.experiment.scene.species.iter().map(|species| species.name.as_str()).collect()
    }

    #[getter]
    fn size(&self) -> (f64, f64, f64) {
        let size = self.experiment.scene.domain.size;
        (size.x, size.y, size.z)
    }

    #[getter]
    fn kinetic_energy(&self) -> PyResult<f64> {
        Ok(self.particles()?.kinetic_energy())
    }

    #[getter]
    fn pair_impacts(&self) -> PyResult<u64> {
        Ok(self.at_rest()?.simulation().record.pairs.count)
    }

    #[getter]
    fn wall_impacts(&self) -> PyResult<u64> {
        Ok(self.at_rest()?.simulation().record.walls.count)
    }

    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.array(py, Column::Position)
    }

    #[getter]
    fn velocities<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.array(py, Column::Velocity)
    }

    #[getter]
    fn spins<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let rotates = self.particles()?.spin.is_some();
        rotates.then(|| self.array(py, Column::Spin)).transpose()
    }

    #[getter]
    fn radii<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.array(py, Column::Radius)
    }

    #[getter]
    fn masses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.array(py, Column::Mass)
    }

    #[getter]
    fn species<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.array(py, Column::Species)
    }

    #[getter]
    fn ids<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.array(py, Column::Id)
    }

    /// Particles in the order of their ids, with positions within the box, as a pandas table with units.
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let mut particles = Particles::clone(&*self.particles()?);
        particles.wrap(&self.at_rest()?.simulation().scene().domain);
        particles.sort_by_id();
        let particles = Arc::new(particles);
        let table = PyDict::new(py);
        let mut vectors = vec![("", "_m", ["x", "y", "z"], Column::Position)];
        vectors.push(("v", "_m_s", ["x", "y", "z"], Column::Velocity));
        if particles.spin.is_some() {
            vectors.push(("w", "_rad_s", ["x", "y", "z"], Column::Spin));
        }
        table.set_item("id", columns::array(py, Arc::clone(&particles), Column::Id)?)?;
        table.set_item("species", columns::array(py, Arc::clone(&particles), Column::Species)?)?;
        for (letter, unit, axes, column) in vectors {
            let rows = columns::array(py, Arc::clone(&particles), column)?.getattr("T")?;
            for (axis, name) in axes.iter().enumerate() {
                table.set_item(format!("{letter}{name}{unit}"), rows.get_item(axis)?)?;
            }
        }
        table.set_item("radius_m", columns::array(py, particles, Column::Radius)?)?;
        py.import("pandas")?.call_method1("DataFrame", (table,))
    }

    fn __repr__(&self) -> PyResult<String> {
        let moving = self.at_rest()?;
        let (count, time) = (moving.simulation().count(), moving.simulation().time);
        Ok(format!("<diptych.Simulation: {count} {} spheres at {time} s>", self.model()))
    }
}
