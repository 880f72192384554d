//! A simulation that Python owns. The store is the memory with the data of all particles. While the engine does not
//! run, arrays of Python may share this memory. Ctrl-C stops a run. A window is the time between two exchanges with the
//! gas.

use diptych::lab::{LabError, LabServer, LiveView};
use diptych::work_sharing::keep_workers_spinning;
use diptych::{Experiment, Failure, Particles, Vector3};
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// Wall time between two checks for signals, such as Ctrl-C, while an engine runs.
const LOOK: Duration = Duration::from_millis(50);

/// Simulation with the threads that run it.
pub struct MovingParticles {
    simulation: diptych::Simulation,
    pool: ThreadPool,
    /// Particles that arrays of Python may share. Meanwhile the store (memory with the data of all particles) of the
    /// simulation is empty. `None` if the particles are in the store of the simulation.
    lent: Option<Arc<Particles>>,
    /// Page that shows the simulation, and its server; `None` if no page was asked for.
    shown: Option<(LiveView, LabServer)>,
}

/// Condition at which a run ends.
#[derive(Clone, Copy)]
pub enum RunEnd {
    /// End at this simulated time [s].
    Time(f64),
    /// End at the end of the present window (time between two exchanges with the gas).
    Window,
}

/// Reason why a run did not reach its end.
pub enum Interruption {
    /// The engine cannot go on.
    Failed(Failure),
    /// Python has handled a signal, such as Ctrl-C, and has raised this exception, such as `KeyboardInterrupt`.
    Signal(PyErr),
}

impl MovingParticles {
    /// Takes ownership of a simulation, which then runs on the given number of threads; 0 means one thread per
    /// processor.
    ///
    /// # Errors
    /// The threads cannot be started.
    pub fn new(simulation: diptych::Simulation, threads: usize) -> Result<Self, rayon::ThreadPoolBuildError> {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build()?;
        Ok(Self { simulation, pool, lent: None, shown: None })
    }

    /// Simulation that Python owns. Its store (memory with the data of all particles) is empty while the particles are
    /// lent ([`lend`](Self::lend)).
    pub fn simulation(&self) -> &diptych::Simulation {
        &self.simulation
    }

    /// Particles at the present time, which arrays of Python may share. The shared particles do not change: while an
    /// array uses them, a run continues with a copy.
    ///
    /// # Errors
    /// A particle has left the domain, or the energy has grown by more than the errors of the time integrator explain.
    pub fn lend(&mut self) -> Result<Arc<Particles>, Failure> {
        if let Some(lent) = &self.lent {
            return Ok(Arc::clone(lent));
        }
        let Self { simulation, pool, .. } = self;
        // between two samples (instants of measurement) half a kick (change by drag) is missing in the velocities, and
        // is added before they are read
        pool.install(|| simulation.complete())?;
        let lent = Arc::new(std::mem::take(&mut self.simulation.particles));
        self.lent = Some(Arc::clone(&lent));
        Ok(lent)
    }

    /// Changes the velocities of the particles by accelerations that last for `duration` [s]; the particles do not
    /// move. `by_id` has the acceleration [m/s²] of each particle at the index of its id. Particles whose ids are
    /// beyond the end of the list are not accelerated.
    ///
    /// # Errors
    /// A particle has left the domain, or the energy has grown by more than the errors of the time integrator explain.
    pub fn accelerate(&mut self, by_id: &[Vector3<f64>], duration: f64) -> Result<(), Failure> {
        self.take_back();
        let Self { simulation, pool, .. } = self;
        pool.install(|| {
            simulation.complete()?;
            let ids = simulation.particles.id.clone();
            simulation.accelerate(|place| by_id.get(ids[place] as usize).copied().unwrap_or_default(), duration);
            Ok(())
        })
    }

    /// Address of a page of this machine that shows the simulation, now and while it runs. The first call starts the
    /// server of this page. `title` is the heading of the page.
    ///
    /// # Errors
    /// The server cannot start.
    pub fn show(&mut self, experiment: &Experiment, title: &str) -> Result<String, LabError> {
        let shown = match self.shown.take() {
            Some(shown) => shown,
            None => {
                let view = LiveView::new(experiment, title, false);
                let server = LabServer::start_live(view.feed())?;
                (view, server)
            }
        };
        let url = shown.1.url();
        self.shown = Some(shown);
        self.refresh();
        Ok(url)
    }

    /// Shows the present state of the simulation on its page, if the simulation has a page.
    pub fn refresh(&mut self) {
        if self.shown.is_some() {
            self.take_back();
        }
        let Self { simulation, pool, shown, .. } = self;
        if let Some((view, _)) = shown {
            pool.install(move || view.show(simulation, "running"));
        }
    }

    /// Takes the particles back into the store (memory with the data of all particles) of the simulation. If arrays
    /// still share the particles, the simulation gets a copy.
    fn take_back(&mut self) {
        if let Some(lent) = self.lent.take() {
            self.simulation.particles = Arc::unwrap_or_clone(lent);
        }
    }

    /// Runs the simulation to `end`. Other threads of Python may run meanwhile, because the lock of the interpreter is
    /// released. A signal, such as Ctrl-C, stops the run at the end of a window (time between two exchanges with the
    /// gas).
    ///
    /// # Errors
    /// The engine has failed, or a signal has stopped the run.
    pub fn run(&mut self, py: Python<'_>, end: RunEnd) -> Result<(), Interruption> {
        self.take_back();
        let Self { simulation, pool, shown, .. } = self;
        py.detach(|| {
            let stop = AtomicBool::new(false);
            pool.in_place_scope(|scope| {
                let (send, ended) = channel();
                let (stop, mut signal) = (&stop, None);
                let (time, is_window) = match end {
                    RunEnd::Time(time) => (time, false),
                    RunEnd::Window => (f64::INFINITY, true),
                };
                scope.spawn(move |_| {
                    let mut go_on = |simulation: &mut diptych::Simulation| {
                        if let Some((view, _)) = shown.as_mut() {
                            view.offer(simulation);
                        }
                        !is_window && !stop.load(Ordering::Relaxed)
                    };
                    // sending fails only if the receiver no longer exists, and it exists until this message has come
                    let _ = send.send(keep_workers_spinning(|| simulation.run_until_while(time, &mut go_on)));
                });
                let result = loop {
                    match ended.recv_timeout(LOOK) {
                        Ok(result) => break result,
                        Err(RecvTimeoutError::Disconnected) => break Ok(false),
                        Err(RecvTimeoutError::Timeout) if signal.is_none() => {
                            signal = Python::attach(|py| py.check_signals()).err();
                            stop.store(signal.is_some(), Ordering::Relaxed);
                        }
                        Err(RecvTimeoutError::Timeout) => {}
                    }
                };
                match (result, signal) {
                    (Err(failure), _) => Err(Interruption::Failed(failure)),
                    (Ok(_), Some(signal)) => Err(Interruption::Signal(signal)),
                    (Ok(_), None) => Ok(()),
                }
            })
        })
    }
}
