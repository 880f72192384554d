//! Measurements while a simulation runs.
//!
//! An [`Observer`] is called with the simulation at times that it specifies, and stores data from it. [`run`] is the
//! loop over a run: it advances the simulation from sample to sample and calls each observer at its times. A sample is
//! an instant of the schedule at which measurements are taken. A window is the time between two exchanges of momentum
//! with the gas. The data of an observer can be stored with the state of the particles. [`RunLoop`] is the loop for
//! runs that may be stopped at the end of any window, stored, and resumed.

mod clusters;
mod contact_network;
mod diffusion;
mod energy;
mod fields;
mod flows;
mod frames;
mod free_surface;
mod gas_flow;
mod impacts;
mod kinds;
mod measurements;
mod mixing;
mod momentum;
mod motion;
mod near_pairs;
mod pair_distribution;
mod paths;
mod rings;
mod run_loop;
mod second_moments;
mod seen_gas;
mod series;
mod series_columns;
mod stress;
mod structure_factor;
mod velocity_distribution;
mod viscosity;

pub use clusters::ParticleClusters;
pub use contact_network::{ContactLine, ContactNetwork, contact_lines};
pub use diffusion::Diffusion;
pub use energy::EnergyBooks;
pub use fields::Fields;
pub use flows::{FlowAverages, FlowSample, Flows};
pub use frames::{Frame, Frames};
pub use free_surface::FreeSurface;
pub use gas_flow::{GasFlow, GasFlows};
pub use impacts::ImpactSeries;
pub use kinds::{KindAverages, KindCurve, Kinds, MeetingAverages, SpeciesAverages};
pub use measurements::{
    Measurement, Measurements, Observation, ObservedCurve, ObservedGrid, ObservedNumber, ObservedQuantity,
};
pub use mixing::Mixing;
pub use momentum::{Balance, MomentumBooks};
pub use motion::Motion;
pub use pair_distribution::PairDistribution;
pub use paths::{PathSample, Paths};
pub use rings::{Ring, RingAverages, Rings};
pub use run_loop::{Pause, RunLoop};
pub use second_moments::{Budgets, MOMENTS, SecondMoments, Terms};
pub use seen_gas::SeenGas;
pub use series::{GasMeans, RotationSums, Row, Series, ShearStress, TurbulenceMeans};
pub use series_columns::{
    CurveScale, FRICTION_COLUMNS, GAS_COLUMNS, OPENING_COLUMNS, SERIES_COLUMNS, SERVO_COLUMNS, SHEAR_COLUMNS,
    SONINE_COLUMNS, SeriesColumn, THERMOSTAT_COLUMNS, TURBULENCE_COLUMNS,
};
pub use stress::{Stress, Stresses};
pub use structure_factor::StructureFactor;
pub use velocity_distribution::{Sonine, VelocityDistribution};
pub use viscosity::Viscosity;

use crate::engine::Failure;
use crate::schedule::Schedule;
use crate::simulation::Simulation;
use crate::statistics::Accumulator;
use crate::stored::{StoreError, Stored};

/// Implements the methods `stored` and `restore` of an observer by storing its whole value.
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

/// Particles that an observer requires if several processes share a run and each process has a part of the particles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// The observer requires no particles.
    Nothing,
    /// Sums over all particles, computed with [`Simulation::sample`], and records of events whose documentation says
    /// that they are sums. At a sample (instant of measurement), every process calls its copy of the observer with its
    /// own particles. Only the simulation of the lead process (process 0) has the records of the whole run.
    Sums,
    /// If several processes share the run, the particles of each process, for the copy of the observer in that process.
    /// Otherwise all particles. Unlike with `Sums`, the observer may be called at any time, and the records are not
    /// those of the whole run.
    Parts,
    /// Every n-th particle by id (1: all particles), and the particles in contact with a selected particle.
    /// [`Simulation::count`] and [`Simulation::fluctuation_speed`] refer to all particles nevertheless.
    Every(u32),
}

/// Measurement that is called with the simulation at several times of a run. An observer only reads the simulation.
/// Observers and their times therefore do not change the results.
///
/// Every closure that takes a `&Simulation` is an observer that is called at every sample (instant of measurement).
pub trait Observer: Send {
    /// [s] next time after `now` [s] at which the observer is to be called; `None` if it is not to be called again.
    /// The call comes at the end of the first window (time between two exchanges with the gas) that reaches this time.
    /// Every observer is also called at the start. The default is the time of the next sample (instant of
    /// measurement).
    fn next(&self, now: f64, schedule: &Schedule) -> Option<f64> {
        Some(now + schedule.interval())
    }

    /// True if the observer requires velocities at the same instant as the positions. Between two samples, the drag of
    /// up to half a window (time between two exchanges with the gas) is missing in the velocities. Adding this drag
    /// takes as much computing time as the drag of one window.
    fn needs_velocities(&self) -> bool {
        true
    }

    /// Particles that the observer requires if several processes share a run; by default all. The observer must also
    /// work if all particles are present.
    fn needs(&self) -> Needs {
        Needs::Every(1)
    }

    /// Takes data from the simulation and stores them in the observer. Positions and velocities belong to one instant
    /// if [`needs_velocities`](Self::needs_velocities) returns true.
    fn see(&mut self, simulation: &Simulation);

    /// Reason to stop the run, such as a full disk; `None` if the run may continue. The method is called at every
    /// sample (instant of measurement).
    fn stop(&self) -> Option<String> {
        None
    }

    /// Particles that the observer requires at the end of the run, at the time `now` [s]. With [`Needs::Sums`],
    /// [`see`](Self::see) is called once more before [`end`](Self::end). By default, no particles.
    fn needs_at_end(&self, _now: f64) -> Needs {
        Needs::Nothing
    }

    /// Takes data from the state of the simulation at the end of a run, also of a run that has failed.
    fn end(&mut self, _simulation: &Simulation) {}

    /// Returns the data of the observer with which the run can be resumed after the program has ended. By default there
    /// are no data, which is correct for an observer that only displays. An observer that writes files during the run
    /// stores its position in the files.
    ///
    /// # Errors
    /// The data cannot be stored.
    fn stored(&self) -> Result<Stored, StoreError> {
        Ok(Stored::default())
    }

    /// Restores the data that an observer of this type has stored in the run that is resumed.
    ///
    /// # Errors
    /// The bytes are not data of an observer of this type.
    fn restore(&mut self, _stored: &Stored) -> Result<(), StoreError> {
        Ok(())
    }
}

impl<F: FnMut(&Simulation) + Send> Observer for F {
    fn see(&mut self, simulation: &Simulation) {
        self(simulation);
    }
}

/// Adds the particles to the averages of slices at every sample (instant of measurement). In a sheared box, velocities
/// are relative to the mean flow.
impl Observer for Accumulator {
    fn needs(&self) -> Needs {
        Needs::Sums
    }

    fn see(&mut self, simulation: &Simulation) {
        self.sample(simulation.time, simulation.sample().with(&simulation.relative_to_flow()));
    }

    plain_data!();
}

/// Runs a simulation through all windows (times between two exchanges with the gas) of its schedule, and calls the
/// observers at their times.
///
/// # Errors
/// The failure that stopped the run.
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
