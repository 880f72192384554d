//! The Python class `Simulation`. A window is the time between two exchanges of momentum with the gas, and a kick is a
//! change of the velocities without motion.

use crate::columns::{self, Column};
use crate::moving::{Interruption, MovingParticles, RunEnd};
use crate::own_drag::{OwnDrag, next_piece, rows_of_three};
use crate::{InputError, RunError, scene};
use diptych::memory;
use diptych::{Experiment, Failure, Model, Particles};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::gc::{PyTraverseError, PyVisit};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use std::sync::{Arc, Mutex, MutexGuard, TryLockError};

/// Collision models that a caller in Python can choose by name.
const MODELS: [Model; 4] = [Model::Soft, Model::Hard, Model::Hybrid, Model::Dsmc];

/// Simulation of one case with one collision model. Simulated time passes only during calls that move the particles,
/// such as `run_until`.
#[pyclass(frozen, subclass, module = "diptych._engine")]
pub struct Simulation {
    moving: Mutex<MovingParticles>,
    /// Drag law that the calling program has set; `None` if there is none. The lock is held while the simulation runs,
    /// also between windows.
    drag: Mutex<Option<OwnDrag>>,
    experiment: Experiment,
    /// [J] kinetic, rotational and elastic energy at the start.
    energy_at_start: f64,
}

/// Times at which an observer is called: at every sample of the case (instant of measurement), at the end of every
/// window (time between two exchanges with the gas), or at equal intervals of simulated time.
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

    /// [s] simulated time of the next call of the observer; infinite if there is no further call. `begun` [s] is the
    /// time at which the run began, and `calls` the number of calls so far.
    fn next(&self, simulation: &diptych::Simulation, begun: f64, calls: u64) -> f64 {
        let next = match self {
            Self::Sample => simulation.next_sample(),
            Self::Window => simulation.end_of_window(),
            Self::Seconds(every) => Some(begun + (calls + 1) as f64 * every),
        };
        next.unwrap_or(f64::INFINITY)
    }
}

/// Setting of a key as text, as after `--set`. The two values of a condition are written in TOML as `true` and `false`.
fn setting(key: &Bound<'_, PyAny>, value: &Bound<'_, PyAny>) -> PyResult<String> {
    let text = match value.extract::<bool>() {
        Ok(is_true) => is_true.to_string(),
        Err(_) => value.str()?.to_string(),
    };
    Ok(format!("{key}={text}"))
}

fn model_of(name: &str) -> PyResult<Model> {
    let found = MODELS.into_iter().find(|model| model.name() == name);
    let names = MODELS.map(Model::name).join(", ");
    found.ok_or_else(|| PyValueError::new_err(format!("no model is called \"{name}\"; the models are {names}")))
}

impl Simulation {
    /// Access to the particles and the engine. An error is returned if another thread runs the simulation. The function
    /// does not wait for this thread, because waiting would block the interpreter, which the thread may need in order
    /// to stop.
    fn at_rest(&self) -> PyResult<MutexGuard<'_, MovingParticles>> {
        unlocked(&self.moving, "another thread runs this simulation")
    }

    /// Access to the drag law that the calling program has set; `None` if there is none. An error is returned while a
    /// run is in progress.
    fn own_drag(&self) -> PyResult<MutexGuard<'_, Option<OwnDrag>>> {
        unlocked(&self.drag, "this simulation is running: neither drag nor another thread can change or run it")
    }

    fn array<'py>(&self, py: Python<'py>, column: Column) -> PyResult<Bound<'py, PyAny>> {
        columns::array(py, self.particles()?, column)
    }

    fn particles(&self) -> PyResult<Arc<Particles>> {
        self.at_rest()?.lend().map_err(failed)
    }

    /// Runs the simulation to `end`, with kicks (changes of velocities) by the drag law of the calling program, if
    /// there is one.
    fn run_to(slf: &Bound<'_, Self>, end: RunEnd) -> PyResult<()> {
        let (py, this) = (slf.py(), slf.get());
        let mut drag = this.own_drag()?;
        let Some(drag) = drag.as_mut() else { return this.at_rest()?.run(py, end).map_err(passed_on) };
        loop {
            let Some((piece, length)) = next_piece(this.at_rest()?.simulation(), end)? else { return Ok(()) };
            Self::call_drag(slf, drag)?;
            this.at_rest()?.accelerate(&drag.by_id, 0.5 * length).map_err(failed)?;
            drag.is_current = false;
            let result = this.at_rest()?.run(py, piece);
            if !matches!(result, Err(Interruption::Failed(_))) {
                drag.predicted = 0.5 * length;
                this.at_rest()?.accelerate(&drag.by_id, drag.predicted).map_err(failed)?;
            }
            result.map_err(passed_on)?;
            Self::call_drag(slf, drag)?;
            if matches!((piece, end), (RunEnd::Time(_), _) | (_, RunEnd::Window)) {
                return Ok(());
            }
        }
    }

    /// Calls the drag law, unless its accelerations already belong to the present time. Then corrects the latest kick
    /// (change of velocities), which was predicted with the accelerations of the previous call.
    fn call_drag(slf: &Bound<'_, Self>, drag: &mut OwnDrag) -> PyResult<()> {
        if drag.is_current {
            return Ok(());
        }
        let particles = slf.get().particles()?;
        let rows = rows_of_three(&drag.function.bind(slf.py()).call1((slf,))?, &particles)?;
        let differences = drag.keep(&particles, &rows);
        drop(particles);
        let predicted = std::mem::take(&mut drag.predicted);
        slf.get().at_rest()?.accelerate(&differences, predicted).map_err(failed)
    }
}

fn unlocked<'a, T>(lock: &'a Mutex<T>, why_not: &'static str) -> PyResult<MutexGuard<'a, T>> {
    lock.try_lock().map_err(|why| {
        PyRuntimeError::new_err(match why {
            TryLockError::WouldBlock => why_not,
            TryLockError::Poisoned(_) => "this simulation was ended by an error of the library",
        })
    })
}

fn failed(failure: Failure) -> PyErr {
    RunError::new_err(failure.to_string())
}

fn passed_on(why: Interruption) -> PyErr {
    match why {
        Interruption::Failed(failure) => failed(failure),
        Interruption::Signal(signal) => signal,
    }
}

#[pymethods]
impl Simulation {
    #[new]
    #[pyo3(signature = (case=None, *, text=None, model=None, set=None, seed=None, threads=None, **start))]
    #[expect(clippy::too_many_arguments, reason = "these are the names of the arguments in Python")]
    fn new(
        py: Python<'_>,
        case: Option<Bound<'_, PyAny>>,
        text: Option<&str>,
        model: Option<&str>,
        set: Option<&Bound<'_, PyDict>>,
        seed: Option<u64>,
        threads: Option<usize>,
        start: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let sets = set.into_iter().flatten().map(|(key, value)| setting(&key, &value));
        let case = scene::read(py, (case, text), &sets.collect::<PyResult<Vec<String>>>()?, start)?;
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
        let energy_at_start = simulation.energy();
        let moving = MovingParticles::new(simulation, threads.unwrap_or(0));
        let moving = moving.map_err(|why| PyRuntimeError::new_err(why.to_string()))?;
        Ok(Self { moving: Mutex::new(moving), drag: Mutex::new(None), experiment, energy_at_start })
    }

    /// Runs until `time` [s]. `observer(simulation)` is called at every sample of the case (instant of measurement).
    /// With `every="window"` it is called at the end of every window (time between two exchanges with the gas), with
    /// `every=0.1` every 0.1 s of simulated time. The last call is at `time`.
    #[pyo3(signature = (time, observer=None, *, every=None))]
    fn run_until(
        slf: &Bound<'_, Self>,
        time: f64,
        observer: Option<Bound<'_, PyAny>>,
        every: Option<Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let this = slf.get();
        if !time.is_finite() {
            return Err(PyValueError::new_err(format!("cannot run until {time} s")));
        }
        let Some(observer) = observer else {
            Self::run_to(slf, RunEnd::Time(time))?;
            this.at_rest()?.refresh();
            return Ok(());
        };
        let (every, begun) = (Every::of(every)?, this.time()?);
        let mut calls = 0;
        while this.time()? < time {
            let next = every.next(this.at_rest()?.simulation(), begun, calls);
            let is_window = matches!(every, Every::Window) && next < time;
            Self::run_to(slf, if is_window { RunEnd::Window } else { RunEnd::Time(next.min(time)) })?;
            observer.call1((slf,))?;
            calls += 1;
            if next >= time {
                break;
            }
        }
        this.at_rest()?.refresh();
        Ok(())
    }

    /// Opens a page of this machine that shows the particles while the simulation runs.
    fn show<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let shown = self.at_rest()?.show(&self.experiment, self.experiment.model().name());
        let address = shown.map_err(|why| PyRuntimeError::new_err(why.to_string()))?;
        py.import("diptych.live")?.call_method1("LivePage", (address,))
    }

    /// Runs as many windows as `windows` states. A window is the time between two exchanges with the gas.
    #[pyo3(signature = (windows=1))]
    fn step(slf: &Bound<'_, Self>, windows: u64) -> PyResult<()> {
        for _ in 0..windows {
            next_piece(slf.get().at_rest()?.simulation(), RunEnd::Window)?;
            Self::run_to(slf, RunEnd::Window)?;
        }
        Ok(())
    }

    /// Drag law of the calling program, in addition to the drag of the case; `None` if there is none. The law is a
    /// function that is called with the simulation, and returns the acceleration of each particle [m/s²].
    #[getter]
    fn drag(&self, py: Python<'_>) -> PyResult<Option<Py<PyAny>>> {
        Ok(self.own_drag()?.as_ref().map(|drag| drag.function.clone_ref(py)))
    }

    #[setter]
    fn set_drag(&self, function: Option<Bound<'_, PyAny>>) -> PyResult<()> {
        *self.own_drag()? = function.map(OwnDrag::new).transpose()?;
        Ok(())
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        match self.drag.try_lock().as_deref() {
            Ok(Some(drag)) => visit.call(&drag.function),
            Ok(None) | Err(_) => Ok(()),
        }
    }

    fn __clear__(&self) {
        if let Ok(mut drag) = self.drag.try_lock() {
            *drag = None;
        }
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

    /// [J] terms of the energy balance: energy at the start and now, work and losses since the start, and the residual.
    /// The residual is the part of the change of the energy that work and losses do not explain.
    #[getter]
    fn ledger<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let particles = self.particles()?;
        let moving = self.at_rest()?;
        let (ledger, elastic) = (&*moving.simulation().record.ledger, moving.simulation().elastic_energy());
        let energy = particles.kinetic_energy() + particles.rotational_energies().value() + elastic;
        let table = PyDict::new(py);
        for (name, value) in [
            ("energy_at_start", self.energy_at_start),
            ("energy", energy),
            ("drag_work", ledger.drag_work),
            ("gravity_work", ledger.gravity_work),
            ("wall_work", ledger.wall_work),
            ("shear_work", ledger.shear_work),
            ("thermostat_work", ledger.thermostat_work),
            ("flow_energy", ledger.flow_energy),
            ("dissipated", ledger.dissipated()),
            ("residual", ledger.residual(self.energy_at_start, energy)),
        ] {
            table.set_item(format!("{name}_J"), value)?;
        }
        Ok(table)
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
