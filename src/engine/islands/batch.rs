//! Islands solved one after the other by one thread, with their results close together in memory.

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

/// A hot particle at the end of the part, in the frame at rest.
#[derive(Clone, Copy, Debug)]
pub struct HotParticle {
    /// Index of the particle in the store.
    pub place: u32,
    /// Position and velocity of the particle.
    pub motion: Motion,
}

/// A particle that got out of the bounds of its island.
#[derive(Clone, Copy, Debug)]
pub struct Stop {
    /// Index of the particle in the store.
    pub place: u32,
    /// True if the particle was a bystander.
    pub bystander: bool,
    /// Speed [m/s] relative to the frame of the search.
    pub speed: f64,
}

/// Reason why an island was not solved.
#[derive(Clone, Copy, Debug)]
pub enum GivenUp {
    /// The engine failed. The classical algorithm takes the window, and meets the failure again at its instant.
    Failed,
    /// The island costs too much. It becomes a crowd; if the engine takes no crowds, the classical algorithm takes the
    /// window.
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
    /// Number of the batch with the result.
    pub batch: usize,
    /// Number of the island in that batch.
    pub number: usize,
    /// True if this process counts the events of the island.
    pub counts: bool,
}

/// Change to make to an unfinished island before it is solved again.
pub enum Retry {
    /// Particles got out of bounds: bystanders become members, or speed limits rise.
    Stops(Vec<Stop>),
    /// The island is too expensive: it becomes a crowd.
    Crowd,
}

/// Result of one island; the ranges refer to the lists of its batch.
pub struct Solved {
    pub which: usize,
    /// Particles that got out of bounds; an empty list means that the island is done.
    pub stopped: Result<Vec<Stop>, GivenUp>,
    pub states: Range<usize>,
    pub carried: Range<usize>,
    pub impacts: Range<usize>,
    pub ways: Range<usize>,
    pub ledger: Ledger,
    /// Impulses or contact steps.
    pub events: u64,
    /// Impulses of an engine that also has contacts.
    pub impulses: u64,
    /// Uniform steps of a crowd.
    pub crowd_steps: u64,
    /// Contact forces computed in steps of a crowd.
    pub crowd_forces: u64,
    /// Gaps or touch times computed.
    pub pair_checks: u64,
    /// Contact forces computed.
    pub force_evaluations: u64,
    /// Particles moved by stages of steps, and gaps checked after steps.
    pub updates: u64,
}

/// Results of several islands.
pub struct Batch<C> {
    pub solved: Vec<Solved>,
    pub states: Vec<HotParticle>,
    /// State carried beyond the window, by index of the particle in the store.
    pub carried: Vec<C>,
    pub impacts: Vec<(Between, Impact)>,
    /// MemberTrajectories of the particles in `states`, if the engine reports velocity changes.
    pub trajectories: MemberTrajectories,
}

impl<C> Batch<C> {
    /// A batch with room for the results of the islands `which`. Memory is reserved at once: threads wait for one another
    /// if a list grows in memory that was another thread's before.
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

/// Results of all islands of a part that is done.
pub struct IslandResults<'a, C> {
    /// Locations of the results.
    pub landing: &'a Landing,
    /// Batches with the results of the islands.
    pub batches: &'a [Batch<C>],
    /// Velocity [m/s] that gravity has added to the frame of the store.
    pub fallen: Vector3<f64>,
}

/// Events of several islands, and the state that they carry on.
pub struct Notes<C> {
    /// Indices of the members of the islands.
    pub members: Vec<u32>,
    /// State carried beyond the part, by index of the particle in the store.
    pub lasting: Vec<C>,
    /// Impacts that have ended.
    pub impacts: Vec<(Between, Impact)>,
    /// Condensed rows with the same exact sums as the ledgers of all islands.
    pub ledger: Vec<[f64; ENTRIES]>,
    /// Number of the islands and of their particles.
    pub counts: IslandCounters,
}

impl<C: Copy + Send + Sync> IslandResults<'_, C> {
    /// Notes of all islands, in groups and in order.
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

    /// Puts the members of islands, which have labels, at their new positions, and moves all other particles by `fly`.
    /// All labels are removed.
    pub fn put(
        &self,
        particles: &mut Particles,
        labels: &mut [Option<Label>],
        fly: impl Fn(&mut Vector3<f64>, &Vector3<f64>) + Sync,
    ) {
        let parts = particles.motion_chunks(CHUNK).into_iter().zip(labels.chunks_mut(CHUNK));
        work_sharing::for_each(parts, |(mut chunk, labels)| {
            for (index, label) in labels.iter_mut().enumerate() {
                // labels of the other particles are only read, so that each thread keeps a copy of them in its cache
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

    /// State of a member at the end of the part; `None` if its island has no result.
    fn state(&self, label: Label) -> Option<&HotParticle> {
        let (kept, number) = self.landing.of_member[label.member()]?;
        let IslandResult { batch, number: which, .. } = self.landing.kept[kept as usize];
        let batch = &self.batches[batch];
        Some(&batch.states[batch.solved[which].states.start + number as usize])
    }
}

/// Working memory that is reused from island to island.
pub struct Workbench<S: Solve> {
    island: Island<S::Carried>,
    scratch: S::Scratch,
}

impl<S: Solve> Default for Workbench<S> {
    fn default() -> Self {
        Self { island: Island::empty(), scratch: S::Scratch::default() }
    }
}

/// Data that all islands of a part have in common.
pub struct Task<'a, S: Solve> {
    /// The solver of the engine.
    pub solver: &'a S,
    pub scene: &'a Scene,
    pub window: Window,
    /// Velocity [m/s] that gravity has added to the velocities of the store.
    pub fallen: Vector3<f64>,
    /// Length of the part [s].
    pub part: f64,
    /// State carried over from the part before.
    pub carried: &'a [S::Carried],
}

impl<S: Solve> Workbench<S> {
    /// Fills the small scene of an island, and returns it with the memory of the solver. Returns `None` if carried state
    /// belongs to a particle that is not in it.
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

    /// Records the result of the island `which`; `stopped` is the local index of a particle that got out of bounds.
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

/// Takes carried state into an island. Returns false, with nothing taken, if one of its particles is not in the island.
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

    /// An engine that carries the index of a particle and does nothing.
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
