//! What is measured while a simulation runs.
//!
//! An [`Observer`] sees the simulation at the times that it asks for, and keeps what it needs of it. [`run`] is the loop: it
//! runs the simulation from sample to sample, and on the way shows it to those whose time it is. What observers keep is
//! plain data, so that it can be stored beside the state of the particles: [`RunLoop`] is the loop for runs that may be left at the end of
//! any window, stored, and gone on with.

mod energy;
mod frames;
mod impacts;
mod kinds;
mod mixing;
mod momentum;
mod motion;
mod paths;
mod rings;
mod run_loop;
mod second_moments;
mod series;
mod stress;

pub use energy::EnergyBooks;
pub use frames::{Frame, Frames};
pub use impacts::ImpactSeries;
pub use kinds::{KindAverages, KindCurve, Kinds, MeetingAverages, SpeciesAverages};
pub use mixing::Mixing;
pub use momentum::{Balance, MomentumBooks};
pub use motion::Motion;
pub use paths::{PathSample, Paths};
pub use rings::{Ring, RingAverages, Rings};
pub use run_loop::{Pause, RunLoop};
pub use second_moments::{Budgets, MOMENTS, SecondMoments, Terms};
pub use series::{Row, Series};
pub use stress::{Stress, Stresses};

use crate::engine::Failure;
use crate::schedule::Schedule;
use crate::simulation::Simulation;
use crate::statistics::Accumulator;
use crate::stored::{StoreError, Stored};

/// How an observer is stored that is plain data as a whole.
macro_rules! plain_data {
    () => {
        fn stored(&self) -> Result<crate::stored::Stored, crate::stored::StoreError> {
            crate::stored::Stored::of(self)
        }

        fn restore(&mut self, stored: &crate::stored::Stored) -> Result<(), crate::stored::StoreError> {
            *self = stored.read()?;
            Ok(())
        }
    };
}
use plain_data;

/// What an observer has to see where processes share a run and each has a part of the particles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// None of the particles.
    Nothing,
    /// Sums over all of them, which it makes with [`Simulation::sample`] and what is said to be a sum of it. At samples that every process shows to an observer of
    /// its own, it works on the part of each; the records of all are those of the lead's simulation.
    Sums,
    /// In every process its own part, while each has one; otherwise the lead has all. Like sums, but at any time; the records are not those of all.
    Parts,
    /// Every so manieth particle by id (1: all), and those in contact with them. [`Simulation::count`] and [`Simulation::agitation`] are of
    /// all.
    Every(u32),
}

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

    /// Whether velocities must be of the same instant as positions. Where drag acts they lag up to half a window of drag behind
    /// between two samples, and to bring them forward for somebody costs as much as the drag of a window.
    fn needs_velocities(&self) -> bool {
        true
    }

    /// What it has to see of the particles where processes share a run; if not said otherwise, all. It must do with all particles, too.
    fn sight(&self) -> Needs {
        Needs::Every(1)
    }

    /// Takes what it needs; positions and velocities are those of one instant, if [`needs_velocities`](Self::needs_velocities).
    fn see(&mut self, simulation: &Simulation);

    /// Why the run must not go on, such as a disk that is full; asked for at every sample. `None`: it may.
    fn stop(&self) -> Option<String> {
        None
    }

    /// What it has to see of the particles when the run is over at `now` [s]: whoever then sums, sees it once more before its [`end`](Self::end). If not said
    /// otherwise, nothing.
    fn sight_of_end(&self, _now: f64) -> Needs {
        Needs::Nothing
    }

    /// The run is over, or has stopped with a failure: the state is the last there is.
    fn end(&mut self, _simulation: &Simulation) {}

    /// What it keeps, for a run that is to go on after the program has ended. If not said otherwise, nothing: right for whoever
    /// only shows something. Who writes files on the way stores how far they go.
    ///
    /// # Errors
    /// What it keeps cannot be stored.
    fn stored(&self) -> Result<Stored, StoreError> {
        Ok(Stored::default())
    }

    /// Goes on from what an observer like it, made for the same run, has stored.
    ///
    /// # Errors
    /// The bytes are not of such an observer.
    fn restore(&mut self, _stored: &Stored) -> Result<(), StoreError> {
        Ok(())
    }
}

impl<F: FnMut(&Simulation) + Send> Observer for F {
    fn see(&mut self, simulation: &Simulation) {
        self(simulation);
    }
}

/// Slice averages are taken at every sample.
impl Observer for Accumulator {
    fn sight(&self) -> Needs {
        Needs::Sums
    }

    fn see(&mut self, simulation: &Simulation) {
        self.sample(simulation.time, simulation.sample());
    }

    plain_data!();
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
    let mut course = RunLoop::new(schedule, observers.len());
    let result = course.run(simulation, observers, &mut || false).map(drop);
    course.end(simulation, observers, result.as_ref().err());
    result
}
