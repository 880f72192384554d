//! The loop over a run, and a run that is left on its way.

use super::{Needs, Observer};
use crate::engine::Failure;
use crate::experiment::Experiment;
use crate::schedule::{Schedule, ScheduleStep};
use crate::simulation::{Simulation, Snapshot};
use crate::stored::{StoreError, Stored};
use serde::{Deserialize, Serialize};

/// How far a run has come, and who is to see it when.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunLoop {
    schedule: Schedule,
    /// Windows done, counted in the shortest ones.
    done: u64,
    /// [s] the instant asked for at which the window under way has been cut last; `None`: it is at the end of a window.
    cut: Option<f64>,
    /// [s] at or after which each observer is to see the simulation next.
    due: Vec<Option<f64>>,
}

/// A run that has been left at the end of a window: all that it needs to go on with the same bits.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Pause {
    /// The simulation.
    pub snapshot: Snapshot,
    course: RunLoop,
    observers: Vec<Stored>,
}

impl RunLoop {
    /// The start of a run with so many observers.
    pub fn new(schedule: &Schedule, observers: usize) -> Self {
        Self { schedule: *schedule, done: 0, cut: None, due: vec![Some(0.0); observers] }
    }

    /// Runs on, shows the simulation to the observers at their times, and asks `pause` at the end of every window whether to leave the
    /// run there. True if the run is over.
    ///
    /// A run that was left goes on when this is called again, here or from a [`Pause`]. Who does not go on calls
    /// [`settle`](Self::settle).
    ///
    /// # Errors
    /// The failure that stopped it.
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
            if self.done == self.schedule.length() {
                return Ok(true);
            }
            // a run that has not moved would be left at the same place for ever
            if has_moved && pause() {
                return Ok(false);
            }
            has_moved = true;
            match self.schedule.piece(self.done, self.now()) {
                ScheduleStep::Windows(windows) => {
                    if !self.through_windows(windows, simulation, observers, pause)? {
                        return Ok(false);
                    }
                }
                ScheduleStep::ToInstant(instant) => {
                    simulation.run_while(1, instant - self.now(), &mut |_, _| true)?;
                    self.cut = Some(instant);
                }
                ScheduleStep::ToEnd(end) => {
                    simulation.run_while(1, end - self.now(), &mut |_, _| true)?;
                    self.done += self.schedule.together(self.done);
                    self.cut = None;
                }
            }
        }
    }

    /// Runs so many whole windows; false if it was left before.
    fn through_windows(
        &mut self,
        windows: u64,
        simulation: &mut Simulation,
        observers: &mut [&mut dyn Observer],
        pause: &mut dyn FnMut() -> bool,
    ) -> Result<bool, Failure> {
        let (before, together) = (self.done, self.schedule.together(self.done));
        let window = self.schedule.window * together as f64;
        let ran = simulation.run_while(windows, window, &mut |simulation, ran| {
            let now = (before + ran * together) as f64 * self.schedule.window;
            let by_parts =
                |place: &usize| observers[*place].sight() == Needs::Parts && simulation.is_seen_by_all(*place);
            let (parts, due): (Vec<usize>, Vec<usize>) = self.due(now).into_iter().partition(by_parts);
            if !parts.is_empty() {
                simulation.look(0.5 * window, |simulation| {
                    show_parts(simulation, observers, &parts);
                    self.see(simulation, now, observers, &parts);
                });
            }
            if !due.is_empty() {
                show(simulation, due.iter().map(|place| observers[*place].sight()));
                if due.iter().any(|place| observers[*place].needs_velocities()) {
                    simulation.look(0.5 * window, |simulation| self.see(simulation, now, observers, &due));
                } else {
                    self.see(simulation, now, observers, &due);
                }
            }
            !pause()
        })?;
        self.done += ran * together;
        Ok(ran == windows)
    }

    /// [s] where it is, of the schedule: the rounding of the simulation's own time adds up over millions of windows.
    fn now(&self) -> f64 {
        self.cut.unwrap_or(self.done as f64 * self.schedule.window)
    }

    /// Gives the velocities the half-kick of drag that they lack in a run that was left between two samples, for whoever does not go on.
    pub fn settle(&self, simulation: &mut Simulation) {
        simulation.settle(self.schedule.window * self.schedule.together(self.done) as f64);
    }

    /// Shows a sample to those whose time it is. Where processes share the run, those who need sums or parts see it in all of them, each a part.
    fn sample(&mut self, simulation: &mut Simulation, observers: &mut [&mut dyn Observer]) {
        let by_parts = |place: &usize| {
            matches!(observers[*place].sight(), Needs::Sums | Needs::Parts) && simulation.is_seen_by_all(*place)
        };
        let (parts, others): (Vec<usize>, Vec<usize>) = self.due(self.now()).into_iter().partition(by_parts);
        show_parts(simulation, observers, &parts);
        self.see(simulation, self.now(), observers, &parts);
        show(simulation, others.iter().map(|place| observers[*place].sight()));
        self.see(simulation, self.now(), observers, &others);
    }

    /// Shows the observers the end of a run. After a failure of the engine they are shown all particles; if it was told to stop, those who see parts see
    /// these before.
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
        self.see(simulation, self.now(), observers, &parts);
        if failure.is_none() {
            show(simulation, others.iter().map(|place| sight[*place]));
        } else {
            simulation.show(1);
        }
        observers.iter_mut().for_each(|observer| observer.end(simulation));
    }

    /// Shows the simulation at `now` [s] to the observers at those places, and asks them when they want to see it next.
    fn see(&mut self, simulation: &Simulation, now: f64, observers: &mut [&mut dyn Observer], places: &[usize]) {
        for &place in places {
            observers[place].see(simulation);
            // not twice at one time
            let later = now + 2.0 * self.schedule.rounding();
            self.due[place] = observers[place].next(now, &self.schedule).map(|time| time.max(later));
        }
    }

    /// Places of the observers that want to see the simulation at `now` [s].
    fn due(&self, now: f64) -> Vec<usize> {
        let reached = now + self.schedule.rounding();
        let is_due = |(place, due): (usize, &Option<f64>)| due.filter(|due| *due <= reached).map(|_| place);
        self.due.iter().enumerate().filter_map(is_due).collect()
    }

    /// All that the run needs to go on from here.
    ///
    /// # Errors
    /// An engine or an observer of the caller's cannot be stored.
    pub fn store(&self, simulation: &Simulation, observers: &[&mut dyn Observer]) -> Result<Pause, StoreError> {
        let observers = observers.iter().map(|observer| observer.stored()).collect::<Result<_, _>>()?;
        Ok(Pause { snapshot: simulation.snapshot()?, course: self.clone(), observers })
    }
}

/// Lets all processes show their parts to the observers at those places, which everybody has.
fn show_parts(simulation: &mut Simulation, observers: &[&mut dyn Observer], places: &[usize]) {
    simulation.show_parts(places, |place| observers[place].stored().unwrap_or_default());
}

/// Brings together what observers have to see.
fn show(simulation: &mut Simulation, sights: impl Iterator<Item = Needs>) {
    let asked = sights.filter_map(|sight| match sight {
        Needs::Nothing => None,
        Needs::Sums | Needs::Parts => Some(1),
        Needs::Every(every) => Some(every),
    });
    // who follows the same few can be shown these alone
    if let Some(every) = asked.reduce(|one, other| if one == other { one } else { 1 }) {
        simulation.show(every);
    }
}

impl Pause {
    /// The run of that experiment to go on with, seen by observers that were made for it anew, in the same order.
    ///
    /// # Errors
    /// It was stored of another experiment, or of other observers.
    pub fn resume(
        self,
        experiment: &Experiment,
        observers: &mut [&mut dyn Observer],
    ) -> Result<(Simulation, RunLoop), StoreError> {
        self.snapshot.fits(experiment)?;
        let fresh = Simulation::new(experiment, self.snapshot.particles.clone());
        self.resume_as(fresh, experiment, observers)
    }

    /// The same, with a simulation of its start.
    ///
    /// # Errors
    /// As for [`resume`](Self::resume).
    pub fn resume_as(
        self,
        fresh: Simulation,
        experiment: &Experiment,
        observers: &mut [&mut dyn Observer],
    ) -> Result<(Simulation, RunLoop), StoreError> {
        let Self { snapshot, course, observers: stored } = self;
        snapshot.fits(experiment)?;
        if stored.len() != observers.len() || course.schedule != Schedule::new(experiment) {
            return Err(StoreError::misfit());
        }
        for (observer, stored) in observers.iter_mut().zip(&stored) {
            observer.restore(stored)?;
        }
        Ok((fresh.resume(snapshot)?, course))
    }
}
