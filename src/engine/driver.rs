//! One driver of windows for both engines: islands for as long as they pay, then everyone at once by the classical algorithm.
//!
//! An engine is a [`Solver`]: it solves an island, and everyone as one more island. What lasts from one window to
//! the next (contacts in progress, instants of recent collisions) belongs to the driver, which hands it to whichever way is taken.

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

/// What an engine works on in a window.
pub struct Work<'a, C> {
    /// The particles.
    pub particles: &'a mut Particles,
    /// The scene.
    pub scene: &'a Scene,
    /// What lasts from one window to the next, by place in the store.
    pub lasting: &'a mut Vec<C>,
    /// What lasts between a particle of this process and one of another.
    pub abroad: &'a mut Vec<CrossRankContact<C>>,
    /// The record of what happens in the window.
    pub log: &'a mut Log,
    /// Where that goes in the end; a solver that fills its log within a window may hand it over.
    pub record: &'a mut Record,
}

/// What lasts between a particle of this process and one of another.
#[derive(Clone)]
pub struct CrossRankContact<C> {
    /// It, its places being ids.
    pub carried: C,
    /// Place of the particle that is here.
    pub own: u32,
    /// How far the two overlapped at the end of the last part of a window; `None` if it is no contact.
    pub overlap: Option<Overlap>,
}

/// What lasts between windows, in the terms of a solver.
pub type Lasting<S> = <<S as Solver>::Islands as Solve>::Carried;

/// What islands did in a window.
#[derive(Clone, Copy)]
pub struct Trial {
    /// [s] for how long they were the cheaper way.
    pub done: f64,
    /// Their counts before.
    pub before: IslandCounters,
    /// Their counts after.
    pub after: IslandCounters,
}

/// How an engine solves islands and everyone.
pub trait Solver {
    /// The part that solves one island; several threads share it.
    type Islands: Solve;

    /// What it keeps from one window to the next besides what the driver keeps for it.
    type State: Serialize + DeserializeOwned;

    /// The part that solves islands.
    fn islands(&self) -> &Self::Islands;

    /// What is under way at the start of a run, such as contacts in progress.
    fn begin(&mut self, _work: &mut Work<Lasting<Self>>, _window: Window) {}

    /// [ns/s] what islands must cost less than, per particle and simulated time, to be taken in this window; `None`: they are
    /// not tried. Infinite: they are taken wherever they can be.
    fn fallback_cost(
        &mut self,
        population: &PopulationSummary,
        speeds: &SpeedSummary,
        scene: &Scene,
        window: Window,
    ) -> Option<f64>;

    /// [ns/s] what one island may cost, where that changes from window to window: of the lead, it holds in all processes.
    fn allowance(&mut self) -> Option<&mut f64> {
        None
    }

    /// Learns from what islands did.
    fn judge(&mut self, _population: &PopulationSummary, _scene: &Scene, _trial: &Trial) {}

    /// Hands over what lasts, if the classical algorithm has kept it to itself at the end of a window: where nobody else asks for it, it stays where it is,
    /// for all of it once more would be as much memory again.
    fn hand_over(&mut self, lasting: &mut Vec<Lasting<Self>>);

    /// Shows what [`hand_over`](Self::hand_over) would hand over.
    fn for_each_kept(&self, visit: &mut dyn FnMut(Lasting<Self>));

    /// Islands have moved the particles, or have tried to: what is kept of the store is out of date.
    fn disturb(&mut self);

    /// Everyone through the window by the classical algorithm.
    ///
    /// # Errors
    /// What makes the engine fail; the store then holds the state at which it was seen.
    fn everyone(&mut self, work: &mut Work<Lasting<Self>>, window: Window) -> Result<(), Failure>;

    /// Whether several processes can share the classical algorithm.
    fn shares_steps(&self) -> bool {
        false
    }

    /// The same by all processes that share the run.
    ///
    /// # Errors
    /// As for [`everyone`](Self::everyone), the same in all processes.
    fn everyone_together(
        &mut self,
        work: &mut Work<Lasting<Self>>,
        window: Window,
        _domains: &mut Domains,
    ) -> Result<(), Failure> {
        self.everyone(work, window)
    }

    /// Whether processes have taken the last steps together, and go on with them.
    fn steps_together(&self) -> bool {
        false
    }

    /// The lead has been shown all particles: it is told what they go on with.
    fn show(&mut self, _work: &mut Work<Lasting<Self>>, _domains: &Domains) {}

    /// Each process goes on with its own part.
    fn hide(&mut self) {}

    /// Counts of what the classical algorithm did and, added to them, what islands did.
    fn counters(&self, islands: &IslandCounters) -> Counters;

    /// The run is over: gives back memory that nothing but a further window would need.
    fn forget(&mut self) {}

    /// [J] energy stored in contacts, if everyone was moved last; `None` if islands were, and then it is that of what lasts.
    fn elastic_energy(&self) -> Option<f64>;

    /// Times the classical algorithm with this clock from now on.
    fn use_clock(&mut self, clock: Clock);

    /// `spent` with what the classical algorithm took.
    fn spent(&self, spent: EngineTimes) -> EngineTimes;

    /// What it keeps from one window to the next.
    fn state(&self) -> Self::State;

    /// Goes on from what it kept.
    fn resume(&mut self, state: Self::State);
}

/// What lasts from one window to the next in all of an engine.
#[derive(Serialize, Deserialize)]
struct DriverState<C, S> {
    /// Contacts in progress, or instants of recent collisions.
    lasting: Vec<C>,
    /// Whether there has been a window.
    begun: bool,
    /// What islands have done.
    islands: IslandCounters,
    /// Time spent on them.
    spent: EngineTimes,
    /// What the solver keeps by itself.
    solver: S,
}

/// An engine made of a solver.
pub struct Driver<S: Solver> {
    pub(super) solver: S,
    islands: Islands,
    lasting: Vec<Lasting<S>>,
    abroad: Vec<CrossRankContact<Lasting<S>>>,
    /// The particles of this process, the lead, while it is shown those of all.
    kept: Option<GatheredPart<Lasting<S>>>,
    begun: bool,
    /// Whether the last window ended with everyone moved at once.
    everyone_last: bool,
    log: Log,
}

impl<S: Solver> Driver<S> {
    /// An engine that has done nothing yet.
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

    /// Islands for as long as they are the cheaper way; returns how long that was [s].
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

    /// Shows what lasts, whoever keeps it.
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
        // the list of steps that are shared is stored whole
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
        // parts are packed with it
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
