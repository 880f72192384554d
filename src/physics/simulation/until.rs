//! Runs a simulation up to a given time, in the windows of its schedule. A window is the time between two exchanges
//! with the gas.

use super::Simulation;
use crate::engine::Failure;
use crate::experiment::{Experiment, Population, Spheres};
use crate::particles::Particles;
use crate::placement::{Crowded, initial_state};
use crate::schedule::{Schedule, SchedulePosition};

impl Simulation {
    /// Creates a simulation from the initial state that the experiment describes.
    ///
    /// # Errors
    /// No random start without overlap was found.
    pub fn from_start(experiment: &Experiment) -> Result<Self, Crowded> {
        Ok(Self::new(experiment, initial_state(experiment)?))
    }

    /// Runs until `time` [s] in the windows (times between two exchanges with the gas) that the program uses for the
    /// experiment. For a simulation with an engine of the calling program, the first call chooses the length of the
    /// windows from the particles, and later calls keep this length. At the end, velocities and positions belong to
    /// `time`. If the simulation has reached `time` already, no window is run, and velocities only get a missing
    /// change by drag.
    ///
    /// A call that ends at a sample (instant of measurement) of the schedule changes no bit of the results. At any
    /// other time the call divides a change of velocity by drag, which changes rounding, and may divide a window.
    ///
    /// # Errors
    /// Errors of [`run`](Self::run).
    pub fn run_until(&mut self, time: f64) -> Result<(), Failure> {
        self.run_until_while(time, &mut |_| true)?;
        self.complete()
    }

    /// Runs like [`run_until`](Self::run_until), but only as long as `go_on` returns true. Returns true if `time` [s]
    /// is reached, false after a stop. `go_on` is called at the end of every window but the last, and where the
    /// schedule divides a window.
    ///
    /// Drag changes velocities by half a kick (half-kick) before and after each window. If `go_on` stops the run within
    /// a series of equal windows, the velocities lack the last half-kick. A run to a later time adds this half-kick,
    /// and has bit by bit the results of a run that was not stopped. [`complete`](Self::complete) adds the half-kick at
    /// once.
    ///
    /// # Errors
    /// Errors of [`run`](Self::run).
    pub fn run_until_while(&mut self, time: f64, go_on: &mut dyn FnMut(&mut Self) -> bool) -> Result<bool, Failure> {
        let result = self.in_pieces(time, go_on);
        self.gather(1);
        result
    }

    /// Adds the change by drag in half a window (half-kick) that velocities lack after
    /// [`run_until_while`](Self::run_until_while) was stopped. The half-kick divides a kick, which changes rounding.
    ///
    /// # Errors
    /// A particle left the domain, or energy grew more than errors of the time integrator explain.
    pub fn complete(&mut self) -> Result<(), Failure> {
        if self.half_kicked {
            return Ok(());
        }
        self.finish_half_kick(self.schedule_position.window());
        self.check()
    }

    /// [s] end of the present window (time between two exchanges with the gas) of the schedule; `None` if no windows
    /// are chosen yet.
    pub fn end_of_window(&self) -> Option<f64> {
        (self.schedule_position.window() > 0.0)
            .then(|| self.position_at_present(*self.schedule_position.schedule()).after(1))
    }

    /// [s] time of the next sample (instant of measurement) of the schedule; `None` if no windows are chosen yet.
    pub fn next_sample(&self) -> Option<f64> {
        (self.schedule_position.window() > 0.0)
            .then(|| self.position_at_present(*self.schedule_position.schedule()).next_sample())
    }

    fn in_pieces(&mut self, time: f64, go_on: &mut dyn FnMut(&mut Self) -> bool) -> Result<bool, Failure> {
        if time.is_nan() || time <= self.time {
            return Ok(true);
        }
        let has_windows = self.schedule_position.window() > 0.0;
        let schedule = if has_windows { *self.schedule_position.schedule() } else { self.chosen(time - self.time) };
        let mut schedule_position = self.position_at_present(schedule);
        loop {
            let rest = time - schedule_position.now();
            if rest <= schedule_position.schedule().rounding() {
                return Ok(true);
            }
            let step = schedule_position.next(time);
            let (windows, window) = schedule_position.lengths(step);
            if window != schedule_position.window() {
                self.complete()?;
            }
            let ran = self.run_while(windows, window, &mut |simulation, _| go_on(simulation))?;
            schedule_position.advance(step, ran);
            self.schedule_position = schedule_position.clone();
            if ran < windows {
                return Ok(false);
            }
            if time - schedule_position.now() > schedule_position.schedule().rounding() && !go_on(self) {
                return Ok(false);
            }
        }
    }

    /// Position of the present time in `schedule`. It is the stored position, unless other methods have moved the
    /// simulation since. After such a move the position is found from the time.
    fn position_at_present(&self, schedule: Schedule) -> SchedulePosition {
        let known = Some(&self.schedule_position)
            .filter(|schedule_position| schedule_position.window() > 0.0 && schedule_position.is_at(self.time));
        known.cloned().unwrap_or_else(|| SchedulePosition::at(schedule, self.time))
    }

    /// Chooses a schedule for the particles of this simulation, which move for `duration` [s]. All its windows (times
    /// between two exchanges with the gas) have one length.
    fn chosen(&self, duration: f64) -> Schedule {
        let population = |species: u16| {
            let is_own = |index: &u32| self.particles.species[*index as usize] == species;
            let mut own = Particles::default();
            own.copy_from(&self.particles, &(0..self.particles.len() as u32).filter(is_own).collect::<Vec<u32>>());
            Population::placed(species, own)
        };
        let start = (0..self.scene.species.len() as u16).map(population).collect();
        let schedule = Schedule::new(&Experiment::new(self.scene.clone(), start, Spheres::Hard, duration));
        Schedule { longer: Default::default(), ..schedule }
    }
}
