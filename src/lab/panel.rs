//! Panel of the lab: a simulation that advances window by window, and the data about its state for the page. A window
//! is the time between two exchanges of momentum with the gas.

use super::frame::{DrawnParticle, Live, Now, drawn, words};
use super::gauge::{Gauge, Meter};
use crate::clock::Clock;
use crate::engine::Failure;
use crate::experiment::{Experiment, HardStepping, Model};
use crate::observe::{Observer, RunLoop};
use crate::outcome::Outcome;
use crate::particles::Particles;
use crate::runs::StandardObservers;
use crate::schedule::Schedule;
use crate::simulation::{Simulation, soft_step};
use std::time::Duration;

/// Largest number of measured rows in a frame (data of one instant that are sent to the page). If more rows were
/// measured, only every n-th row is sent.
const MOST_ROWS: usize = 100;

/// Smallest number of windows per frame (picture on the page) at the default pace (simulated time divided by wall time)
/// of a scene. Windows are pieces of the run, after each of which the panel can show its state. With two windows, the
/// motion is also smooth at half of this pace.
const WINDOWS_PER_FRAME: f64 = 2.0;

/// Running simulation of one panel, with the observers that measure it.
pub struct LabPanel<'a> {
    simulation: Simulation,
    course: RunLoop,
    meter: Meter<'a>,
    /// Observers that measure averages for the comparison of both panels; `None` in scenes whose panels are not
    /// compared.
    seen: Option<StandardObservers<'a>>,
    at_start: f64,
    over: bool,
    failure: Option<Failure>,
}

/// Schedule of the run: the length of its windows (pieces of the run after which the panel can show its state). `frame`
/// [s] is the simulated time between two pictures on the page. With drag, or with hard spheres that move in time steps,
/// the windows are those of the case. Otherwise a window lasts at most half of `frame`, or a single time step if the
/// step is longer than that. In soft and hybrid runs the length of a window is about a whole multiple of the time step.
fn schedule(experiment: &Experiment, particles: usize, frame: f64) -> Schedule {
    let own = Schedule::new(experiment);
    let dragged = experiment.scene.fluid.as_ref().is_some_and(|fluid| fluid.drag.is_some());
    let stepped = experiment.model() == Model::Hard && experiment.hard.stepping != HardStepping::Events;
    if dragged || stepped {
        return own;
    }
    let duration = experiment.run.duration;
    let longest = own.window.min(frame / WINDOWS_PER_FRAME);
    let step = if experiment.model().has_contacts() { soft_step(experiment, particles) } else { f64::INFINITY };
    let window = if step.is_finite() { step * (longest / step).floor().max(1.0) } else { longest };
    let windows = (duration / window - 1e-9).ceil().max(1.0);
    Schedule::even(duration / windows, 1, windows as u64)
}

impl<'a> LabPanel<'a> {
    /// Creates a panel in its initial state `start`; `frame` [s] is the simulated time between two pictures on the
    /// page.
    pub fn new(experiment: &'a Experiment, start: Particles, gauge: Gauge, frame: f64) -> Self {
        let schedule = schedule(experiment, start.len(), frame);
        let mut seen = (gauge == Gauge::Channel).then(|| StandardObservers::new(experiment, start.fingerprint()));
        let observers = 1 + seen.as_mut().map_or(0, |seen| seen.with(&mut []).len());
        let simulation = Simulation::new(experiment, start).with_clock(Clock::wall());
        Self {
            at_start: simulation.energy(),
            simulation,
            course: RunLoop::new(&schedule, observers),
            meter: Meter::new(gauge, experiment),
            seen,
            over: false,
            failure: None,
        }
    }

    /// [s] simulated time that the panel has reached; `None` if its run has ended.
    pub fn running(&self) -> Option<f64> {
        (!self.over).then_some(self.simulation.time)
    }

    /// Continues the run until it reaches the simulated time `until` [s], the wall time `most` has passed, or the run
    /// has ended or failed.
    pub fn run(&mut self, until: f64, most: Duration) {
        if self.over || self.simulation.time >= until {
            return;
        }
        let Self { simulation, course, meter, seen, .. } = self;
        let clock = simulation.clock();
        let (ends, reached) = (clock.now() + most, clock.reached());
        let mut leave = || clock.now() >= ends || reached.as_ref().is_some_and(|reached| reached.time() >= until);
        let result = match seen {
            Some(seen) => course.run(simulation, &mut seen.with(&mut [meter]), &mut leave),
            None => course.run(simulation, &mut [meter as &mut dyn Observer], &mut leave),
        };
        match result {
            Ok(over) => self.over = over,
            Err(failure) => {
                self.meter.see(&self.simulation);
                self.failure = Some(failure);
                self.over = true;
            }
        }
    }

    /// State of the panel for the page, with the rows of quantities measured since the previous call. At most 100 rows
    /// are returned.
    pub fn now(&mut self) -> Now {
        let mut rows = std::mem::take(&mut self.meter.rows);
        let every = rows.len().div_ceil(MOST_ROWS).max(1);
        let mut place = rows.len();
        // the last row is always returned
        rows.retain(|_| {
            place -= 1;
            place.is_multiple_of(every)
        });
        let state = match (&self.failure, self.over) {
            (Some(_), _) => "failed",
            (None, true) => "over",
            (None, false) => "running",
        };
        let mut live = Live::of(&self.simulation, self.at_start);
        live.restitution = live.restitution.filter(|_| self.meter.gauge.has_lone_impacts());
        live.cost = live.cost.filter(|_| self.meter.gauge.tells_cost());
        Now { time: self.simulation.time, state, failure: self.failure.as_ref().map(words), rows, live }
    }

    /// Particles of the panel as the page draws them, in the order of ids.
    pub fn particles(&self) -> Vec<DrawnParticle> {
        drawn(&self.simulation, usize::MAX)
    }

    /// Results of the panel so far, for the comparison of both panels. `None` at the start, and in scenes whose panels
    /// are not compared.
    pub fn outcome(&self) -> Option<Outcome> {
        let seen = self.seen.clone()?;
        let hash = self.simulation.state().fingerprint();
        (self.simulation.time > 0.0).then(|| seen.outcome(&self.simulation, self.failure.clone(), hash))
    }
}
