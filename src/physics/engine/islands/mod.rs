//! Islands: groups of particles that may meet. With islands, only particles that may touch something cost more than a
//! straight flight.
//!
//! A window is the time between two exchanges of momentum with the gas. In a short window nearly every particle of a
//! dilute gas is alone and flies straight. Particles that touch something on their straight flight are *hot*, all
//! other particles are *cold*. Hot particles that meet, or might meet after a collision, form an *island*, which an
//! engine solves separately. Cold particles that a hot one might hit are *bystanders*. If a bystander is hit, the
//! island is solved again with the bystander as a member. The island is also solved again if a hot particle exceeds
//! its speed limit. So no contact is missed. Islands are found and solved in a *part* of a window, which is the whole
//! window or a piece of it. *Carried* contacts (or recent collisions) are those that continue from one part to the
//! next. The alternative to islands is the *classical algorithm*, which moves all particles at once, by uniform steps
//! or one event queue.
//!
//! Some engines, such as that for hard spheres, report every velocity change of a flight. For these engines each
//! island is first solved as if it were alone (`cluster/traced.rs`). Islands whose trajectories then meet are united
//! and solved again. There are no bystanders, because the trajectories of members are known and need no upper limits.
//!
//! Islands have no data in common. They are solved in parallel and in any order, with results that are equal to the
//! last bit.

mod batch;
mod choice;
mod cluster;
mod counters;
mod island;
mod order;
mod rounds;
mod search;

pub use batch::GivenUp;
pub use choice::{IslandCost, SpeedSummary};
pub use cluster::{BoundedIslands, Clusters, IslandFinder, Member, Reach, TracedIslands, VelocityChange};
pub use counters::IslandCounters;
pub use island::Island;
pub use order::in_order;
pub use search::BoundingSphere;

use super::distributed::{PartDecision, Processes};
use super::driver::Work;
use super::motion::accelerate;
use super::population::PopulationSummary;
use super::{EngineTimes, Failure, Window};
use crate::clock::Clock;
use crate::encounter::Couple;
use crate::exact;
use crate::neighbours::along_walls;
use crate::neighbours::region::Region;
use crate::particles::Sample;
use crate::scene::Scene;
use batch::{Batch, IslandResults, Task};
use choice::{PartLimits, WindowPiece, cheapest_part};
use cluster::{IslandLimits, Landing, Space};
use nalgebra::Vector3;
use order::sort;
use rounds::solve_all;
use search::{FirstTouch, Search, SearchInterval};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::sync::Arc;

/// Solver of one island (a group of particles that may meet). Each engine provides a solver, which several threads use
/// at the same time.
pub trait Solve: Sync {
    /// Method that finds the particles of islands (groups of particles that may meet). With [`TracedIslands`],
    /// particles must fly straight between collisions, and the engine must report every velocity change by calling
    /// [`Island::turn`].
    type Finder<'a>: IslandFinder<'a>;
    /// State of an island (group of particles that may meet) that the next interval of time needs: a contact in
    /// progress, or the last collision of a particle. The state contains indices of particles.
    type Carried: Copy + Send + Sync + Serialize + DeserializeOwned;
    /// Scratch memory of the solver, one for each thread.
    type Scratch: Default + Send;

    /// Indices of the particles of a contact in progress or of a recent collision. The second entry is `None` if there
    /// is no second particle.
    fn indices(carried: &Self::Carried) -> [Option<u32>; 2];

    /// Returns a copy of a contact in progress (or recent collision) with new indices of its particles: index `p`
    /// becomes `index_of(p)`. This is needed when the particle store was sorted, or when particles are copied into an
    /// island (group of particles that may meet).
    fn moved(carried: &Self::Carried, index_of: &dyn Fn(u32) -> u32) -> Self::Carried;

    /// Energy [J] stored in a contact in progress, negative if the bodies attract each other; 0 for a recent collision.
    fn energy(&self, carried: &Self::Carried) -> f64;

    /// Largest energy [J] that a contact in progress may give back to its particles. It differs from
    /// [`energy`](Self::energy), which is the default, if the bodies attract each other.
    fn available_energy(&self, carried: &Self::Carried) -> f64 {
        self.energy(carried)
    }

    /// Energies [J] in the tangential, rolling and twisting spring of a contact in progress. [`energy`](Self::energy)
    /// includes them.
    fn spring_energies(&self, _carried: &Self::Carried) -> [f64; 3] {
        [0.0; 3]
    }

    /// The two bodies of a contact in progress; `None` for a recent collision.
    fn touching(&self, carried: &Self::Carried) -> Option<Couple>;

    /// True if the engine can solve crowds. A crowd is an island (group of particles that may meet) without a list of
    /// pairs, which is moved by uniform steps. It has more than [`LARGEST_ISLAND`] particles, or was too expensive
    /// with such a list, or contains all contacts in progress if these are many.
    fn takes_crowds(&self) -> bool {
        false
    }

    /// Moves the particles of an island (group of particles that may meet) from the start of a part (interval of time)
    /// to its end, `end` [s] later. `window` is the time from the start of the part to the next exchange with the gas.
    /// Returns `None` if the result is valid. The function stops, and returns the local index of a particle, if that
    /// particle exceeds its speed limit or is hit unexpectedly ([`Island::allows`]). If this happens to several
    /// particles, the indices of the other particles are stored in [`Island::also`].
    ///
    /// # Errors
    /// The engine fails, or the island costs more than it would cost to move all particles at once (the classical
    /// algorithm).
    fn solve(
        &self,
        island: &mut Island<Self::Carried>,
        scratch: &mut Self::Scratch,
        scene: &Scene,
        window: Window,
        end: f64,
    ) -> Result<Option<usize>, GivenUp>;
}

/// Number of searches for touching particles after which the particle store is sorted again. The sort can be rare,
/// because particles move by only a small fraction of a cell between two searches.
const WINDOWS_PER_SORT: u64 = 32;

/// Largest number of particles of an island (group of particles that may meet) that is solved with a list of all its
/// pairs. In a larger island, uniform steps of all particles cost less.
pub const LARGEST_ISLAND: usize = 200;

/// Number of members above which an island (group of particles that may meet) is too large, as long as a shorter
/// interval of time can be tried. If an island is too large, the interval is halved, up to [`SHORTER`] times. Large
/// islands are expensive, because each step of an island checks all of its pairs.
const LARGE_ISLAND: usize = 48;

/// Number of times that an interval of time is halved because islands (groups of particles that may meet) are too
/// large. After that, the classical algorithm moves all particles at once.
const SHORTER: i32 = 3;

/// Number of islands (groups of particles that may meet) that a thread solves as one piece of work. The number is
/// fixed, so that results do not depend on the number of threads.
const BATCH: usize = 64;

/// Method that moves particles through a window (time between two exchanges with the gas) by finding islands (groups
/// of particles that may meet) and solving them. The window is divided into parts (intervals of time), and `C` is the
/// type of contacts (or recent collisions) carried from part to part.
pub struct Islands<C> {
    /// Clock that measures the wall-clock time of searches and flights.
    pub clock: Clock,
    /// Wall-clock time that searches and flights have taken so far.
    pub spent: EngineTimes,
    pub(super) counters: IslandCounters,
    /// Indices of the particles that were members of islands (groups of particles that may meet) in the last part
    /// (interval of time) of a window.
    pub(super) members: Vec<u32>,
    search: Search,
    frame: Vector3<f64>,
    /// Connection to the other processes that share the run; a single process by default.
    pub processes: Processes<C>,
}

impl<C> Default for Islands<C> {
    fn default() -> Self {
        Self {
            clock: Clock::default(),
            spent: EngineTimes::default(),
            counters: IslandCounters::default(),
            members: Vec::new(),
            search: Search::default(),
            frame: Vector3::zeros(),
            processes: Processes::default(),
        }
    }
}

impl<C: Copy + Send + Sync + Serialize + DeserializeOwned> Islands<C> {
    /// Counts of the work done in islands (groups of particles that may meet) so far.
    pub fn counters(&self) -> IslandCounters {
        self.counters
    }

    /// Continues a stored run with the given counts and times. The counts determine when the particle store is next
    /// sorted. Islands need no other data from earlier windows.
    pub fn resume(&mut self, counters: IslandCounters, spent: EngineTimes) {
        (self.counters, self.spent) = (counters, spent);
    }

    /// Forgets the particles that were in islands (groups of particles that may meet), because particles have left the
    /// store or come into it.
    pub fn repopulate(&mut self) {
        self.members.clear();
    }

    /// Indices of the particles that were members of islands (groups of particles that may meet) in the last part
    /// (interval of time) of a window.
    pub fn members(&self) -> &[u32] {
        &self.members
    }

    /// Summary of the sizes of all particles of the run, in this process and in others.
    pub fn population(&self, work: &Work<C>) -> Arc<PopulationSummary> {
        // sizes do not change, so a summary that was made earlier is used while other processes store some of the
        // particles
        let known = self.processes.population();
        known.unwrap_or_else(|| Arc::new(PopulationSummary::of(&Sample::from(&*work.particles), work.scene)))
    }

    /// Speeds of all particles of the run, in this process and in others, relative to their mean velocity along the
    /// walls.
    pub fn speeds(&self, work: &Work<C>, population: &PopulationSummary) -> SpeedSummary {
        let mut sums = work.particles.relative_to_flow(&work.scene.domain).velocity_sums();
        self.processes.total(&mut sums.each_mut());
        let mean = Vector3::from(exact::values(&sums)) / population.count.max(1) as f64;
        self.speeds_seen_from(along_walls(work.scene, mean), work, population)
    }

    /// Speeds of all particles of the run, in this process and in others, relative to a frame with the velocity
    /// `frame` [m/s].
    fn speeds_seen_from(&self, frame: Vector3<f64>, work: &Work<C>, population: &PopulationSummary) -> SpeedSummary {
        let relative = work.particles.relative_to_flow(&work.scene.domain);
        let (mut squares, largest) = relative.square_speeds_and_largest(frame);
        let mut largest = [largest];
        self.processes.total(&mut [&mut squares]);
        self.processes.largest(&mut largest);
        let mean = (squares.value() / population.count.max(1) as f64).sqrt();
        SpeedSummary { frame, mean, largest: largest[0] }
    }

    /// Moves all particles through the window for as long as islands (groups of particles that may meet) cost less
    /// than the classical algorithm, which moves all particles at once. Returns the time [s] from the start of the
    /// window that is covered in this way. In a dilute scene it is the whole window.
    ///
    /// If the engine fails in an island, the function returns early without an error. Then the classical algorithm
    /// meets the failure again, and stops at the time of the failure.
    ///
    /// # Errors
    /// A velocity is not a finite number.
    pub fn advance<S: Solve<Carried = C>>(
        &mut self,
        solver: &S,
        work: &mut Work<C>,
        window: Window,
        IslandCost { population, speeds, fallback_cost }: &IslandCost,
    ) -> Result<f64, Failure> {
        let (mut done, mut speeds, gravity) = (0.0, *speeds, work.scene.gravity);
        self.frame = speeds.frame;
        let mut longest = f64::INFINITY;
        while done < window.duration {
            let left = window.duration - done;
            let scene = work.scene.at(window.start + done);
            let work = &mut work.in_scene(&scene);
            if done > 0.0 {
                speeds = self.speeds_seen_from(self.frame, work, population);
            }
            if !speeds.largest.is_finite() {
                accelerate(work.particles, gravity * done);
                self.processes.assemble(solver, work, &mut self.members);
                return Err(super::not_a_number(work.particles, window.start + done));
            }
            // contacts are copied into a crowd and back; other engines have no contacts that last
            let held = if solver.takes_crowds() { self.processes.held(work.lasting.len()) } else { 0 };
            let limits = PartLimits { left, fallback_cost: *fallback_cost, held, costs: S::Finder::COSTS };
            let Some(cheapest) = cheapest_part(population, &work.scene.domain, &speeds, &limits) else { break };
            self.processes.cut(solver, work);
            // even shorter parts are not tried, because islands of contacts in progress would not become smaller
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
            // a length that was too long for this part would be too long for the next part too
            longest = if S::Finder::KEEPS_SHORTER { part } else { longest };
            if !moved {
                break;
            }
            done = if part < left { done + part } else { window.duration };
            self.clock.tell(window.start + done);
        }
        accelerate(work.particles, gravity * done);
        Ok(done)
    }

    /// Prepares a part, a piece of the window: moves particles beyond periodic sides back into the box, sorts the store
    /// after every [`WINDOWS_PER_SORT`] searches, and increases the count of searches.
    fn prepare<S: Solve<Carried = C>>(&mut self, work: &mut Work<C>, piece: &WindowPiece) {
        let began = self.clock.now();
        if self.counters.neighbour_builds.is_multiple_of(WINDOWS_PER_SORT) {
            sort::<S>(work, &mut self.processes);
        }
        work.wrap();
        self.counters.neighbour_builds += 1;
        self.counters.foreseen += piece.foreseen;
        self.spent.neighbours += self.clock.now() - began;
    }

    /// Moves all particles through a part, a piece of the window. Returns false if an island (group of particles that
    /// may meet) is too large or the engine fails; no particle has then moved, except by shifts of whole periods into
    /// the box.
    fn part<S: Solve<Carried = C>>(
        &mut self,
        solver: &S,
        work: &mut Work<C>,
        window: Window,
        piece: &WindowPiece,
    ) -> bool {
        self.prepare::<S>(work, piece);
        let (scene, frame, part) = (work.scene, self.frame, piece.part);
        loop {
            let began = self.clock.now();
            let view = self.processes.borrow::<S>(work, (frame, part), piece.flight());
            self.spent.neighbours += self.clock.now() - began;
            let touches = self.find(work, view.region.clone(), piece);
            in_order(solver, work);
            let carried: Vec<[Option<u32>; 2]> = work.lasting.iter().map(S::indices).collect();
            let energy: Vec<f64> = work.lasting.iter().map(|carried| solver.available_energy(carried)).collect();
            let limits = IslandLimits { crowds: solver.takes_crowds(), most: piece.most };
            let space = Space { scene, frame, part, lightest: piece.population.lightest };
            let mut islands = S::Finder::new(Clusters::new(&mut self.search, work.particles, space), limits);
            let fallen = scene.gravity * piece.elapsed;
            let task = Task { solver, scene, window, fallen, part, carried: work.lasting.as_slice() };
            let gathered = islands.gather(&touches, &carried, energy);
            let solved = if gathered { solve_all(&mut islands, &task, |index| view.is_mine(index)) } else { None };
            let decision = self.processes.decide(&islands, &view, solved.is_none());
            let clusters = islands.into_clusters();
            if let (PartDecision::Done, Some((batches, counts))) = (&decision, solved) {
                let landing = clusters.land();
                self.counters.add(&counts);
                self.write_back(work, piece, &landing, &batches);
                self.processes.keep(solver, work, &view, &mut self.members);
                return true;
            }
            clusters.release();
            self.processes.give_back(work, view);
            if matches!(decision, PartDecision::Failed) {
                return false;
            }
        }
    }

    /// Writes the results of all islands (groups of particles that may meet) into the particle store and the log, and
    /// moves all other particles on straight lines.
    fn write_back(&mut self, work: &mut Work<C>, piece: &WindowPiece, landing: &Landing, batches: &[Batch<C>]) {
        let (gravity, &WindowPiece { elapsed, part, .. }) = (work.scene.gravity, piece);
        let (fall, fallen) = (gravity * (part * (elapsed + 0.5 * part)), gravity * (elapsed + part));
        let began = self.clock.now();
        let results = IslandResults { landing, batches, fallen };
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
    }

    /// Finds all touches of the particles in `region` that would occur in the next part (piece of a window) if all
    /// particles flew straight.
    fn find(&mut self, work: &Work<C>, region: Region, piece: &WindowPiece) -> Vec<FirstTouch> {
        let began = self.clock.now();
        let span = SearchInterval::new(work.scene, piece.elapsed, piece.part);
        self.search.build(work.particles, work.scene, region, self.frame, &span);
        let hot = self.search.hot(work.particles, work.scene, &span);
        self.counters.searched += hot.checks;
        self.spent.neighbours += self.clock.now() - began;
        hot.touches
    }
}
