//! Measurements while a simulation runs.
//!
//! An [`Observer`] sees the simulation at the times that it asks for, and keeps the data that it needs. [`run`] is the
//! loop over the run: it advances the simulation from sample to sample and shows it to each observer at the requested
//! times. The data of observers are plain, so that they can be stored with the state of the particles. [`RunLoop`] is
//! the loop for runs that may be stopped at the end of any window, stored, and resumed.

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
mod series_columns;
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
pub use series::{RotationSums, Row, Series};
pub use series_columns::{CurveScale, SERIES_COLUMNS, SeriesColumn};
pub use stress::{Stress, Stresses};

use crate::engine::Failure;
use crate::schedule::Schedule;
use crate::simulation::Simulation;
use crate::statistics::Accumulator;
use crate::stored::{StoreError, Stored};

/// Storing of an observer that consists of plain data.
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

/// Data that an observer needs if processes share a run and each has a part of the particles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// No particles.
    Nothing,
    /// Sums over all particles, made with [`Simulation::sample`] and the records documented as sums of it. At samples
    /// that every process shows to its own copy of an observer, the observer works on the local particles. The records
    /// of the whole run are those of the simulation of the lead process.
    Sums,
    /// In every process the local particles, while each process has a part; otherwise the lead has all. As with sums,
    /// but at any time; the records are not those of the whole run.
    Parts,
    /// Every n-th particle by id (1: all), and the particles in contact with these. [`Simulation::count`] and
    /// [`Simulation::agitation`] refer to all particles.
    Every(u32),
}

/// Sees a simulation from time to time. It only reads: results are bitwise equal for any observers and times.
///
/// Every closure that takes a `&Simulation` is an observer of every sample.
pub trait Observer: Send {
    /// [s] next time, after the present `now` [s] (a whole number of windows), at which the observer wants to see the
    /// simulation. It is shown at the end of the first window that reaches this time. `None`: not again. Every observer
    /// sees the start. By default, the next sample.
    fn next(&self, now: f64, schedule: &Schedule) -> Option<f64> {
        Some(now + schedule.interval())
    }

    /// True if velocities must be of the same instant as positions. With drag, they lag behind by up to half a window
    /// of drag between two samples. To update them for an observer costs as much as the drag of a window.
    fn needs_velocities(&self) -> bool {
        true
    }

    /// Particles that the observer needs if processes share a run; by default all. It must also work with all
    /// particles.
    fn sight(&self) -> Needs {
        Needs::Every(1)
    }

    /// Takes the data that the observer needs. Positions and velocities are of one instant if
    /// [`needs_velocities`](Self::needs_velocities).
    fn see(&mut self, simulation: &Simulation);

    /// Reason to stop the run, such as a full disk; asked for at every sample. `None`: the run may continue.
    fn stop(&self) -> Option<String> {
        None
    }

    /// Particles that the observer needs when the run is over at `now` [s]. An observer that then needs sums sees the
    /// simulation once more before its [`end`](Self::end). By default, none.
    fn sight_of_end(&self, _now: f64) -> Needs {
        Needs::Nothing
    }

    /// Called when the run is over, or has stopped with a failure: the state is the last one.
    fn end(&mut self, _simulation: &Simulation) {}

    /// Data of the observer, for a run that is resumed after the program has ended. By default none, which suits an
    /// observer that only displays. An observer that writes files during the run stores its position in them.
    ///
    /// # Errors
    /// The data cannot be stored.
    fn stored(&self) -> Result<Stored, StoreError> {
        Ok(Stored::default())
    }

    /// Continues from the data that an observer of this type, made for the same run, has stored.
    ///
    /// # Errors
    /// The bytes are not those of such an observer.
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
