//! Driver of the windows of all engines. It solves islands for as long as they pay, and then moves all particles at
//! once by the classical algorithm. An island is a group of particles that may meet within a part of a window.
//!
//! An engine is a driver with a [`Solver`], which solves single islands and moves all particles at once. The driver
//! stores the state that is carried from one window to the next (contacts in progress, times of recent collisions). It
//! passes this state to the method in use.

use super::distributed::{Distributed, DistributedSolver};
use super::islands::{IslandCost, IslandCounters, Islands, Solve, SpeedSummary};
use super::population::PopulationSummary;
use super::{Counters, Engine, EngineTimes, Failure, Window};
use crate::clock::Clock;
use crate::encounter::Couple;
use crate::exact::ExactSum;
use crate::particles::Particles;
use crate::record::{Log, Record};
use crate::scene::Scene;
use crate::stored::{StoreError, Stored};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// Data that an engine reads and changes during a window.
pub struct Work<'a, C> {
    /// The particles, which the engine moves.
    pub particles: &'a mut Particles,
    /// The scene with walls, gravity and materials.
    pub scene: &'a Scene,
    /// State carried from one window to the next; it refers to particles by their index in the store.
    pub lasting: &'a mut Vec<C>,
    /// Log of the events in the window.
    pub log: &'a mut Log,
    /// Record to which the log is added at the end of the window. A solver that fills the log may add it earlier.
    pub record: &'a mut Record,
}

/// State that a solver of type `S` carries from one window to the next.
pub type Lasting<S> = <<S as Solver>::Islands as Solve>::Carried;

/// Result of trying islands in a window.
#[derive(Clone, Copy)]
pub struct Trial {
    /// Simulated time [s] for which islands were solved.
    pub done: f64,
    /// Counts of island work before the trial.
    pub before: IslandCounters,
    /// Counts of island work after the trial.
    pub after: IslandCounters,
}

/// The part of an engine that solves single islands and moves all particles at once.
pub trait Solver {
    /// Type that solves one island; several threads use it at the same time.
    type Islands: Solve;

    /// State that the solver itself keeps from one window to the next, in addition to that of the driver.
    type State: Serialize + DeserializeOwned;

    /// Returns the solver of islands.
    fn islands(&self) -> &Self::Islands;

    /// Sets up the carried state at the start of a run, such as contacts in progress.
    fn begin(&mut self, _work: &mut Work<Lasting<Self>>, _window: Window) {}

    /// Largest cost at which islands are used in this window, per particle and simulated time [ns/s]. With `None`
    /// islands are not tried. With infinity they are used whenever possible.
    fn fallback_cost(
        &mut self,
        population: &PopulationSummary,
        speeds: &SpeedSummary,
        scene: &Scene,
        window: Window,
    ) -> Option<f64>;

    /// Decides from a trial of islands (small groups solved separately) for how long islands are not tried again.
    fn judge(&mut self, _population: &PopulationSummary, _scene: &Scene, _trial: &Trial) {}

    /// Moves the carried state that the classical algorithm has kept to `lasting`. The driver calls this function only
    /// when islands or other processes need the state, because a copy of it would need as much memory again.
    fn hand_over(&mut self, lasting: &mut Vec<Lasting<Self>>);

    /// Calls `visit` with each item of state that [`hand_over`](Self::hand_over) would move.
    fn for_each_kept(&self, visit: &mut dyn FnMut(Lasting<Self>));

    /// Marks data about the store as outdated, because islands may have moved or sorted the particles.
    fn disturb(&mut self);

    /// Moves all particles through the window by the classical algorithm.
    ///
    /// # Errors
    /// The engine fails; the store then contains the state at the time of the failure.
    fn everyone(&mut self, work: &mut Work<Lasting<Self>>, window: Window) -> Result<(), Failure>;

    /// Counts of all work: that of the classical algorithm plus that in islands.
    fn counters(&self, islands: &IslandCounters) -> Counters;

    /// Frees memory that is needed only for a further window, at the end of the run.
    fn forget(&mut self) {}

    /// Energy [J] stored in contacts, if the classical algorithm moved the particles last. `None` after islands: the
    /// energy is then computed from the carried state.
    fn elastic_energy(&self) -> Option<f64>;

    /// Sets the clock that measures the time of the classical algorithm from now on.
    fn use_clock(&mut self, clock: Clock);

    /// Returns `spent` plus the time of the classical algorithm so far.
    fn spent(&self, spent: EngineTimes) -> EngineTimes;

    /// Returns the state that the solver itself keeps from one window to the next.
    fn state(&self) -> Self::State;

    /// Continues from a stored state of the solver.
    fn resume(&mut self, state: Self::State);
}

/// State of an engine between windows, as it is stored.
#[derive(Serialize, Deserialize)]
struct DriverState<C, S> {
    /// Contacts in progress, or times of recent collisions.
    lasting: Vec<C>,
    /// True after the first window.
    begun: bool,
    /// Counts of the work in islands.
    islands: IslandCounters,
    /// Wall-clock time spent on islands.
    spent: EngineTimes,
    /// State that the solver itself keeps.
    solver: S,
}

/// An engine that consists of a solver and the common handling of windows.
pub struct Driver<S: Solver> {
    pub(super) solver: S,
    pub(super) islands: Islands<Lasting<S>>,
    pub(super) lasting: Vec<Lasting<S>>,
    begun: bool,
    /// True if the classical algorithm moved the particles at the end of the last window.
    everyone_last: bool,
    log: Log,
}

impl<S: DistributedSolver> Driver<S> {
    /// Makes an engine before its first window.
    pub(super) fn with(solver: S) -> Self {
        Self {
            solver,
            islands: Islands::default(),
            lasting: Vec::new(),
            begun: false,
            everyone_last: false,
            log: Log::default(),
        }
    }

    /// Sets up the carried state in the first window.
    fn begin(&mut self, work: &mut Work<Lasting<S>>, window: Window) {
        if !std::mem::replace(&mut self.begun, true) && self.islands.processes.is_lead() {
            self.solver.begin(work, window);
        }
    }

    /// Data for the choice between islands and the classical algorithm; `None` if islands are not tried.
    fn choice(&mut self, work: &mut Work<Lasting<S>>, window: Window) -> Option<IslandCost> {
        let population = self.islands.population(work);
        let speeds = self.islands.speeds(work, &population);
        let fallback_cost = self.solver.fallback_cost(&population, &speeds, work.scene, window);
        let (fallback_cost, speeds) = self.of_lead(fallback_cost, speeds);
        let choice = IslandCost { population, speeds, fallback_cost: fallback_cost? };
        self.solver.hand_over(work.lasting);
        Some(choice)
    }

    /// Adapts to the result of trying islands; `done` is the simulated time [s] for which they were solved, or a
    /// failure.
    fn judge(&mut self, choice: &IslandCost, scene: &Scene, before: IslandCounters, done: &Result<f64, Failure>) {
        self.islands.processes.share_counts(&mut self.islands.counters, &before);
        let after = self.islands.counters();
        if let &Ok(done) = done {
            self.solver.judge(&choice.population, scene, &Trial { done, before, after });
        }
        if after.neighbour_builds != before.neighbour_builds {
            self.solver.disturb();
        }
    }

    /// Calls `visit` with each item of carried state, of the driver and of the solver.
    pub(super) fn for_each_lasting(&self, visit: &mut dyn FnMut(Lasting<S>)) {
        self.lasting.iter().copied().for_each(&mut *visit);
        self.solver.for_each_kept(visit);
    }

    /// Exact sum [J] of an energy over all carried state, of all processes.
    fn sum_of_lasting(&self, energy: impl Fn(&Lasting<S>) -> f64) -> f64 {
        let mut sum = ExactSum::default();
        self.for_each_lasting(&mut |carried| sum.add(energy(&carried)));
        self.islands.processes.add_energy(&mut sum, energy);
        sum.value()
    }
}

impl<S: DistributedSolver> Engine for Driver<S> {
    fn advance(
        &mut self,
        particles: &mut Particles,
        scene: &Scene,
        window: Window,
        record: &mut Record,
    ) -> Result<(), Failure> {
        let (mut log, mut lasting) = (std::mem::take(&mut self.log), std::mem::take(&mut self.lasting));
        let mut work = Work { particles, scene, lasting: &mut lasting, log: &mut log, record };
        self.begin(&mut work, window);
        let (before, choice) = (self.islands.counters(), self.choice(&mut work, window));
        let mut done = Ok(0.0);
        if let Some(choice) = choice {
            done = self.islands.advance(self.solver.islands(), &mut work, window, &choice);
            self.judge(&choice, scene, before, &done);
        }
        let result = done.and_then(|done| {
            self.everyone_last = done < window.duration;
            let rest = Window { start: window.start + done, duration: window.duration - done };
            if self.everyone_last { self.by_all(&mut work, rest) } else { Ok(()) }
        });
        self.lasting = lasting;
        record.absorb(&mut log);
        self.log = log;
        result
    }

    fn forget(&mut self) {
        self.solver.forget();
    }

    fn work_done(&self) -> (Counters, EngineTimes) {
        (self.solver.counters(&self.islands.counters()), self.solver.spent(self.islands.spent))
    }

    fn elastic_energy(&self) -> f64 {
        let known = if self.is_cut() { None } else { self.solver.elastic_energy() };
        known.unwrap_or_else(|| self.sum_of_lasting(|carried| self.solver.islands().energy(carried)))
    }

    fn spring_energies(&self) -> [f64; 3] {
        let islands = self.solver.islands();
        std::array::from_fn(|kind| self.sum_of_lasting(|carried| islands.spring_energies(carried)[kind]))
    }

    fn for_each_touching(&self, visit: &mut dyn FnMut(Couple)) {
        self.for_each_lasting(&mut |carried| {
            self.solver.islands().touching(&carried).into_iter().for_each(&mut *visit)
        });
    }

    fn in_islands(&self) -> Option<&[u32]> {
        (!self.everyone_last).then(|| self.islands.members())
    }

    fn use_clock(&mut self, clock: Clock) {
        self.islands.clock = clock.clone();
        self.solver.use_clock(clock);
    }

    fn stored(&self) -> Result<Stored, StoreError> {
        let mut lasting = Vec::new();
        // if processes share the run, each stores its carried state together with its particles
        if !self.is_cut() {
            self.for_each_lasting(&mut |carried| lasting.push(carried));
        }
        Stored::of(&DriverState {
            lasting,
            begun: self.begun,
            islands: self.islands.counters(),
            spent: self.islands.spent,
            solver: self.solver.state(),
        })
    }

    fn restore(&mut self, stored: &Stored) -> Result<(), StoreError> {
        let state: DriverState<Lasting<S>, S::State> = stored.read()?;
        self.lasting = state.lasting;
        self.begun = state.begun;
        self.islands.resume(state.islands, state.spent);
        self.solver.resume(state.solver);
        Ok(())
    }
}
