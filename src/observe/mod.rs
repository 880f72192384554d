//! What is measured while a simulation runs.
//!
//! An [`Observer`] sees the simulation at the times that it asks for, and keeps what it needs of it. [`run`] is the loop: it
//! runs the simulation from sample to sample, and on the way shows it to those whose time it is. What observers keep is
//! plain data, so that it can be stored beside the state of the particles.

mod energy;
mod impacts;
mod momentum;
mod motion;
mod paths;
mod series;

pub use energy::EnergyBooks;
pub use impacts::ImpactSeries;
pub use momentum::{Balance, MomentumBooks};
pub use motion::Motion;
pub use paths::{Paths, Point};
pub use series::{Row, Series};

use crate::engine::Failure;
use crate::schedule::Schedule;
use crate::simulation::Simulation;
use crate::statistics::Accumulator;

/// Sees a simulation from time to time. It reads only: results are the same bits whoever observes, and when.
///
/// Every closure that takes a `&Simulation` is an observer of every sample.
pub trait Observer: Send {
    /// [s] the next time, after the present `now` [s] (a whole number of windows), at which it wants to see the simulation: at
    /// the end of the first window that reaches it. `None`: not again. Everyone sees the start. If not said otherwise, the
    /// next sample.
    fn next(&self, now: f64, schedule: &Schedule) -> Option<f64> {
        Some(now + schedule.interval())
    }

    /// Takes what it needs; positions and velocities are those of one instant.
    fn see(&mut self, simulation: &Simulation);

    /// The run is over, or has stopped with a failure: the state is the last there is.
    fn end(&mut self, _simulation: &Simulation) {}
}

impl<F: FnMut(&Simulation) + Send> Observer for F {
    fn see(&mut self, simulation: &Simulation) {
        self(simulation);
    }
}

/// Slice averages are taken at every sample.
impl Observer for Accumulator {
    fn see(&mut self, simulation: &Simulation) {
        self.sample(simulation.time, &simulation.particles);
    }
}

/// Who watches a run, and the windows done at which each is to see it next.
struct Audience<'a, 'b> {
    schedule: &'a Schedule,
    observers: &'a mut [&'b mut dyn Observer],
    due: Vec<Option<u64>>,
}

impl Audience<'_, '_> {
    /// Shows the simulation, `done` windows after its start, to those whose time it is, and asks them when they want to see it next.
    fn see(&mut self, simulation: &Simulation, done: u64) {
        for (observer, due) in self.observers.iter_mut().zip(&mut self.due).filter(|(_, due)| **due == Some(done)) {
            observer.see(simulation);
            // of the schedule, since the rounding of the simulation's own time adds up over millions of windows
            let next = observer.next(done as f64 * self.schedule.window, self.schedule);
            *due = next.map(|time| self.schedule.windows_to(time).max(done + 1));
        }
    }

    /// Windows done at which somebody wants to see it next.
    fn next(&self) -> Option<u64> {
        self.due.iter().flatten().copied().min()
    }
}

/// Runs a simulation from its start through all windows of its schedule and shows it to the observers at their times.
///
/// # Errors
/// The failure that stopped it.
pub fn run(
    simulation: &mut Simulation,
    schedule: &Schedule,
    observers: &mut [&mut dyn Observer],
) -> Result<(), Failure> {
    let clock = simulation.clock();
    let start = clock.now();
    let due = vec![Some(0); observers.len()];
    let mut audience = Audience { schedule, observers, due };
    let mut done = 0;
    let result = loop {
        let began = clock.now();
        audience.see(simulation, done);
        simulation.spent.observers += clock.now() - began;
        if done == schedule.windows() {
            break Ok(());
        }
        let first = audience.next().map(|next| next - done);
        let windows = schedule.windows_per_sample;
        let between = simulation.run_shown(windows, schedule.window, first, &mut |simulation, windows| {
            audience.see(simulation, done + windows);
            audience.next().map(|next| next - done)
        });
        if let Err(why) = between {
            break Err(why);
        }
        done += windows;
    };
    simulation.spent.whole += clock.now() - start;
    observers.iter_mut().for_each(|observer| observer.end(simulation));
    result
}
