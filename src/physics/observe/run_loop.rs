//! Loop over a run, which can be stopped at the end of any window, stored, and resumed. A window is the time between
//! two exchanges of momentum with the gas.

use super::{Needs, Observer};
use crate::engine::Failure;
use crate::experiment::Experiment;
use crate::schedule::{Schedule, SchedulePosition};
use crate::simulation::{Simulation, Snapshot};
use crate::stored::{StoreError, Stored};
use serde::{Deserialize, Serialize};

/// Loop over a run: its position in the schedule, and the next times of the observers.
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
    /// State of the simulation at the pause.
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
    /// exchanges with the gas) if `pause` returns true. Returns true if the run is over.
    ///
    /// A stopped run continues at the next call of this method, also after it was restored from a [`Pause`]. A caller
    /// that does not continue the run calls [`settle`](Self::settle).
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
        let start = clock.now();
        let over = self.through_samples(simulation, observers, pause);
        simulation.spent.whole += clock.now() - start;
        over
    }

    fn through_samples(
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
            simulation.spent.observers += clock.now() - began;
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
            let ran = simulation.run_while(windows, window, &mut |simulation, ran| {
                self.see_between(simulation, (self.schedule_position.after(ran), 0.5 * window), observers);
                !pause()
            })?;
            self.schedule_position.advance(step, ran);
            if ran < windows {
                return Ok(false);
            }
        }
    }

    /// Calls the observers whose time is `now` [s], between two samples (instants of measurement). The drag of the time
    /// `kick` [s], half of a drag step, is missing in the velocities. It is added for observers that require
    /// velocities.
    fn see_between(
        &mut self,
        simulation: &mut Simulation,
        (now, kick): (f64, f64),
        observers: &mut [&mut dyn Observer],
    ) {
        let by_parts = |place: &usize| observers[*place].sight() == Needs::Parts && simulation.is_seen_by_all(*place);
        let (parts, due): (Vec<usize>, Vec<usize>) = self.due(now).into_iter().partition(by_parts);
        if !parts.is_empty() {
            simulation.look(kick, |simulation| {
                show_parts(simulation, observers, &parts);
                self.see(simulation, now, observers, &parts);
            });
        }
        if !due.is_empty() {
            show(simulation, due.iter().map(|place| observers[*place].sight()));
            if due.iter().any(|place| observers[*place].needs_velocities()) {
                simulation.look(kick, |simulation| self.see(simulation, now, observers, &due));
            } else {
                self.see(simulation, now, observers, &due);
            }
        }
    }

    /// Adds the missing half step of drag to the velocities of a run that was stopped between two samples. A caller
    /// that does not continue the run must call this function.
    pub fn settle(&self, simulation: &mut Simulation) {
        simulation.settle(self.schedule_position.window());
    }

    /// Calls the observers whose time has come, at a sample (instant of measurement). If several processes share the
    /// run, observers that require sums or parts are called in every process, with the particles of this process.
    fn sample(&mut self, simulation: &mut Simulation, observers: &mut [&mut dyn Observer]) {
        let by_parts = |place: &usize| {
            matches!(observers[*place].sight(), Needs::Sums | Needs::Parts) && simulation.is_seen_by_all(*place)
        };
        let (parts, others): (Vec<usize>, Vec<usize>) =
            self.due(self.schedule_position.now()).into_iter().partition(by_parts);
        show_parts(simulation, observers, &parts);
        self.see(simulation, self.schedule_position.now(), observers, &parts);
        show(simulation, others.iter().map(|place| observers[*place].sight()));
        self.see(simulation, self.schedule_position.now(), observers, &others);
    }

    /// Calls the observers at the end of a run. After a failure of the engine they are called with all particles. If
    /// the run was stopped on request, observers that require [`Needs::Parts`] are first called with the particles of
    /// their process.
    pub fn end(&mut self, simulation: &mut Simulation, observers: &mut [&mut dyn Observer], failure: Option<&Failure>) {
        let sight: Vec<Needs> = observers.iter().map(|observer| observer.sight_of_end(simulation.time)).collect();
        let by_parts = |place: &usize| match sight[*place] {
            Needs::Parts => {
                matches!(failure, None | Some(Failure::Stopped { .. })) && simulation.is_seen_by_all(*place)
            }
            Needs::Sums => failure.is_none() && simulation.is_seen_by_all(*place),
            Needs::Nothing | Needs::Every(_) => false,
        };
        let (parts, others): (Vec<usize>, Vec<usize>) = (0..observers.len()).partition(by_parts);
        show_parts(simulation, observers, &parts);
        self.see(simulation, self.schedule_position.now(), observers, &parts);
        if failure.is_none() {
            show(simulation, others.iter().map(|place| sight[*place]));
        } else {
            simulation.show(1);
        }
        observers.iter_mut().for_each(|observer| observer.end(simulation));
    }

    /// Calls the observers with the indices `places` at `now` [s], and stores the next time of each.
    fn see(&mut self, simulation: &Simulation, now: f64, observers: &mut [&mut dyn Observer], places: &[usize]) {
        for &place in places {
            observers[place].see(simulation);
            // the next time is later than `now`, so that no observer is called twice at one time
            let later = now + 2.0 * self.schedule_position.schedule().rounding();
            self.due[place] = observers[place].next(now, self.schedule_position.schedule()).map(|time| time.max(later));
        }
    }

    /// Indices of the observers whose next time is `now` [s] or earlier.
    fn due(&self, now: f64) -> Vec<usize> {
        let reached = now + self.schedule_position.schedule().rounding();
        let is_due = |(place, due): (usize, &Option<f64>)| due.filter(|due| *due <= reached).map(|_| place);
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

/// Calls the observers with the indices `places` in every process, with the particles of this process. Every process
/// has a copy of each of these observers.
fn show_parts(simulation: &mut Simulation, observers: &[&mut dyn Observer], places: &[usize]) {
    simulation.show_parts(places, |place| observers[place].stored().unwrap_or_default());
}

/// Gathers, in the lead process, the particles that observers require. `sights` holds the particles that each of them
/// requires.
fn show(simulation: &mut Simulation, sights: impl Iterator<Item = Needs>) {
    let asked = sights.filter_map(|sight| match sight {
        Needs::Nothing => None,
        Needs::Sums | Needs::Parts => Some(1),
        Needs::Every(every) => Some(every),
    });
    // a part of the particles is enough only if all observers require the same part
    if let Some(every) = asked.reduce(|one, other| if one == other { one } else { 1 }) {
        simulation.show(every);
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
