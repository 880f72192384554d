//! Loop over a run, which can be stopped at the end of any window, stored, and resumed. A window is the time between
//! two exchanges of momentum with the gas.

use super::{Needs, Observer};
use crate::engine::Failure;
use crate::experiment::Experiment;
use crate::schedule::{Schedule, SchedulePosition};
use crate::simulation::{Simulation, Snapshot};
use crate::stored::{StoreError, Stored};
use serde::{Deserialize, Serialize};

/// Loop over a run: its position in the sequence of windows (times between two exchanges with the gas), and the next
/// time at which each observer (measurement) is called.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunLoop {
    schedule_position: SchedulePosition,
    /// [s] time at or after which each observer is called next; `None` if the observer is not called again.
    due: Vec<Option<f64>>,
}

/// Stored state of a run that was stopped at the end of a window (time between two exchanges with the gas). The resumed
/// run has the results of an uninterrupted run, bit by bit.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Pause {
    /// State of the simulation at the instant at which the run was stopped.
    pub snapshot: Snapshot,
    schedule_position: RunLoop,
    observers: Vec<Stored>,
}

impl RunLoop {
    /// Creates the loop for a run from its start, with the given number of observers.
    pub fn new(schedule: &Schedule, observers: usize) -> Self {
        Self { schedule_position: SchedulePosition::new(*schedule), due: vec![Some(0.0); observers] }
    }

    /// Advances the run and calls the observers at their times. The run stops at the end of a window (time between two
    /// exchanges with the gas) if `pause` returns true. Returns true if the run is over, and false if it was stopped by
    /// `pause`.
    ///
    /// A stopped run continues at the next call of this method, also after it was restored from a [`Pause`]. A caller
    /// that does not continue the run calls [`finish_half_kick`](Self::finish_half_kick).
    ///
    /// # Errors
    /// The failure that stopped the run.
    pub fn run(
        &mut self,
        simulation: &mut Simulation,
        observers: &mut [&mut dyn Observer],
        pause: &mut dyn FnMut() -> bool,
    ) -> Result<bool, Failure> {
        let clock = simulation.clock();
        let mut has_moved = false;
        loop {
            let began = clock.now();
            self.sample(simulation, observers);
            let sampled = clock.now() - began;
            simulation.spent.observers += sampled;
            simulation.spent.whole += sampled;
            if let Some(why) = observers.iter().find_map(|observer| observer.stop()) {
                return Err(Failure::Unwritten { time: simulation.time, why });
            }
            if self.schedule_position.is_over() {
                return Ok(true);
            }
            // a run that has not advanced since it was resumed must continue; otherwise it would stop at this position
            // again and again
            if has_moved && pause() {
                return Ok(false);
            }
            has_moved = true;
            let step = self.schedule_position.next(f64::INFINITY);
            let (windows, window) = self.schedule_position.lengths(step);
            let began = clock.now();
            let ran = simulation.run_while(windows, window, &mut |simulation, ran| {
                self.see_between(simulation, (self.schedule_position.after(ran), 0.5 * window), observers);
                !pause()
            });
            simulation.spent.whole += clock.now() - began;
            let ran = ran?;
            self.schedule_position.advance(step, ran);
            if ran < windows {
                return Ok(false);
            }
        }
    }

    /// Calls the observers whose next time is `now` [s], between two samples (instants of measurement). At this time
    /// the velocities lack the drag of the last `kick` [s]. This drag is added for observers that require velocities,
    /// and taken back afterwards.
    fn see_between(
        &mut self,
        simulation: &mut Simulation,
        (now, kick): (f64, f64),
        observers: &mut [&mut dyn Observer],
    ) {
        let by_parts = |index: &usize| observers[*index].needs() == Needs::Parts && simulation.is_seen_by_all(*index);
        let (parts, due): (Vec<usize>, Vec<usize>) = self.due(now).into_iter().partition(by_parts);
        if !parts.is_empty() {
            simulation.with_synchronised_velocities(kick, |simulation| {
                see_parts(simulation, observers, &parts);
                self.see(simulation, now, observers, &parts);
            });
        }
        if !due.is_empty() {
            gather(simulation, due.iter().map(|index| observers[*index].needs()));
            if due.iter().any(|index| observers[*index].needs_velocities()) {
                simulation.with_synchronised_velocities(kick, |simulation| self.see(simulation, now, observers, &due));
            } else {
                self.see(simulation, now, observers, &due);
            }
        }
    }

    /// Adds the missing half-kick (change of velocity by drag and heat in half a window, the time between two
    /// exchanges with the gas) to a run that was stopped between two samples (instants of measurement). A caller that
    /// does not continue the run must call this function.
    pub fn finish_half_kick(&self, simulation: &mut Simulation) {
        simulation.finish_half_kick(self.schedule_position.window());
    }

    /// Calls the observers whose time has come, at a sample (instant of measurement). If several processes share the
    /// run, observers that require sums or parts are called in every process, with the particles of this process.
    fn sample(&mut self, simulation: &mut Simulation, observers: &mut [&mut dyn Observer]) {
        let by_parts = |index: &usize| {
            matches!(observers[*index].needs(), Needs::Sums | Needs::Parts) && simulation.is_seen_by_all(*index)
        };
        let (parts, others): (Vec<usize>, Vec<usize>) =
            self.due(self.schedule_position.now()).into_iter().partition(by_parts);
        see_parts(simulation, observers, &parts);
        self.see(simulation, self.schedule_position.now(), observers, &parts);
        gather(simulation, others.iter().map(|index| observers[*index].needs()));
        self.see(simulation, self.schedule_position.now(), observers, &others);
    }

    /// Calls the observers at the end of a run. After a failure of the engine they are called with all particles. If
    /// the run was stopped on request, observers that require [`Needs::Parts`] are first called with the particles of
    /// their process.
    pub fn end(&mut self, simulation: &mut Simulation, observers: &mut [&mut dyn Observer], failure: Option<&Failure>) {
        let needs: Vec<Needs> = observers.iter().map(|observer| observer.needs_at_end(simulation.time)).collect();
        let by_parts = |index: &usize| match needs[*index] {
            Needs::Parts => {
                matches!(failure, None | Some(Failure::Stopped { .. })) && simulation.is_seen_by_all(*index)
            }
            Needs::Sums => failure.is_none() && simulation.is_seen_by_all(*index),
            Needs::Nothing | Needs::Every(_) => false,
        };
        let (parts, others): (Vec<usize>, Vec<usize>) = (0..observers.len()).partition(by_parts);
        see_parts(simulation, observers, &parts);
        self.see(simulation, self.schedule_position.now(), observers, &parts);
        if failure.is_none() {
            gather(simulation, others.iter().map(|index| needs[*index]));
        } else {
            simulation.gather(1);
        }
        observers.iter_mut().for_each(|observer| observer.end(simulation));
    }

    /// Calls the observers at `indices` at `now` [s], and stores the next time of each.
    fn see(&mut self, simulation: &Simulation, now: f64, observers: &mut [&mut dyn Observer], indices: &[usize]) {
        for &index in indices {
            observers[index].see(simulation);
            // the next time is later than `now`, so that no observer is called twice at one time
            let later = now + 2.0 * self.schedule_position.schedule().rounding();
            self.due[index] = observers[index].next(now, self.schedule_position.schedule()).map(|time| time.max(later));
        }
    }

    /// Indices of the observers whose next time is `now` [s] or earlier.
    fn due(&self, now: f64) -> Vec<usize> {
        let reached = now + self.schedule_position.schedule().rounding();
        let is_due = |(index, due): (usize, &Option<f64>)| due.filter(|due| *due <= reached).map(|_| index);
        self.due.iter().enumerate().filter_map(is_due).collect()
    }

    /// Returns all data with which the run can continue from its present state.
    ///
    /// # Errors
    /// The engine or one of the observers cannot be stored.
    pub fn store(&self, simulation: &Simulation, observers: &[&mut dyn Observer]) -> Result<Pause, StoreError> {
        let observers = observers.iter().map(|observer| observer.stored()).collect::<Result<_, _>>()?;
        Ok(Pause { snapshot: simulation.snapshot()?, schedule_position: self.clone(), observers })
    }
}

/// Makes the other processes call their copies of the observers at `indices`, each with its own particles. Every
/// process has a copy of each of these observers.
fn see_parts(simulation: &mut Simulation, observers: &[&mut dyn Observer], indices: &[usize]) {
    simulation.see_parts(indices, |index| observers[index].stored().unwrap_or_default());
}

/// Gathers, in the lead process (process 0), the particles that observers require. `needs` holds the particles that
/// each of them requires.
fn gather(simulation: &mut Simulation, needs: impl Iterator<Item = Needs>) {
    let asked = needs.filter_map(|need| match need {
        Needs::Nothing => None,
        Needs::Sums | Needs::Parts => Some(1),
        Needs::Every(every) => Some(every),
    });
    // a part of the particles is enough only if all observers require the same part
    if let Some(every) = asked.reduce(|one, other| if one == other { one } else { 1 }) {
        simulation.gather(every);
    }
}

impl Pause {
    /// Resumes the run of `experiment`. The observers must have been newly created for this experiment, in the same
    /// order.
    ///
    /// # Errors
    /// The run was stored for another experiment, or with other observers.
    pub fn resume(
        self,
        experiment: &Experiment,
        observers: &mut [&mut dyn Observer],
    ) -> Result<(Simulation, RunLoop), StoreError> {
        self.snapshot.fits(experiment)?;
        let fresh = Simulation::new(experiment, self.snapshot.particles.clone());
        self.resume_as(fresh, experiment, observers)
    }

    /// Resumes the run. `fresh` is a simulation of the experiment in its initial state, which receives the stored
    /// state.
    pub fn resume_as(
        self,
        fresh: Simulation,
        experiment: &Experiment,
        observers: &mut [&mut dyn Observer],
    ) -> Result<(Simulation, RunLoop), StoreError> {
        let Self { snapshot, schedule_position, observers: stored } = self;
        snapshot.fits(experiment)?;
        if stored.len() != observers.len()
            || *schedule_position.schedule_position.schedule() != Schedule::new(experiment)
        {
            return Err(StoreError::misfit());
        }
        for (observer, stored) in observers.iter_mut().zip(&stored) {
            observer.restore(stored)?;
        }
        Ok((fresh.resume(snapshot)?, schedule_position))
    }
}
