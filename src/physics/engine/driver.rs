//! Driver that moves soft, event-driven hard and hybrid spheres through windows. The engines of hard spheres in time
//! steps and of collisions by chance (DSMC) do not use this driver. A window is the time between two exchanges of
//! momentum with the gas. In each window the driver first solves islands, for as long as they cost less computing time.
//! Then it moves all particles at once by the classical algorithm (uniform time steps, or one event queue). An island
//! is a group of particles that may meet within a part of a window.
//!
//! Each of the three engines is a driver with a [`Solver`], which solves single islands and moves all particles at
//! once. The driver stores the *carried* state, which continues from one window to the next: contacts in progress, or
//! times of recent collisions. The driver passes this state to the method in use.

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

/// Data that an engine reads and changes during a time window.
pub struct Work<'a, C> {
    /// The particles, which the engine moves.
    pub particles: &'a mut Particles,
    /// The scene with walls, gravity and materials.
    pub scene: &'a Scene,
    /// State carried from one time window to the next, such as contacts; it contains indices of particles in the
    /// particle store.
    pub lasting: &'a mut Vec<C>,
    /// Log of the impacts, energies and impulses in the time window.
    pub log: &'a mut Log,
    /// Record of the run (sums over impacts, energies and impulses), to which the log is added at the end of the time
    /// window. If the log is full, a solver may add it to the record earlier.
    pub record: &'a mut Record,
}

impl<C> Work<'_, C> {
    /// Returns these data with `scene` in place of their scene. `scene` describes the same scene at another instant of
    /// the window, since walls may move.
    pub fn in_scene<'b>(&'b mut self, scene: &'b Scene) -> Work<'b, C> {
        let Self { particles, lasting, log, record, .. } = self;
        Work { particles, scene, lasting, log, record }
    }

    /// Shifts particles outside the box by whole periods into the box. If sides of the box are sheared, particles that
    /// cross these sides change their energy and momentum. These changes are added to the ledger, the sums of energies
    /// and momenta of the run.
    pub fn wrap(&mut self) {
        let crossings = self.particles.wrap(&self.scene.domain);
        if self.scene.domain.shear.is_some() {
            self.record.ledger += crossings;
        }
    }
}

/// State that a solver of type `S` carries from one time window to the next: a contact in progress, or a recent
/// collision.
pub type Lasting<S> = <<S as Solver>::Islands as Solve>::Carried;

/// Result of trying to solve islands (groups of particles that may meet) in a time window.
#[derive(Clone, Copy)]
pub struct Trial {
    /// [s] time from the start of the window to the instant up to which islands (groups of particles that may meet)
    /// were solved.
    pub done: f64,
    /// Counts of the work in islands (groups of particles that may meet) before they were tried.
    pub before: IslandCounters,
    /// Counts of the work in islands (groups of particles that may meet) after they were tried.
    pub after: IslandCounters,
}

/// Methods of an engine that solve single islands (groups of particles that may meet), and that move all particles at
/// once.
pub trait Solver: Send {
    /// Type that solves a single island (group of particles that may meet); several threads use it at the same time.
    type Islands: Solve;

    /// State that the solver itself keeps from one time window to the next. The driver keeps contacts in progress and
    /// recent collisions.
    type State: Serialize + DeserializeOwned;

    /// Returns the solver of single islands (groups of particles that may meet), which is a component of this solver.
    fn islands(&self) -> &Self::Islands;

    /// Makes the state that is carried from one window to the next, at the start of a run. For soft spheres this state
    /// consists of the contacts of particles that overlap at the start. The default makes no state.
    fn begin(&mut self, _work: &mut Work<Lasting<Self>>, _window: Window) {}

    /// Largest cost (computing time) at which islands (groups of particles that may meet) are used in this time window,
    /// per particle and simulated time [ns/s]. With `None` islands are not tried. With infinity islands are used
    /// whenever possible.
    fn fallback_cost(
        &mut self,
        population: &PopulationSummary,
        speeds: &SpeedSummary,
        scene: &Scene,
        window: Window,
    ) -> Option<f64>;

    /// Decides, from the result `_trial` of trying islands (groups of particles that may meet), for how many windows
    /// islands are not tried again. The default does nothing.
    fn judge(&mut self, _population: &PopulationSummary, _scene: &Scene, _trial: &Trial) {}

    /// Moves to `lasting` the carried state (such as contacts) that the classical algorithm (all particles at once) has
    /// stored. The driver calls this function only when islands (groups of particles that may meet) or other processes
    /// need the state, because a copy would double the memory.
    fn hand_over(&mut self, lasting: &mut Vec<Lasting<Self>>);

    /// Calls `visit` with a copy of each item of carried state (such as a contact) that the classical algorithm (all
    /// particles at once) has stored.
    fn for_each_kept(&self, visit: &mut dyn FnMut(Lasting<Self>));

    /// Marks the stored order and positions of the particles as outdated. Islands (groups of particles that may meet)
    /// may have moved or sorted the particles.
    fn disturb(&mut self);

    /// Marks data about the particle store as outdated, because particles have left the store or come into it. The
    /// caller has already taken out the carried state (such as contacts).
    fn repopulate(&mut self) {
        self.disturb();
    }

    /// Moves all particles at once through the window, by uniform time steps or by one event queue (the classical
    /// algorithm).
    ///
    /// # Errors
    /// The engine fails; `work.particles` then contains the state at the time of the failure.
    fn advance_all(&mut self, work: &mut Work<Lasting<Self>>, window: Window) -> Result<(), Failure>;

    /// Counts of all work: that of the classical algorithm (all particles at once), plus that in islands (groups of
    /// particles that may meet).
    fn counters(&self, islands: &IslandCounters) -> Counters;

    /// Frees, at the end of the run, memory that is needed only for a further time window.
    fn forget(&mut self) {}

    /// Energy [J] stored in contacts, if the classical algorithm (all particles at once) moved the particles last.
    /// `None` if islands (groups of particles that may meet) did; the energy is then computed from the carried state,
    /// the contacts in progress.
    fn elastic_energy(&self) -> Option<f64>;

    /// Sets the clock that measures the computing time of the classical algorithm (all particles at once) from now on.
    fn use_clock(&mut self, clock: Clock);

    /// Returns `spent` plus the computing time of the classical algorithm (all particles at once) so far.
    fn spent(&self, spent: EngineTimes) -> EngineTimes;

    /// Returns the state that the solver itself keeps from one time window to the next, without contacts in progress
    /// and recent collisions.
    fn state(&self) -> Self::State;

    /// Continues from a stored state of a solver, which [`state`](Self::state) has returned.
    fn resume(&mut self, state: Self::State);
}

/// State of an engine between time windows, in the form in which it is stored.
#[derive(Serialize, Deserialize)]
struct DriverState<C, S> {
    /// Contacts in progress (soft spheres), or times of recent collisions (hard spheres).
    lasting: Vec<C>,
    /// True if the first time window of the run has begun.
    begun: bool,
    /// Counts of the work done in islands (groups of particles that may meet).
    islands: IslandCounters,
    /// Wall-clock time spent on islands (groups of particles that may meet).
    spent: EngineTimes,
    /// State that the solver itself keeps, without contacts in progress and recent collisions.
    solver: S,
}

/// An engine of soft, event-driven hard or hybrid spheres: a solver together with the handling of time windows that
/// these engines have in common.
pub struct Driver<S: Solver> {
    pub(super) solver: S,
    pub(super) islands: Islands<Lasting<S>>,
    pub(super) lasting: Vec<Lasting<S>>,
    begun: bool,
    /// True if islands (groups of particles that may meet) moved all particles in the last time window. False if the
    /// classical algorithm (all particles at once) did so at its end, and before the first window of this process.
    is_by_islands: bool,
    log: Log,
}

impl<S: DistributedSolver> Driver<S> {
    /// Makes an engine with the solver `solver`, before its first time window.
    pub(super) fn with(solver: S) -> Self {
        Self {
            solver,
            islands: Islands::default(),
            lasting: Vec::new(),
            begun: false,
            is_by_islands: false,
            log: Log::default(),
        }
    }

    /// Makes the carried state (such as contacts) in the first time window. If several processes share the run, only
    /// the lead process (number 0) does so.
    fn begin(&mut self, work: &mut Work<Lasting<S>>, window: Window) {
        if !std::mem::replace(&mut self.begun, true) && self.islands.processes.is_lead() {
            self.solver.begin(work, window);
        }
    }

    /// Data for the choice between islands (groups of particles that may meet) and the classical algorithm (all
    /// particles at once); `None` if islands are not tried. If they are tried, the solver moves its carried state (such
    /// as contacts) to `work`.
    fn choice(&mut self, work: &mut Work<Lasting<S>>, window: Window) -> Option<IslandCost> {
        let population = self.islands.population(work);
        let speeds = self.islands.speeds(work, &population);
        let fallback_cost = self.solver.fallback_cost(&population, &speeds, work.scene, window);
        let (fallback_cost, speeds) = self.of_lead(fallback_cost, speeds);
        let choice = IslandCost { population, speeds, fallback_cost: fallback_cost? };
        self.solver.hand_over(work.lasting);
        Some(choice)
    }

    /// Passes the result of trying islands (groups of particles that may meet) to the solver, which decides when
    /// islands are tried again. Also adds up the counts of all processes, and marks stored data of the solver as
    /// outdated if islands were searched. `done` is the simulated time [s] through which islands have moved the
    /// particles, or a failure.
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

    /// Calls `visit` with each item of carried state (such as contacts), stored in the driver or in the solver.
    pub(super) fn for_each_lasting(&self, visit: &mut dyn FnMut(Lasting<S>)) {
        self.lasting.iter().copied().for_each(&mut *visit);
        self.solver.for_each_kept(visit);
    }

    /// Exact sum [J] of `energy` over all items of carried state (such as contacts), in all processes that share the
    /// run.
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
            self.is_by_islands = done >= window.duration;
            let rest = Window { start: window.start + done, duration: window.duration - done };
            let scene = scene.at(rest.start);
            let mut work = work.in_scene(&scene);
            if scene.domain.shear.is_some() {
                work.wrap();
            }
            if self.is_by_islands { Ok(()) } else { self.by_all(&mut work, rest) }
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
        self.is_by_islands.then(|| self.islands.members())
    }

    fn use_clock(&mut self, clock: Clock) {
        self.islands.clock = clock.clone();
        self.solver.use_clock(clock);
    }

    fn stored(&self) -> Result<Stored, StoreError> {
        let mut lasting = Vec::new();
        // if processes share the run, each process stores its carried state together with its particles
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

    fn repopulate(&mut self, index_of: &[Option<u32>]) -> f64 {
        self.solver.hand_over(&mut self.lasting);
        self.solver.repopulate();
        self.islands.repopulate();
        let (islands, mut cut) = (self.solver.islands(), ExactSum::default());
        let follow = |carried: Lasting<S>| {
            let new_index = |index: u32| index_of.get(index as usize).copied().flatten();
            let indices = S::Islands::indices(&carried).into_iter().flatten();
            if indices.map(new_index).all(|index| index.is_some()) {
                return Some(S::Islands::moved(&carried, &|index| new_index(index).unwrap_or(index)));
            }
            cut.add(islands.energy(&carried));
            None
        };
        self.lasting = std::mem::take(&mut self.lasting).into_iter().filter_map(follow).collect();
        cut.value()
    }
}
