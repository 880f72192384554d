//! Islands: computing work only for the particles that touch.
//!
//! In a short window nearly every particle of a dilute gas is alone and flies straight. Particles that touch something
//! on their straight flight are *hot*. Hot particles that meet, or might meet after a collision, form an *island*, and
//! an engine solves each island on its own. Cold particles that a hot one might hit are *bystanders*. If a bystander is
//! hit, the island is solved again with the bystander as a member. The island is also solved again if a hot particle
//! gets faster than its speed limit. So no contact is missed, whatever happens within the window.
//!
//! Some engines, such as that for hard spheres, report every velocity change of a flight. Their islands are found the
//! other way round (`cluster/course.rs`): each island is first solved as if it were alone. Islands whose trajectories
//! then meet are united and solved again. There are no bystanders, and an island reaches only as far as its particles
//! do fly, not as far as they might.
//!
//! Islands share no data. They are solved in parallel and in any order, with the same results to the last bit.

mod batch;
mod choice;
mod cluster;
mod counters;
mod domains;
mod island;
mod order;
mod rounds;
mod search;

pub use batch::GivenUp;
pub use choice::{IslandCost, SpeedSummary};
pub use counters::IslandCounters;
pub use domains::{Domains, GatheredPart, packed_part};
pub use island::{Bounds, Island};

use super::driver::{CrossRankContact, Work};
use super::motion::accelerate;
use super::population::PopulationSummary;
use super::{EngineTimes, Failure, Window};
use crate::clock::Clock;
use crate::communicator::Communicator;
use crate::encounter::Couple;
use crate::exact::{self, ExactSum};
use crate::neighbours::along_walls;
use crate::neighbours::region::Region;
use crate::particles::{Particles, Sample};
use crate::scene::Scene;
use batch::{IslandResults, Task};
use choice::{PartLimits, WindowPiece, cheapest_part};
use cluster::{Clusters, Space};
use domains::{LocalParticles, LocalStatus, PartDecision, settle, take_aboard};
use nalgebra::Vector3;
use order::{in_order, sort};
use rounds::solve_all;
use search::{FirstTouch, Search, SearchInterval};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::sync::Arc;

/// Solver of an island, as an engine provides it.
pub trait Solve: Sync {
    /// State carried from one window to the next, such as a contact in progress; particles are named by index in the
    /// store.
    type Carried: Copy + Send + Sync + Serialize + DeserializeOwned;
    /// Working memory, one per thread.
    type Scratch: Default + Send;

    /// Indices of the particles that carried state belongs to.
    fn places(carried: &Self::Carried) -> [Option<u32>; 2];

    /// Returns the carried state with the new indices of its particles, for instance after a sort of the store.
    fn moved(carried: &Self::Carried, place_of: &dyn Fn(u32) -> u32) -> Self::Carried;

    /// Energy [J] that carried state may give back to its particles.
    fn energy(&self, carried: &Self::Carried) -> f64;

    /// The two bodies in contact, if the carried state is a contact.
    fn touching(&self, carried: &Self::Carried) -> Option<Couple>;

    /// True if the engine takes crowds. A crowd is an island without a neighbour list. It has more than
    /// [`LARGEST_ISLAND`] particles, or it holds all contacts in progress if these are many.
    fn takes_crowds(&self) -> bool {
        false
    }

    /// True if particles fly straight between collisions and every velocity change is reported to [`Island::turn`]. All
    /// trajectories are then known exactly once islands are solved, and there are no bystanders.
    fn traces(&self) -> bool {
        false
    }

    /// Moves the particles of the island, in the frame at rest, through [0, end) [s]. It stops early if a particle gets
    /// out of bounds ([`Island::allows`]), and returns the local index of that particle. If there are several, the
    /// others are in [`Island::also`].
    ///
    /// # Errors
    /// The engine fails, or the island costs more than it is worth.
    fn solve(
        &self,
        island: &mut Island<Self::Carried>,
        scratch: &mut Self::Scratch,
        scene: &Scene,
        window: Window,
        end: f64,
    ) -> Result<Option<usize>, GivenUp>;
}

/// Search windows between two sorts of the store: particles move a small part of a cell in each.
const WINDOWS_PER_SORT: u64 = 32;

/// Largest number of particles of an island that is worth its pairwise bookkeeping.
pub const LARGEST_ISLAND: usize = 200;

/// Number of members beyond which an island is too large for a long part of a window. Each step of an island checks all
/// of its pairs, so the cost grows with the square of the number of members. The part is therefore halved, as long as
/// it may be.
const LARGE_ISLAND: usize = 48;

/// Number of times that a part with too large islands is halved before islands are given up for this window.
const SHORTER: i32 = 3;

/// Islands per parallel task: a fixed number, so that results do not depend on the number of threads.
const BATCH: usize = 64;

/// Moves particles window by window, with a solver for the islands.
#[derive(Default)]
pub struct Islands {
    /// Clock that times the search and the flight.
    pub clock: Clock,
    /// Time spent.
    pub spent: EngineTimes,
    counters: IslandCounters,
    /// Indices of the particles in islands of the last part.
    members: Vec<u32>,
    search: Search,
    frame: Vector3<f64>,
    /// Domain decomposition of the run, if several processes share it.
    domains: Option<Domains>,
}

impl Islands {
    /// Counts of the work done so far.
    pub fn counters(&self) -> IslandCounters {
        self.counters
    }

    /// Continues from the given counts. The time of the next sort of the store depends on them; islands keep no other
    /// state.
    pub fn resume(&mut self, counters: IslandCounters, spent: EngineTimes) {
        (self.counters, self.spent) = (counters, spent);
    }

    /// Indices of the particles that were in islands in the last part.
    pub fn members(&self) -> &[u32] {
        &self.members
    }

    /// Shares the run with other processes. If the sample is not yet divided, it is cut into domains when islands are
    /// next tried.
    pub fn share(&mut self, communicator: Arc<dyn Communicator>, sample: &Sample, scene: &Scene) {
        let mut domains = Domains::new(communicator, PopulationSummary::of(sample, scene));
        if sample.is_part() {
            domains.begin_cut(&scene.domain);
        }
        self.domains = Some(domains);
    }

    /// Replaces all particles and all carried state by `count` parts that processes have packed; `next` gives the lead
    /// process one part after the other. Each process keeps the particles in its block, among blocks of equal size. A
    /// single process keeps all.
    pub fn take_parts<S: Solve>(
        &mut self,
        solver: &S,
        work: &mut Work<S::Carried>,
        count: usize,
        next: &mut dyn FnMut(usize) -> Vec<u8>,
    ) {
        *work.particles = Particles::default();
        work.lasting.clear();
        work.abroad.clear();
        let domain = &work.scene.domain;
        if let Some(domains) = &mut self.domains {
            domains.begin_cut(domain);
        }
        let mut lasting = Vec::new();
        for number in 0..count {
            let part = if self.is_lead() { next(number) } else { Vec::new() };
            let own = self.domains.as_ref().map_or_else(|| part.clone(), |domains| domains.deal::<S>(&part, domain));
            lasting.extend(take_aboard::<S::Carried>(&own, work.particles).into_iter().flatten());
        }
        settle::<S>(lasting, work);
        in_order(solver, work);
    }

    /// True if the store holds the particles of one domain only.
    pub fn is_cut(&self) -> bool {
        self.domains.as_ref().is_some_and(|domains| domains.is_cut)
    }

    /// Cuts the run into new domains if one process has many more particles than others.
    pub fn balance(&mut self, particles: &Particles, scene: &Scene) {
        if let Some(domains) = &mut self.domains {
            domains.balance(particles, &scene.domain);
        }
    }

    /// Gives all particles to the lead process.
    pub fn assemble<S: Solve>(&mut self, solver: &S, work: &mut Work<S::Carried>) {
        if let Some(domains) = self.domains.as_mut().filter(|domains| domains.is_cut) {
            domains.assemble(solver, work, &mut self.members);
        }
    }

    /// Gives the lead process copies of the particles with an id divisible by `every`, and of those with carried state
    /// that involves such a particle. Returns the lead's own part, to be [`put_back`](Self::put_back) if all processes
    /// continue with their own.
    pub fn show<S: Solve>(
        &mut self,
        solver: &S,
        work: &mut Work<S::Carried>,
        every: u32,
    ) -> Option<GatheredPart<S::Carried>> {
        self.domains.as_mut()?.show(solver, work, &mut self.members, every)
    }

    /// Domain decomposition of the run, if several processes share it.
    pub fn domains(&mut self) -> Option<&mut Domains> {
        self.domains.as_mut()
    }

    /// Restores the own part of the lead process.
    pub fn put_back<C>(
        &mut self,
        part: GatheredPart<C>,
        particles: &mut Particles,
        (lasting, abroad): (&mut Vec<C>, &mut Vec<CrossRankContact<C>>),
    ) {
        (*particles, *lasting, *abroad, self.members) = (part.particles, part.lasting, part.abroad, part.members);
    }

    /// Sums over all processes, if each has particles of its own.
    pub fn total(&self, sums: &mut [&mut ExactSum]) {
        self.domains.iter().for_each(|domains| domains.total(sums));
    }

    /// Summary of all particles of the run in a few numbers.
    pub fn population<C>(&self, work: &Work<C>) -> Arc<PopulationSummary> {
        // sizes do not change while other processes have some of the particles
        let known = self.domains.as_ref().map(|domains| domains.population.clone());
        known.unwrap_or_else(|| Arc::new(PopulationSummary::of(&Sample::from(&*work.particles), work.scene)))
    }

    /// Value of the lead process, sent to all processes that share the run.
    pub fn of_lead<T: Serialize + DeserializeOwned>(&self, value: T) -> T {
        match &self.domains {
            Some(domains) => domains.of_lead(value),
            None => value,
        }
    }

    /// True if this process is the lead, or the only one.
    pub fn is_lead(&self) -> bool {
        self.domains.as_ref().is_none_or(Domains::is_lead)
    }

    /// Summary of the velocities of all particles in a few numbers.
    pub fn speeds<C>(&self, work: &Work<C>, population: &PopulationSummary) -> SpeedSummary {
        let mut sums = work.particles.velocity_sums();
        self.total(&mut sums.each_mut());
        let mean = Vector3::from(exact::values(&sums)) / population.count.max(1) as f64;
        self.speeds_seen_from(along_walls(work.scene, mean), work, population)
    }

    /// Summary of the velocities of all particles, relative to a frame [m/s].
    fn speeds_seen_from<C>(&self, frame: Vector3<f64>, work: &Work<C>, population: &PopulationSummary) -> SpeedSummary {
        let (mut squares, largest) = work.particles.square_speeds_and_largest(frame);
        let mut largest = [largest];
        self.total(&mut [&mut squares]);
        self.domains.iter().for_each(|domains| domains.largest(&mut largest));
        let mean = (squares.value() / population.count.max(1) as f64).sqrt();
        SpeedSummary { frame, mean, largest: largest[0] }
    }

    /// Moves all particles for as long as islands are cheaper than the classical algorithm. Returns the time covered
    /// [s]; in a dilute scene this is the whole window.
    ///
    /// # Errors
    /// A velocity is not a number. An island whose engine fails only ends the advance: the classical algorithm then
    /// meets the failure again, and stops at its instant.
    pub fn advance<S: Solve>(
        &mut self,
        solver: &S,
        work: &mut Work<S::Carried>,
        window: Window,
        choice: IslandCost,
    ) -> Result<f64, Failure> {
        let before = self.counters;
        let done = self.parts(solver, work, window, choice);
        self.share_counts(&before);
        done
    }

    /// Sums the counts of all processes since `before`.
    fn share_counts(&mut self, before: &IslandCounters) {
        if let Some(domains) = self.domains.as_ref().filter(|domains| domains.is_cut) {
            self.counters.add_up(before, domains);
        }
    }

    fn parts<S: Solve>(
        &mut self,
        solver: &S,
        work: &mut Work<S::Carried>,
        window: Window,
        choice: IslandCost,
    ) -> Result<f64, Failure> {
        let IslandCost { population, speeds, fallback_cost } = choice;
        let (mut done, mut speeds, gravity) = (0.0, speeds, work.scene.gravity);
        self.frame = speeds.frame;
        let mut longest = f64::INFINITY;
        while done < window.duration {
            let left = window.duration - done;
            if done > 0.0 {
                speeds = self.speeds_seen_from(self.frame, work, population);
            }
            if !speeds.largest.is_finite() {
                accelerate(work.particles, gravity * done);
                self.assemble(solver, work);
                return Err(super::not_a_number(work.particles, window.start + done));
            }
            // contacts are carried into a crowd and out of it again; only an engine that takes crowds has many of them
            let held = if solver.takes_crowds() { self.held(work) } else { 0 };
            let limits = PartLimits { left, fallback_cost, held, traces: solver.traces() };
            let Some(cheapest) = cheapest_part(population, &work.scene.domain, &speeds, &limits) else { break };
            if let Some(domains) = self.domains.as_mut().filter(|domains| !domains.is_cut) {
                domains.cut(solver, work);
            }
            // no shorter part is tried: islands of contacts in progress do not become smaller
            let shortest = cheapest.part * 0.5f64.powi(SHORTER);
            let mut part = longest.clamp(shortest, cheapest.part);
            let stretch = Window { start: window.start + done, duration: left };
            let foreseen = (cheapest.pairs * population.count as f64) as u64;
            let moved = loop {
                let most = if part > shortest { LARGE_ISLAND } else { LARGEST_ISLAND };
                let piece = WindowPiece { elapsed: done, part, foreseen, population, speeds, most };
                let moved = self.part(solver, work, stretch, &piece);
                if moved || part <= shortest {
                    break moved;
                }
                part = (0.5 * part).max(shortest);
            };
            // a part that was too long now will be so again; if trajectories are reported, no island is too large, so
            // the engine has failed
            longest = if solver.traces() { longest } else { part };
            if !moved {
                break;
            }
            done = if part < left { done + part } else { window.duration };
            self.clock.tell(window.start + done);
        }
        accelerate(work.particles, gravity * done);
        Ok(done)
    }

    /// Number of contacts in progress, of all processes.
    fn held<C>(&self, work: &Work<C>) -> usize {
        let Some(domains) = self.domains.as_ref().filter(|domains| domains.is_cut) else { return work.lasting.len() };
        // a contact with a particle of another process is known to both processes
        let mut twice = [(2 * work.lasting.len() + work.abroad.len()) as i64];
        domains.count(&mut twice);
        (twice[0] / 2) as usize
    }

    /// Moves all particles through a part of a window. Returns false, with nothing moved, if islands grow too large or
    /// the engine fails.
    fn part<S: Solve>(&mut self, solver: &S, work: &mut Work<S::Carried>, window: Window, piece: &WindowPiece) -> bool {
        let began = self.clock.now();
        if self.counters.neighbour_builds.is_multiple_of(WINDOWS_PER_SORT) {
            sort::<S>(work, self.domains.as_ref());
        }
        work.particles.wrap(&work.scene.domain);
        self.counters.neighbour_builds += 1;
        self.counters.foreseen += piece.foreseen;
        self.spent.neighbours += self.clock.now() - began;
        let Some(mut domains) = self.domains.take() else {
            return matches!(self.attempt(solver, work, window, piece, None), PartDecision::Done);
        };
        let moved = loop {
            let began = self.clock.now();
            let view = domains.trade::<S>(work, (self.frame, piece.part), piece.flight());
            self.spent.neighbours += self.clock.now() - began;
            match self.attempt(solver, work, window, piece, Some((&mut domains, &view))) {
                PartDecision::Done => {
                    domains.keep(solver, work, view, &mut self.members);
                    break true;
                }
                PartDecision::Again => domains.give_back(work, view),
                PartDecision::Failed => {
                    domains.give_back(work, view);
                    break false;
                }
            }
        };
        self.domains = Some(domains);
        moved
    }

    /// Tries to move the particles that this process sees through a part of a window; a single process sees all.
    fn attempt<S: Solve>(
        &mut self,
        solver: &S,
        work: &mut Work<S::Carried>,
        window: Window,
        piece: &WindowPiece,
        share: Option<(&mut Domains, &LocalParticles<S::Carried>)>,
    ) -> PartDecision {
        let scene = work.scene;
        let WindowPiece { elapsed, part, population, most, .. } = *piece;
        let region = share.as_ref().map_or_else(|| Region::from(&scene.domain), |(_, view)| view.region.clone());
        let touches = self.find(work, region, piece);
        in_order(solver, work);
        let carried: Vec<[Option<u32>; 2]> = work.lasting.iter().map(S::places).collect();
        let energy: Vec<f64> = work.lasting.iter().map(|carried| solver.energy(carried)).collect();
        let lightest = population.lightest;
        let (crowds, traces) = (solver.takes_crowds(), solver.traces());
        let space = Space { scene, frame: self.frame, part, crowds, traces, lightest, most };
        let mut clusters = Clusters::new(&mut self.search, work.particles, space);
        let fallen = scene.gravity * elapsed;
        let task = Task { solver, scene, window, fallen, part, carried: work.lasting.as_slice() };
        let mine = |place: u32| share.as_ref().is_none_or(|(_, view)| view.is_mine(place));
        let gathered = clusters.gather(&touches, &carried, energy);
        let solved = if gathered { solve_all(&mut clusters, &task, mine) } else { None };
        let room = clusters.least_room(mine);
        let verdict = judge(&clusters, solved.is_none(), room, share);
        let (PartDecision::Done, Some((batches, counts))) = (&verdict, solved) else {
            clusters.release();
            return verdict;
        };
        self.counters.add(&counts);
        let landing = clusters.land();
        let gravity = scene.gravity;
        let (fall, fallen) = (gravity * (part * (elapsed + 0.5 * part)), gravity * (elapsed + part));
        let began = self.clock.now();
        let results = IslandResults { landing: &landing, batches: &batches, fallen };
        results.put(work.particles, &mut self.search.label, |x, v| *x += v * part + fall);
        self.spent.flight += self.clock.now() - began;
        work.lasting.clear();
        self.members.clear();
        for notes in results.notes() {
            self.counters.add(&notes.counts);
            self.members.extend(notes.members);
            work.lasting.extend(notes.lasting);
            work.log.impacts.extend(notes.impacts);
            work.log.islands.extend(notes.ledger);
        }
        verdict
    }

    /// All touches on straight flights in the next part, for particles in `region`.
    fn find<C>(&mut self, work: &Work<C>, region: Region, piece: &WindowPiece) -> Vec<FirstTouch> {
        let began = self.clock.now();
        let span = SearchInterval::new(work.scene, piece.elapsed, piece.part);
        self.search.build(work.particles, work.scene, region, self.frame, &span);
        let hot = self.search.hot(work.particles, work.scene, &span);
        self.counters.searched += hot.checks;
        self.spent.neighbours += self.clock.now() - began;
        hot.touches
    }
}

/// Decision about a part that was tried, by a single process or by the vote of all.
fn judge<C>(
    clusters: &Clusters,
    failed: bool,
    room: f64,
    share: Option<(&mut Domains, &LocalParticles<C>)>,
) -> PartDecision {
    let (reach, half_period) = (clusters.reach(), clusters.half_period());
    let Some((domains, view)) = share else {
        return if failed || !reach.fits(half_period) { PartDecision::Failed } else { PartDecision::Done };
    };
    let agrees = domains.compare(clusters, view, failed) && view.complete;
    domains.vote(&LocalStatus { reach, room, failed, agrees }, half_period, clusters.domain().size.amax())
}
