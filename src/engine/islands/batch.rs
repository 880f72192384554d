//! Batches of islands (groups of particles that may meet). One thread solves the islands of a batch one after the
//! other, and stores their results together. A window is the time between two exchanges of momentum with the gas, and a
//! *part* of it is the piece in which islands are solved. *Hot* particles are the members of islands.

use super::cluster::{IslandFinder, Landing, MemberTrajectories, fill};
use super::island::Island;
use super::search::Label;
use super::{IslandCounters, Solve};
use crate::engine::{Failure, Window};
use crate::exact::{BLOCK, condense};
use crate::particles::{CHUNK, Motion, Particles};
use crate::record::{Between, ENTRIES, Impact, Ledger};
use crate::scene::Scene;
use crate::work_sharing;
use nalgebra::Vector3;
use std::ops::Range;

/// State of a hot particle (a member of an island) at the end of the part of a time window, in the frame at rest.
#[derive(Clone, Copy, Debug)]
pub struct HotParticle {
    /// Index of the particle in the particle store.
    pub place: u32,
    /// Position, velocity and other moving quantities of the particle at the end of the part of the time window.
    pub motion: Motion,
}

/// A particle that left the bounds of its island: a member that exceeded its speed limit, or a bystander that was hit.
/// A bystander is a particle that was expected to fly straight.
#[derive(Clone, Copy, Debug)]
pub struct Stop {
    /// Index of the particle in the particle store.
    pub place: u32,
    /// True if the particle was a bystander (particle that members might hit), false if it was a member.
    pub bystander: bool,
    /// Speed [m/s] of the particle relative to the frame in which speed limits are given.
    pub speed: f64,
}

/// Reason why a solver gave up an island.
#[derive(Clone, Copy, Debug)]
pub enum GivenUp {
    /// The engine failed. The classical algorithm then moves all particles through the time window, and stops at the
    /// time of the failure.
    Failed,
    /// The island costs too much. It becomes a crowd, an island that is moved by uniform steps. If the engine does not
    /// take crowds, the classical algorithm moves all particles through the time window.
    TooExpensive,
}

impl From<Failure> for GivenUp {
    fn from(_: Failure) -> Self {
        Self::Failed
    }
}

/// Location of the result of a solved island.
#[derive(Clone, Copy)]
pub struct IslandResult {
    /// Number of the batch that contains the result.
    pub batch: usize,
    /// Number of the island among those of the batch.
    pub number: usize,
    /// True if this process counts the events of the island; otherwise another process that shares the run counts them.
    pub counts: bool,
}

/// Change of an unfinished island before it is solved again.
pub enum Retry {
    /// Particles left the bounds of the island. Bystanders among them become members; for members, the speed limits
    /// rise.
    Stops(Vec<Stop>),
    /// The island is too expensive: it becomes a crowd, which is moved by uniform steps.
    Crowd,
}

/// Result of one island; the ranges refer to the lists of its batch.
pub struct Solved {
    pub which: usize,
    /// Particles that left the bounds of the island; an empty list means that the island is finished.
    pub stopped: Result<Vec<Stop>, GivenUp>,
    pub states: Range<usize>,
    pub carried: Range<usize>,
    pub impacts: Range<usize>,
    pub ways: Range<usize>,
    pub ledger: Ledger,
    /// Number of impulses (hard spheres) or contact steps (soft spheres).
    pub events: u64,
    /// Number of impulses in the hybrid engine, which counts its contact steps in `events`.
    pub impulses: u64,
    /// Number of uniform steps, if the island is a crowd.
    pub crowd_steps: u64,
    /// Number of contact forces computed in uniform steps of crowds (large islands).
    pub crowd_forces: u64,
    /// Number of gaps or times of touch computed.
    pub pair_checks: u64,
    /// Number of contact forces computed.
    pub force_evaluations: u64,
    /// Number of particles moved by stages of contact steps, plus the number of gaps checked after steps. It measures
    /// the work.
    pub updates: u64,
}

/// Results of several islands that one thread has solved.
pub struct Batch<C> {
    pub solved: Vec<Solved>,
    pub states: Vec<HotParticle>,
    /// State carried into the next part, such as contacts; it contains indices of particles in the store.
    pub carried: Vec<C>,
    pub impacts: Vec<(Between, Impact)>,
    /// Trajectories of the particles in `states`; empty unless the engine reports velocity changes.
    pub trajectories: MemberTrajectories,
}

impl<C> Batch<C> {
    /// Makes an empty batch for the islands `which`. Its memory is reserved in advance, because threads delay one
    /// another if lists grow during the work.
    pub fn of<'a, F: IslandFinder<'a>>(islands: &F, which: &[usize]) -> Self {
        let members: usize = which.iter().map(|&which| islands.members(which)).sum();
        Self {
            solved: Vec::with_capacity(which.len()),
            states: Vec::with_capacity(members),
            carried: Vec::new(),
            impacts: Vec::with_capacity(members),
            trajectories: F::trajectories(members),
        }
    }
}

/// Results of all islands in a part of a time window.
pub struct IslandResults<'a, C> {
    /// Locations of the results of the islands.
    pub landing: &'a Landing,
    /// Batches with the results of the islands.
    pub batches: &'a [Batch<C>],
    /// Velocity [m/s] that gravity adds from the beginning of the time window to the end of the part. The velocities in
    /// the particle store do not contain it yet.
    pub fallen: Vector3<f64>,
}

/// Events of several islands, and the state that is carried from these islands into the next part.
pub struct Notes<C> {
    /// Indices of the members of the islands.
    pub members: Vec<u32>,
    /// State carried into the next part, such as contacts; it contains indices of particles in the store.
    pub lasting: Vec<C>,
    /// Impacts that have ended in these islands, each with its two bodies.
    pub impacts: Vec<(Between, Impact)>,
    /// Energies and momenta (ledgers) of all these islands, condensed to a few rows with the same exact sums.
    pub ledger: Vec<[f64; ENTRIES]>,
    /// Counts of the work done in these islands.
    pub counts: IslandCounters,
}

impl<C: Copy + Send + Sync> IslandResults<'_, C> {
    /// Collects the events and the carried state (such as contacts) of all islands, in their order. Returns one
    /// [`Notes`] for each group of islands.
    pub fn notes(&self) -> Vec<Notes<C>> {
        work_sharing::map(self.landing.kept.chunks(BLOCK), |some| self.notes_of(some))
    }

    fn notes_of(&self, islands: &[IslandResult]) -> Notes<C> {
        let each = || islands.iter().map(|kept| (kept, &self.batches[kept.batch]));
        let total = |of: fn(&Solved) -> usize| each().map(|(kept, batch)| of(&batch.solved[kept.number])).sum();
        let mut notes = Notes {
            members: Vec::with_capacity(total(|solved| solved.states.len())),
            lasting: Vec::with_capacity(total(|solved| solved.carried.len())),
            impacts: Vec::with_capacity(total(|solved| solved.impacts.len())),
            ledger: Vec::new(),
            counts: IslandCounters::default(),
        };
        let mut ledgers = Vec::with_capacity(islands.len());
        for (kept, batch) in each() {
            let solved = &batch.solved[kept.number];
            notes.members.extend(batch.states[solved.states.clone()].iter().map(|state| state.place));
            notes.lasting.extend_from_slice(&batch.carried[solved.carried.clone()]);
            if kept.counts {
                let members = solved.states.len() as u64;
                let one = IslandCounters { islands: 1, members, largest: members, ..IslandCounters::default() };
                notes.counts.add(&one);
                notes.impacts.extend_from_slice(&batch.impacts[solved.impacts.clone()]);
                ledgers.push(solved.ledger.to_array());
            }
        }
        condense(&mut ledgers, &mut notes.ledger);
        notes
    }

    /// Writes the results of the islands into the particle store, and moves all other particles by `fly`. Members of
    /// islands are recognised by their labels, which are removed afterwards.
    pub fn put(
        &self,
        particles: &mut Particles,
        labels: &mut [Option<Label>],
        fly: impl Fn(&mut Vector3<f64>, &Vector3<f64>) + Sync,
    ) {
        let parts = particles.motion_chunks(CHUNK).into_iter().zip(labels.chunks_mut(CHUNK));
        work_sharing::for_each(parts, |(mut chunk, labels)| {
            for (index, label) in labels.iter_mut().enumerate() {
                // labels of other particles are not written, so that threads need not exchange the cache lines of
                // labels
                let member = if label.is_some() { label.take() } else { None };
                match member.and_then(|label| self.state(label)) {
                    Some(state) => {
                        let velocity = state.motion.velocity - self.fallen;
                        chunk.set(index, &Motion { velocity, ..state.motion });
                    }
                    None => fly(&mut chunk.position[index], &chunk.velocity[index]),
                }
            }
        });
    }

    /// State of the member with this label at the end of the part; `None` if its island has no result.
    fn state(&self, label: Label) -> Option<&HotParticle> {
        let (kept, number) = self.landing.of_member[label.member()]?;
        let IslandResult { batch, number: which, .. } = self.landing.kept[kept as usize];
        let batch = &self.batches[batch];
        Some(&batch.states[batch.solved[which].states.start + number as usize])
    }
}

/// Memory in which one thread solves one island after the other.
pub struct Workbench<S: Solve> {
    island: Island<S::Carried>,
    scratch: S::Scratch,
}

impl<S: Solve> Default for Workbench<S> {
    fn default() -> Self {
        Self { island: Island::empty(), scratch: S::Scratch::default() }
    }
}

/// Data that all islands of a part of a time window have in common.
pub struct Task<'a, S: Solve> {
    /// The engine's solver of islands.
    pub solver: &'a S,
    pub scene: &'a Scene,
    pub window: Window,
    /// Velocity [m/s] that gravity adds from the beginning of the time window to that of the part. The velocities in
    /// the particle store do not contain it yet.
    pub fallen: Vector3<f64>,
    /// Length [s] of this part of the time window.
    pub part: f64,
    /// State carried over from the previous part, such as contacts.
    pub carried: &'a [S::Carried],
}

impl<S: Solve> Workbench<S> {
    /// Copies an island into the small scene of this workbench, and returns the island with the memory of the solver.
    /// Returns `None` if carried state (such as a contact) of the island involves a particle outside the island.
    pub fn fill(
        &mut self,
        task: &Task<S>,
        islands: &S::Finder<'_>,
        which: usize,
    ) -> Option<(&mut Island<S::Carried>, &mut S::Scratch)> {
        let Self { island, scratch } = self;
        fill(islands, which, island, task.scene, task.fallen);
        let mut carried = islands.carried(which).iter().map(|&k| &task.carried[k as usize]);
        carried.all(|carried| take_in::<S>(island, carried)).then_some((island, scratch))
    }

    /// Stores the result of the island `which` in a batch. `stopped` contains the local index of a particle that left
    /// its bounds (`None` if no particle did), or the reason why the island was given up.
    pub fn record(
        &mut self,
        batch: &mut Batch<S::Carried>,
        islands: &S::Finder<'_>,
        which: usize,
        stopped: Result<Option<usize>, GivenUp>,
    ) {
        let island = &mut self.island;
        let (states, carried) = (batch.states.len(), batch.carried.len());
        let (impacts, ways) = (batch.impacts.len(), batch.trajectories.ways.len());
        if matches!(stopped, Ok(None)) {
            batch.states.extend(
                (0..island.hot).map(|k| HotParticle { place: island.places[k], motion: island.particles.motion(k) }),
            );
            let places = &island.places;
            batch.carried.extend(island.carried.iter().map(|c| S::moved(c, &|local| places[local as usize])));
            batch.impacts.append(&mut island.log.impacts);
            islands.trace(island, &mut batch.trajectories);
        }
        let stop = |place: usize| Stop {
            place: island.places[place],
            bystander: place >= island.hot,
            speed: island.speed(place),
        };
        batch.solved.push(Solved {
            which,
            stopped: stopped.map(|place| place.into_iter().chain(island.also.iter().copied()).map(stop).collect()),
            states: states..batch.states.len(),
            carried: carried..batch.carried.len(),
            impacts: impacts..batch.impacts.len(),
            ways: ways..batch.trajectories.ways.len(),
            ledger: island.log.ledger,
            events: island.events,
            impulses: island.impulses,
            crowd_steps: island.crowd_steps,
            crowd_forces: island.crowd_forces,
            pair_checks: island.pair_checks,
            force_evaluations: island.force_evaluations,
            updates: island.updates,
        });
    }
}

/// Adds an item of carried state, such as a contact, to an island. Returns false, and adds nothing, if one of its
/// particles is not in the island.
fn take_in<S: Solve>(island: &mut Island<S::Carried>, carried: &S::Carried) -> bool {
    let known = S::places(carried).into_iter().flatten().all(|place| island.local(place).is_some());
    if known {
        let moved = S::moved(carried, &|place| island.local(place).unwrap_or(place));
        island.carried.push(moved);
    }
    known
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encounter::Couple;
    use crate::engine::islands::BoundedIslands;

    /// An engine whose carried state is the index of a particle; its solver does nothing.
    struct Idle;

    impl Solve for Idle {
        type Finder<'a> = BoundedIslands<'a>;
        type Carried = u32;
        type Scratch = ();

        fn places(place: &u32) -> [Option<u32>; 2] {
            [Some(*place), None]
        }

        fn moved(place: &u32, place_of: &dyn Fn(u32) -> u32) -> u32 {
            place_of(*place)
        }

        fn energy(&self, _place: &u32) -> f64 {
            0.0
        }

        fn touching(&self, _place: &u32) -> Option<Couple> {
            None
        }

        fn solve(
            &self,
            _island: &mut Island<u32>,
            _scratch: &mut (),
            _scene: &Scene,
            _window: Window,
            _end: f64,
        ) -> Result<Option<usize>, GivenUp> {
            Ok(None)
        }
    }

    #[test]
    fn what_belongs_to_a_stranger_is_not_taken_in() {
        let mut island = Island::empty();
        island.places = vec![7, 3];
        assert!(take_in::<Idle>(&mut island, &3));
        assert!(!take_in::<Idle>(&mut island, &5), "a particle that is not there stands at place 0");
        assert_eq!(island.carried, [1]);
    }
}
