//! Islands: pay only for the particles that touch.
//!
//! In a short window nearly every particle of a dilute gas is alone and flies straight. Those that will touch something
//! on their straight flight are *hot*; hot particles that meet, or might meet after a collision, make an *island*, and an
//! engine solves each island on its own. Particles near enough to be hit by a hot one stand by: should it happen, the
//! island is done again with the bystander in it, and likewise if a hot particle gets faster than was allowed for. So no
//! contact is missed, whatever happens within the window.
//!
//! Islands share nothing, so they are solved in parallel and in any order with the same bits.

mod batch;
mod cluster;
mod island;
mod packed;
mod search;

pub use batch::GivenUp;
pub use island::Island;

use super::driver::Work;
use super::motion::{accelerate, drift};
use super::{Counters, Failure, Spent, Window};
use crate::clock::Clock;
use crate::domain::Domain;
use crate::encounter::{Couple, Other};
use crate::neighbours::along_walls;
use crate::neighbours::levels::Census;
use crate::particles::Particles;
use crate::scene::Scene;
use batch::{Batch, Lesson, Solved, Task, Workbench};
use cluster::{Clusters, Space};
use nalgebra::Vector3;
use rayon::prelude::*;
use search::{FirstTouch, Search};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, SQRT_2};

/// What an engine does with an island.
pub trait Solve: Sync {
    /// What lasts from one window to the next; by place in the store.
    type Carried: Copy + Send + Sync + Serialize + DeserializeOwned;
    /// Working memory, one per thread.
    type Scratch: Default + Send;

    /// Places of the particles something carried belongs to.
    fn places(carried: &Self::Carried) -> [Option<u32>; 2];

    /// The carried value with the places that its particles have after a sort of the store.
    fn moved(carried: &Self::Carried, place_of: &dyn Fn(u32) -> u32) -> Self::Carried;

    /// [J] energy it may give back to its particles.
    fn energy(&self, carried: &Self::Carried) -> f64;

    /// The two bodies that it holds in contact, if it is a contact.
    fn touching(&self, carried: &Self::Carried) -> Option<Couple>;

    /// Whether it takes crowds: islands without a list of who may touch, of more than [`LARGEST_ISLAND`] particles or of all contacts that
    /// last, if these are many.
    fn takes_crowds(&self) -> bool {
        false
    }

    /// Takes the island's particles, in the frame at rest, through [0, end) [s]; stops early if one gets out of bounds
    /// ([`Island::allows`]), and gives its local place (of several one, the others in [`Island::also`]).
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

/// Counts of what islands came to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct IslandCounters {
    /// Impulses (hard) or contact steps (soft).
    pub events: u64,
    /// Impulses (hybrid).
    pub impulses: u64,
    /// Steps of all of an island that is too large for local stepping (hybrid).
    pub crowd_steps: u64,
    /// Contact forces computed in those.
    pub crowd_forces: u64,
    /// Gaps or touch times computed.
    pub pair_checks: u64,
    /// Contact forces computed.
    pub force_evaluations: u64,
    /// Particles moved by stages of steps, and gaps looked at after steps.
    pub updates: u64,
    /// Cell grids built.
    pub neighbour_builds: u64,
    /// Islands solved.
    pub islands: u64,
    /// Particles in them.
    pub members: u64,
    /// Particles of the largest.
    pub largest: u64,
    /// Islands done again with what they met.
    pub redone: u64,
}

impl IslandCounters {
    /// Adds what solving an island took.
    fn count(&mut self, solved: &Solved) {
        self.events += solved.events;
        self.impulses += solved.impulses;
        self.crowd_steps += solved.crowd_steps;
        self.crowd_forces += solved.crowd_forces;
        self.pair_checks += solved.pair_checks;
        self.force_evaluations += solved.force_evaluations;
        self.updates += solved.updates;
    }

    /// What is counted the same in every engine.
    pub fn of_all_engines(&self) -> Counters {
        Counters {
            islands: self.islands,
            island_members: self.members,
            largest_island: self.largest,
            islands_redone: self.redone,
            ..Counters::default()
        }
    }
}

/// Search windows between two sorts of the store: particles move a small part of a cell in each.
const WINDOWS_PER_SORT: u64 = 32;

/// Islands larger than this are not worth their pairwise bookkeeping.
pub const LARGEST_ISLAND: usize = 200;

/// How often a part in which islands grow too large is halved before they are given up for this window.
const SHORTER: usize = 3;

/// Islands per parallel task: a fixed number, so that results do not depend on the threads.
const BATCH: usize = 64;

/// Moves particles window by window, with a solver for the islands.
#[derive(Default)]
pub struct Islands {
    /// Times the search and the flight.
    pub clock: Clock,
    /// Time spent.
    pub spent: Spent,
    counters: IslandCounters,
    /// Places of the particles in islands of the last part.
    members: Vec<u32>,
    search: Search,
    frame: Vector3<f64>,
}

impl Islands {
    /// What has been done so far.
    pub fn counters(&self) -> IslandCounters {
        self.counters
    }

    /// Goes on from those counts: when the store is sorted next depends on them, nothing else lasts here.
    pub fn resume(&mut self, counters: IslandCounters, spent: Spent) {
        (self.counters, self.spent) = (counters, spent);
    }

    /// Places of the particles that were in islands in the last part.
    pub fn members(&self) -> &[u32] {
        &self.members
    }

    /// Moves all particles for as long as islands are the cheaper way; returns how long that was [s], the whole window in a
    /// dilute scene. `rival` is what the other way costs per particle and time [ns/s].
    ///
    /// # Errors
    /// A velocity that is not a number. An island whose engine fails ends the advance: the other way meets the failure again,
    /// and stops at its instant.
    pub fn advance<S: Solve>(
        &mut self,
        solver: &S,
        work: &mut Work<S::Carried>,
        window: Window,
        rival: f64,
    ) -> Result<f64, Failure> {
        let mut done = 0.0;
        let scene = work.scene;
        self.frame = along_walls(scene, work.particles.mean_velocity());
        while done < window.duration {
            let left = window.duration - done;
            let speeds = Speeds::of(work.particles, self.frame);
            if !speeds.largest.is_finite() {
                accelerate(work.particles, scene.gravity * done);
                return Err(super::not_a_number(work.particles, window.start + done));
            }
            // contacts are carried into a crowd and out of it again, which only a solver of crowds has many of
            let held = if solver.takes_crowds() { work.lasting.len() } else { 0 };
            let limits = Limits { left, rival, held };
            let Some(mut part) = cheapest_part(work.particles, &scene.domain, &speeds, &limits) else { break };
            let stretch = Window { start: window.start + done, duration: left };
            let mut moved = self.part(solver, work, stretch, [done, part]);
            for _ in 0..SHORTER {
                if moved {
                    break;
                }
                part *= 0.5;
                moved = self.part(solver, work, stretch, [done, part]);
            }
            if !moved {
                break;
            }
            done = if part < left { done + part } else { window.duration };
            self.clock.tell(window.start + done);
        }
        accelerate(work.particles, scene.gravity * done);
        Ok(done)
    }

    /// Moves all particles by `part` [s], velocities being in the frame that has fallen for `elapsed` [s]; false, and
    /// nothing moved, if islands grow too large or the engine fails.
    fn part<S: Solve>(
        &mut self,
        solver: &S,
        work: &mut Work<S::Carried>,
        window: Window,
        [elapsed, part]: [f64; 2],
    ) -> bool {
        let touches = self.find::<S>(work, elapsed, part);
        in_order(solver, work);
        let carried: Vec<[Option<u32>; 2]> = work.lasting.iter().map(S::places).collect();
        let energy: Vec<f64> = work.lasting.iter().map(|carried| solver.energy(carried)).collect();
        let space = Space { scene: work.scene, frame: self.frame, part, crowds: solver.takes_crowds() };
        let mut clusters = Clusters::new(&mut self.search, work.particles, space);
        let fallen = work.scene.gravity * elapsed;
        let task = Task { solver, scene: work.scene, window, fallen, part, carried: work.lasting.as_slice() };
        let gathered = clusters.gather(&touches, &carried, energy);
        let batches = if gathered { solve_all(&mut clusters, &task, &mut self.counters) } else { None };
        let kept = clusters.release();
        let Some(batches) = batches else { return false };
        let fall = work.scene.gravity * (part * (elapsed + 0.5 * part));
        self.clock.time(&mut self.spent.flight, || drift(work.particles, part, fall));
        work.lasting.clear();
        self.members.clear();
        for (batch, k) in kept {
            self.write_back(work, &batches[batch], k, work.scene.gravity * (elapsed + part));
        }
        true
    }

    /// All touches on straight flights in the next `part` [s].
    fn find<S: Solve>(&mut self, work: &mut Work<S::Carried>, elapsed: f64, part: f64) -> Vec<FirstTouch> {
        let began = self.clock.now();
        if self.counters.neighbour_builds.is_multiple_of(WINDOWS_PER_SORT) {
            sort::<S>(work);
        }
        work.particles.wrap(&work.scene.domain);
        self.counters.neighbour_builds += 1;
        self.search.build(work.particles, work.scene, self.frame, part);
        let hot = self.search.hot(work.particles, work.scene, elapsed, part);
        self.counters.pair_checks += hot.checks;
        self.spent.neighbours += self.clock.now() - began;
        hot.touches
    }

    /// Puts the result of one island into the store, whose frame has fallen by `fallen` [m/s].
    fn write_back<C: Copy>(&mut self, work: &mut Work<C>, batch: &Batch<C>, k: usize, fallen: Vector3<f64>) {
        let solved = &batch.solved[k];
        let members = solved.states.len() as u64;
        self.counters.islands += 1;
        self.counters.members += members;
        self.counters.largest = self.counters.largest.max(members);
        for state in &batch.states[solved.states.clone()] {
            let place = state.place as usize;
            work.particles.position[place] = state.position;
            work.particles.velocity[place] = state.velocity - fallen;
            self.members.push(state.place);
        }
        work.lasting.extend_from_slice(&batch.carried[solved.carried.clone()]);
        work.log.impacts.extend_from_slice(&batch.impacts[solved.impacts.clone()]);
        work.log.islands.push(solved.ledger.to_array());
    }
}

/// Solves all islands, those that met what was not expected again; `None` if one grows too large or the engine fails in one.
fn solve_all<S: Solve>(
    clusters: &mut Clusters,
    task: &Task<S>,
    counters: &mut IslandCounters,
) -> Option<Vec<Batch<S::Carried>>> {
    let mut batches: Vec<Batch<S::Carried>> = Vec::new();
    let mut todo = clusters.unsolved();
    while !todo.is_empty() {
        let islands = &*clusters;
        let solve = |bench: &mut Workbench<S>, which: &[usize]| bench.solve(task, islands, which);
        let solved: Vec<Batch<S::Carried>> = todo.par_chunks(BATCH).map_init(Workbench::default, solve).collect();
        let mut lessons = Vec::new();
        for mut batch in solved {
            for (k, solved) in batch.solved.iter_mut().enumerate() {
                counters.count(solved);
                match std::mem::replace(&mut solved.stopped, Ok(Vec::new())) {
                    Ok(stops) if stops.is_empty() => clusters.keep(solved.which, (batches.len(), k)),
                    Ok(stops) => lessons.push((solved.which, Lesson::Stops(stops))),
                    Err(GivenUp::Dear) if task.solver.takes_crowds() => lessons.push((solved.which, Lesson::Crowd)),
                    // left to the other way, which stops at the instant of the failure
                    Err(_) => return None,
                }
            }
            batches.push(batch);
        }
        counters.redone += lessons.len() as u64;
        if !clusters.learn(lessons) {
            return None;
        }
        todo = clusters.unsolved();
    }
    Some(batches)
}

/// Puts what lasts in an order that does not depend on that of the store: of the ids of its particles, and of walls.
fn in_order<S: Solve>(solver: &S, work: &mut Work<S::Carried>) {
    let id = &work.particles.id;
    work.lasting.sort_by_cached_key(|carried| {
        let wall = match solver.touching(carried).map(|couple| couple.other) {
            Some(Other::Wall(at)) => Some((at.wall, at.which)),
            _ => None,
        };
        (S::places(carried).map(|place| place.map(|place| id[place as usize])), wall)
    });
}

/// Puts the store in cell order, so that neighbours in space are neighbours in memory.
fn sort<S: Solve>(work: &mut Work<S::Carried>) {
    work.particles.wrap(&work.scene.domain);
    let order = search::cell_order(work.particles, &work.scene.domain);
    let mut place_of = vec![0u32; order.len()];
    for (place, &from) in order.iter().enumerate() {
        place_of[from as usize] = place as u32;
    }
    work.particles.reorder(&order);
    for carried in work.lasting.iter_mut() {
        *carried = S::moved(carried, &|place| place_of[place as usize]);
    }
}

/// Speeds relative to a frame [m/s].
struct Speeds {
    mean: f64,
    largest: f64,
}

impl Speeds {
    fn of(particles: &Particles, frame: Vector3<f64>) -> Self {
        Self { mean: particles.mean_square_speed(frame).sqrt(), largest: particles.largest_speed(frame) }
    }
}

/// Distances at which two particles touch, over the largest diameter: 1 if all are of one size.
struct Sizes {
    /// Mean square over all pairs.
    square: f64,
    /// Mean over the partners of a largest particle, whose islands run together first.
    of_largest: f64,
}

impl Sizes {
    fn of(particles: &Particles, largest: f64) -> Self {
        let [mean, square, _] = particles.mean_radii(largest);
        Self { square: 0.5 * (square + mean * mean), of_largest: 0.5 * (1.0 + mean) }
    }
}

/// What the choice of a part must know besides the particles.
struct Limits {
    /// [s] to the end of the window.
    left: f64,
    /// [ns/s] what the other way costs per particle and time.
    rival: f64,
    /// Contacts that are taken into crowds and out again in every part.
    held: usize,
}

/// [s] the part of what is left that costs least per time, or `None` where islands do not pay.
///
/// A longer part spreads the search of all particles over more time but looks at more pairs, and makes more islands. The
/// weights are in ns on one core, measured once (docs/architecture.md, "Islands"); they choose, they do not time.
fn cheapest_part(particles: &Particles, domain: &Domain, speeds: &Speeds, limits: &Limits) -> Option<f64> {
    /// Flight, cells, ranges of cells: per particle.
    const SEARCH: f64 = 90.0;
    /// Looking at one pair.
    const PAIR: f64 = 1.2;
    /// Making and solving an island, per hot particle.
    const ISLAND: f64 = 1400.0;
    /// Taking a contact of a crowd along: its particles into the crowd and back, and their list.
    const HELD: f64 = 500.0;
    /// Islands in reach of one another unite, and then reach further: where each has a quarter of another in reach they run
    /// together (case D: islands of 20 at parts of 0.5 ms, of 200 at 0.7 ms).
    const CROWDED: f64 = 0.25;
    let Limits { left, rival, held } = *limits;
    let count = particles.len() as f64;
    let search = SEARCH + HELD * held as f64 / count;
    let diameter = 2.0 * particles.radius.iter().fold(0.0, |a: f64, &r| a.max(r));
    let density = count / domain.volume();
    let touch = Sizes::of(particles, 0.5 * diameter);
    let census = Census::of(&particles.radius, domain.volume());
    // hot: what a sphere of radius d sweeps at the mean relative speed, and at the walls
    let rate = density * PI * diameter * diameter * touch.square * speeds.mean * SQRT_2;
    let periods = (0..3).filter(|axis| domain.periodic[*axis]).map(|axis| domain.size[axis]);
    let period = periods.fold(f64::INFINITY, f64::min);
    // two that approach each other from both sides must not meet a further image than the nearest, which is at most half a
    // period away
    let room = (0.5 * period - diameter) / (2.0 * speeds.largest);
    if room <= 0.0 {
        return None;
    }
    let mut best: Option<(f64, f64)> = None;
    let mut pieces = (left / room).ceil().max(1.0);
    for _ in 0..40 {
        let part = left / pieces;
        let edge = diameter + speeds.largest * part;
        let hot = rate * part;
        // few particles always fit into islands; a crowd must stay sparse
        let reach = diameter * touch.of_largest + 1.5 * speeds.mean * part;
        let others = if count > 8.0 { density * hot * 4.0 / 3.0 * PI * reach.powi(3) } else { 0.0 };
        if others < CROWDED {
            let in_one_grid = || 13.5 * density * edge.powi(3).max(0.5 / density);
            let pairs = census.as_ref().map_or_else(in_one_grid, |census| census.looked_at(speeds.largest * part));
            let cost = (search + PAIR * pairs + ISLAND * hot / (1.0 - others / CROWDED)) / part;
            if cost < rival && best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, part));
            }
        }
        pieces = (pieces * 1.3).ceil();
    }
    // one collision costs less than the search for it: then everybody is busy, and one calendar or step serves all
    best.map(|(_, part)| part)
}
