//! Driver of the windows of all engines: islands as long as they pay, then all particles at once by the classical
//! algorithm.
//!
//! An engine is a [`Solver`]: it solves single islands, and all particles at once. State carried from one window to the
//! next (contacts in progress, times of recent collisions) belongs to the driver, which passes it to the method in use.

use super::islands::{Domains, GatheredPart, IslandCost, IslandCounters, Islands, Solve, SpeedSummary, packed_part};
use super::population::PopulationSummary;
use super::{Counters, Engine, EngineTimes, Failure, Overlap, Window};
use crate::clock::Clock;
use crate::communicator::Communicator;
use crate::encounter::Couple;
use crate::exact::ExactSum;
use crate::particles::{Particles, Sample};
use crate::record::{Log, Record};
use crate::scene::Scene;
use crate::stored::{StoreError, Stored};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Data that an engine works on in a window.
pub struct Work<'a, C> {
    /// The particles.
    pub particles: &'a mut Particles,
    /// The scene.
    pub scene: &'a Scene,
    /// State carried from one window to the next, by index in the store.
    pub lasting: &'a mut Vec<C>,
    /// State carried between a particle of this process and one of another process.
    pub abroad: &'a mut Vec<CrossRankContact<C>>,
    /// Log of the events in the window.
    pub log: &'a mut Log,
    /// Record that receives the log in the end; a solver that fills the log within a window may pass it on earlier.
    pub record: &'a mut Record,
}

/// State carried between a particle of this process and one of another process.
#[derive(Clone)]
pub struct CrossRankContact<C> {
    /// The carried state, in which ids stand for the particles.
    pub carried: C,
    /// Index of the particle of this process.
    pub own: u32,
    /// Overlap of the two particles at the end of the last part of a window; `None` if they are not in contact.
    pub overlap: Option<Overlap>,
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

    /// Largest cost of one island [ns/s], if it changes from window to window; the value of the lead process holds in
    /// all processes.
    fn allowance(&mut self) -> Option<&mut f64> {
        None
    }

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

    /// True if several processes can share the classical algorithm.
    fn shares_steps(&self) -> bool {
        false
    }

    /// Moves all particles through the window by the classical algorithm, shared by all processes of the run.
    ///
    /// # Errors
    /// Errors of the classical algorithm, equal in all processes.
    fn everyone_together(
        &mut self,
        work: &mut Work<Lasting<Self>>,
        window: Window,
        _domains: &mut Domains,
    ) -> Result<(), Failure> {
        self.everyone(work, window)
    }

    /// True if processes have taken the last steps together, and continue with them.
    fn steps_together(&self) -> bool {
        false
    }

    /// Gives the lead process, which has been shown all particles, the state that the processes continue with.
    fn show(&mut self, _work: &mut Work<Lasting<Self>>, _domains: &Domains) {}

    /// Ends the showing of all particles: each process continues with its own.
    fn hide(&mut self) {}

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
    islands: Islands,
    lasting: Vec<Lasting<S>>,
    abroad: Vec<CrossRankContact<Lasting<S>>>,
    /// Own particles of the lead process, while it is shown those of all.
    kept: Option<GatheredPart<Lasting<S>>>,
    begun: bool,
    /// True if the last window ended with all particles moved at once.
    everyone_last: bool,
    log: Log,
}

impl<S: Solver> Driver<S> {
    /// An engine before its first window.
    pub(super) fn with(solver: S) -> Self {
        Self {
            solver,
            islands: Islands::default(),
            lasting: Vec::new(),
            abroad: Vec::new(),
            kept: None,
            begun: false,
            everyone_last: false,
            log: Log::default(),
        }
    }

    /// Moves particles by islands as long as these are cheaper. Returns the time covered [s].
    fn by_islands(&mut self, work: &mut Work<Lasting<S>>, window: Window) -> Result<f64, Failure> {
        let population = self.islands.population(work);
        let speeds = self.islands.speeds(work, &population);
        let fallback_cost = self.solver.fallback_cost(&population, &speeds, work.scene, window);
        let allowed = self.solver.allowance().copied();
        let (Some(fallback_cost), allowed, speeds) = self.islands.of_lead((fallback_cost, allowed, speeds)) else {
            return Ok(0.0);
        };
        if let (Some(own), Some(allowed)) = (self.solver.allowance(), allowed) {
            *own = allowed;
        }
        self.solver.hand_over(work.lasting);
        let before = self.islands.counters();
        let choice = IslandCost { population: &population, speeds, fallback_cost };
        let done = self.islands.advance(self.solver.islands(), work, window, choice);
        let after = self.islands.counters();
        if let Ok(done) = done {
            self.solver.judge(&population, work.scene, &Trial { done, before, after });
        }
        if after.neighbour_builds != before.neighbour_builds {
            self.solver.disturb();
        }
        done
    }

    /// Calls `visit` with all carried state, of the driver and of the solver.
    fn for_each_lasting(&self, visit: &mut dyn FnMut(Lasting<S>)) {
        self.lasting.iter().copied().for_each(&mut *visit);
        self.solver.for_each_kept(visit);
    }

    fn window(&mut self, work: &mut Work<Lasting<S>>, window: Window) -> Result<(), Failure> {
        if !self.begun {
            if self.islands.is_lead() {
                self.solver.begin(work, window);
            }
            self.begun = true;
        }
        let done = self.by_islands(work, window)?;
        self.everyone_last = done < window.duration;
        if done >= window.duration {
            return Ok(());
        }
        let rest = Window { start: window.start + done, duration: window.duration - done };
        if let Some(domains) =
            self.islands.domains().filter(|domains| domains.is_worth_it() && self.solver.shares_steps())
        {
            self.solver.hand_over(work.lasting);
            return self.solver.everyone_together(work, rest, domains);
        }
        if self.islands.is_cut() {
            self.solver.hand_over(work.lasting);
            self.islands.assemble(self.solver.islands(), work);
        }
        if !self.islands.is_lead() {
            return Ok(());
        }
        self.solver.everyone(work, rest)
    }
}

impl<S: Solver> Engine for Driver<S> {
    fn advance(
        &mut self,
        particles: &mut Particles,
        scene: &Scene,
        window: Window,
        record: &mut Record,
    ) -> Result<(), Failure> {
        let (mut log, mut lasting) = (std::mem::take(&mut self.log), std::mem::take(&mut self.lasting));
        let mut abroad = std::mem::take(&mut self.abroad);
        let mut work = Work { particles, scene, lasting: &mut lasting, abroad: &mut abroad, log: &mut log, record };
        let result = self.window(&mut work, window);
        (self.lasting, self.abroad) = (lasting, abroad);
        record.absorb(&mut log);
        self.log = log;
        result
    }

    fn share(&mut self, communicator: Arc<dyn Communicator>, sample: &Sample, scene: &Scene) {
        self.islands.share(communicator, sample, scene);
    }

    fn is_cut(&self) -> bool {
        self.islands.is_cut() && self.kept.is_none()
    }

    fn balance(&mut self, particles: &Particles, scene: &Scene) {
        if self.is_cut() {
            self.islands.balance(particles, scene);
        }
    }

    fn show(&mut self, particles: &mut Particles, scene: &Scene, every: u32) {
        if self.is_cut() {
            let (mut lasting, mut abroad) = (std::mem::take(&mut self.lasting), std::mem::take(&mut self.abroad));
            let (log, record) = (&mut Log::default(), &mut Record::default());
            let mut work = Work { particles, scene, lasting: &mut lasting, abroad: &mut abroad, log, record };
            let together = self.solver.steps_together();
            self.kept = self.islands.show(self.solver.islands(), &mut work, every);
            if let Some(domains) = self.islands.domains().filter(|_| together && every <= 1) {
                self.solver.show(&mut work, domains);
            }
            (self.lasting, self.abroad) = (lasting, abroad);
        }
    }

    fn gives_parts(&self) -> bool {
        // the list of shared steps is stored as a whole
        self.is_cut() && !self.solver.steps_together()
    }

    fn packed(&self, particles: &Particles) -> Vec<u8> {
        packed_part::<S::Islands>(particles, &self.lasting, &self.abroad)
    }

    fn take_parts(
        &mut self,
        particles: &mut Particles,
        scene: &Scene,
        count: usize,
        next: &mut dyn FnMut(usize) -> Vec<u8>,
    ) {
        let (mut lasting, mut abroad) = (std::mem::take(&mut self.lasting), std::mem::take(&mut self.abroad));
        let (log, record) = (&mut Log::default(), &mut Record::default());
        let mut work = Work { particles, scene, lasting: &mut lasting, abroad: &mut abroad, log, record };
        self.islands.take_parts(self.solver.islands(), &mut work, count, next);
        (self.lasting, self.abroad) = (lasting, abroad);
    }

    fn hide(&mut self, particles: &mut Particles) {
        if let Some(part) = self.kept.take() {
            self.solver.hide();
            self.islands.put_back(part, particles, (&mut self.lasting, &mut self.abroad));
        }
    }

    fn forget(&mut self) {
        self.solver.forget();
    }

    fn counters(&self) -> Counters {
        self.solver.counters(&self.islands.counters())
    }

    fn elastic_energy(&self) -> f64 {
        let known = if self.is_cut() { None } else { self.solver.elastic_energy() };
        known.unwrap_or_else(|| {
            let mut sum = ExactSum::default();
            let energy = |carried: &Lasting<S>| self.solver.islands().energy(carried);
            self.for_each_lasting(&mut |carried| sum.add(energy(&carried)));
            if self.is_cut() {
                // two processes have it
                self.abroad.iter().for_each(|abroad| sum.add(0.5 * energy(&abroad.carried)));
                self.islands.total(&mut [&mut sum]);
            }
            sum.value()
        })
    }

    fn for_each_touching(&self, visit: &mut dyn FnMut(Couple)) {
        self.for_each_lasting(&mut |carried| {
            self.solver.islands().touching(&carried).into_iter().for_each(&mut *visit)
        });
    }

    fn touching_abroad(&self) -> Vec<(u32, Overlap)> {
        let abroad: &[_] = if self.is_cut() { &self.abroad } else { &[] };
        let contacts = abroad.iter().filter_map(|abroad| Some((abroad.own, abroad.overlap?)));
        contacts.filter(|(_, overlap)| overlap.depth > 0.0).collect()
    }

    fn in_islands(&self) -> Option<&[u32]> {
        (!self.everyone_last).then(|| self.islands.members())
    }

    fn use_clock(&mut self, clock: Clock) {
        self.islands.clock = clock.clone();
        self.solver.use_clock(clock);
    }

    fn spent(&self) -> EngineTimes {
        self.solver.spent(self.islands.spent)
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
