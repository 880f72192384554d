//! Driver of the windows of all engines: islands as long as they pay, then all particles at once by the classical
//! algorithm.
//!
//! An engine is a [`Solver`]: it solves single islands, and all particles at once. State carried from one window to the
//! next (contacts in progress, times of recent collisions) belongs to the driver, which passes it to the method in use.

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

/// Data that an engine works on in a window.
pub struct Work<'a, C> {
    /// The particles.
    pub particles: &'a mut Particles,
    /// The scene.
    pub scene: &'a Scene,
    /// State carried from one window to the next, by index in the store.
    pub lasting: &'a mut Vec<C>,
    /// Log of the events in the window.
    pub log: &'a mut Log,
    /// Record that receives the log in the end; a solver that fills the log within a window may pass it on earlier.
    pub record: &'a mut Record,
}

/// State carried between windows, of the type of a solver.
pub type Lasting<S> = <<S as Solver>::Islands as Solve>::Carried;

/// Result of trying islands in a window.
#[derive(Clone, Copy)]
pub struct Trial {
    /// Time [s] covered by islands.
    pub done: f64,
    /// Counts before the trial.
    pub before: IslandCounters,
    /// Counts after the trial.
    pub after: IslandCounters,
}

/// Solver of single islands and of all particles at once.
pub trait Solver {
    /// Type that solves one island; several threads share it.
    type Islands: Solve;

    /// State that the solver keeps from one window to the next besides that of the driver.
    type State: Serialize + DeserializeOwned;

    /// The solver of islands.
    fn islands(&self) -> &Self::Islands;

    /// Sets up the state at the start of a run, such as contacts in progress.
    fn begin(&mut self, _work: &mut Work<Lasting<Self>>, _window: Window) {}

    /// Largest cost of islands in this window, per particle and simulated time [ns/s]. `None`: islands are not tried.
    /// Infinite: they are taken whenever possible.
    fn fallback_cost(
        &mut self,
        population: &PopulationSummary,
        speeds: &SpeedSummary,
        scene: &Scene,
        window: Window,
    ) -> Option<f64>;

    /// Adapts to the result of trying islands.
    fn judge(&mut self, _population: &PopulationSummary, _scene: &Scene, _trial: &Trial) {}

    /// Hands over carried state that the classical algorithm has kept at the end of a window. State that is not asked
    /// for stays where it is: a copy of all would need as much memory again.
    fn hand_over(&mut self, lasting: &mut Vec<Lasting<Self>>);

    /// Calls `visit` with the state that [`hand_over`](Self::hand_over) would hand over.
    fn for_each_kept(&self, visit: &mut dyn FnMut(Lasting<Self>));

    /// Invalidates data kept about the store: islands have moved the particles, or tried to.
    fn disturb(&mut self);

    /// Moves all particles through the window by the classical algorithm.
    ///
    /// # Errors
    /// The engine fails; the store then holds the state at that time.
    fn everyone(&mut self, work: &mut Work<Lasting<Self>>, window: Window) -> Result<(), Failure>;

    /// Counts of the work of the classical algorithm, plus those of islands.
    fn counters(&self, islands: &IslandCounters) -> Counters;

    /// Frees memory that only a further window would need, at the end of the run.
    fn forget(&mut self) {}

    /// Energy [J] stored in contacts, if all particles were moved at once last. `None` after islands; then it is the
    /// energy of the carried state.
    fn elastic_energy(&self) -> Option<f64>;

    /// Times the classical algorithm with this clock from now on.
    fn use_clock(&mut self, clock: Clock);

    /// Returns `spent` plus the time of the classical algorithm.
    fn spent(&self, spent: EngineTimes) -> EngineTimes;

    /// State that the solver keeps from one window to the next.
    fn state(&self) -> Self::State;

    /// Continues from a stored state.
    fn resume(&mut self, state: Self::State);
}

/// State of an engine between windows.
#[derive(Serialize, Deserialize)]
struct DriverState<C, S> {
    /// Contacts in progress, or times of recent collisions.
    lasting: Vec<C>,
    /// True if there has been a window.
    begun: bool,
    /// Counts of the work in islands.
    islands: IslandCounters,
    /// Time spent on islands.
    spent: EngineTimes,
    /// State that the solver keeps itself.
    solver: S,
}

/// An engine made of a solver.
pub struct Driver<S: Solver> {
    pub(super) solver: S,
    pub(super) islands: Islands<Lasting<S>>,
    pub(super) lasting: Vec<Lasting<S>>,
    begun: bool,
    /// True if the last window ended with all particles moved at once.
    everyone_last: bool,
    log: Log,
}

impl<S: DistributedSolver> Driver<S> {
    /// An engine before its first window.
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

    /// Sets up the state at the start of a run.
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

    /// Adapts to the result of trying islands: they have covered the time `done` [s].
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

    /// Calls `visit` with all carried state, of the driver and of the solver.
    pub(super) fn for_each_lasting(&self, visit: &mut dyn FnMut(Lasting<S>)) {
        self.lasting.iter().copied().for_each(&mut *visit);
        self.solver.for_each_kept(visit);
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
        known.unwrap_or_else(|| {
            let mut sum = ExactSum::default();
            let energy = |carried: &Lasting<S>| self.solver.islands().energy(carried);
            self.for_each_lasting(&mut |carried| sum.add(energy(&carried)));
            self.islands.processes.add_energy(&mut sum, energy);
            sum.value()
        })
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
        // if the run is cut, carried state is packed with the parts
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
