//! What is measured while a simulation runs.
//!
//! An [`Observer`] sees the simulation at the times that it asks for, and keeps what it needs of it. [`run`] is the loop: it
//! runs the simulation up to the next time that an observer asks for and calls those whose time it is. What observers keep is
//! plain data, so that it can be stored beside the state of the particles.

mod energy;
mod impacts;
mod momentum;
mod motion;

pub use energy::EnergyBooks;
pub use impacts::ImpactSeries;
pub use momentum::{Balance, MomentumBooks};
pub use motion::Motion;

use crate::engine::Failure;
use crate::schedule::Schedule;
use crate::simulation::Simulation;
use crate::statistics::Accumulator;

/// Sees a simulation from time to time. It reads only: results do not depend on who observes, but for rounding where a time
/// lies between samples, since a kick of drag is then done in two parts.
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
    let mut done = 0;
    let mut due = vec![Some(done); observers.len()];
    let result = loop {
        let began = clock.now();
        for (observer, due) in observers.iter_mut().zip(&mut due).filter(|(_, due)| **due == Some(done)) {
            observer.see(simulation);
            // of the schedule, since the rounding of the simulation's own time adds up over millions of windows
            let next = observer.next(done as f64 * schedule.window, schedule);
            *due = next.map(|time| schedule.windows_to(time).max(done + 1));
        }
        simulation.spent.observers += clock.now() - began;
        if done == schedule.windows() {
            break Ok(());
        }
        let next = due.iter().flatten().copied().fold(schedule.windows(), u64::min);
        if let Err(why) = simulation.run(next - done, schedule.window) {
            break Err(why);
        }
        done = next;
    };
    simulation.spent.whole += clock.now() - start;
    observers.iter_mut().for_each(|observer| observer.end(simulation));
    result
}
