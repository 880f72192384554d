//! Batches of islands (groups of particles that may meet). One thread solves the islands of a batch one after the
//! other, and stores their results together. A window is the time between two exchanges of momentum with the gas, and a
//! *part* of it is the piece in which islands are solved. *Hot* particles are the members of islands. *Carried*
//! contacts (or recent collisions) continue from one part to the next.

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

/// State of a hot particle (a member of an island) at the end of a part, a piece of the time between two exchanges
/// with the gas. Position and velocity are relative to the frame at rest.
#[derive(Clone, Copy, Debug)]
pub struct HotParticle {
    /// Index of the particle in the particle store.
    pub index: u32,
    /// Position, velocity and other moving quantities of the particle at the end of the part (interval of time).
    pub motion: Motion,
}

/// A particle because of which an island (group of particles that may meet) must be solved again. It is a member that
/// exceeded its speed limit, or a bystander (a particle that was expected to fly straight) that a member touched.
#[derive(Clone, Copy, Debug)]
pub struct Stop {
    /// Index of the particle in the particle store.
    pub index: u32,
    /// True if the particle is a bystander, which was expected to fly straight; false if it is a member of the island.
    pub bystander: bool,
    /// [m/s] speed of the particle, relative to the moving frame in which the speed limits (estimated upper bounds) of
    /// the members are given.
    pub speed: f64,
}

/// Reason why the computation of an island (group of particles that may meet) was given up.
#[derive(Clone, Copy, Debug)]
pub enum GivenUp {
    /// The engine failed. The classical algorithm then moves all particles at once, and stops at the time of the
    /// failure.
    Failed,
    /// The island (group of particles that may meet) costs too much. It becomes a crowd, an island that is moved by
    /// uniform steps. If the engine does not take crowds, uniform steps or one event queue move all particles.
    TooExpensive,
}

impl From<Failure> for GivenUp {
    fn from(_: Failure) -> Self {
        Self::Failed
    }
}

/// Place of the result of a solved island (group of particles that may meet).
#[derive(Clone, Copy)]
pub struct IslandResult {
    /// Number of the batch (islands that one thread has solved) that contains the result.
    pub batch: usize,
    /// Number of the island (group of particles that may meet) among those of its batch.
    pub number: usize,
    /// True if this process counts the impacts and the work of the island (group of particles that may meet); false if
    /// another process that shares the run does.
    pub counts: bool,
}

/// Change of an island (group of particles that may meet) before it is solved again in the same part of the window.
pub enum Retry {
    /// Particles for which the result is wrong: bystanders that were hit become members of the island (group of
    /// particles that may meet), and members that were too fast get a higher speed limit.
    Stops(Vec<Stop>),
    /// The island is too expensive: it becomes a crowd, an island that is moved by uniform steps.
    Crowd,
}

/// Result of one solved island (group of particles that may meet); the ranges refer to the lists of the `Batch` that
/// contains this result.
pub struct Solved {
    pub which: usize,
    /// Particles because of which the island (group of particles that may meet) must be solved again; the result is
    /// valid if the list is empty. The error is the reason why the island was given up.
    pub stopped: Result<Vec<Stop>, GivenUp>,
    pub states: Range<usize>,
    pub carried: Range<usize>,
    pub impacts: Range<usize>,
    pub ways: Range<usize>,
    pub ledger: Ledger,
    /// Number of collisions (hard spheres), or of time steps of contacts (soft and hybrid spheres).
    pub events: u64,
    /// Number of collisions in the hybrid engine, which counts the time steps of its contacts in `events`.
    pub impulses: u64,
    /// Number of uniform steps, if the island is a crowd (an island that is moved by such steps); otherwise 0.
    pub crowd_steps: u64,
    /// Number of contact forces computed in uniform steps, if the island is a crowd; otherwise 0.
    pub crowd_forces: u64,
    /// Number of gaps and times of touch that were computed for the island (group of particles that may meet).
    pub pair_checks: u64,
    /// Number of contact forces that were computed in the island, those of uniform steps included.
    pub force_evaluations: u64,
    /// Measure of the work: one for each particle moved in each stage of the time integrator, plus one for each gap
    /// checked after a step. In a crowd (island moved by uniform steps) both count one half.
    pub updates: u64,
}

/// Results of several islands (groups of particles that may meet) that one thread has solved.
pub struct Batch<C> {
    pub solved: Vec<Solved>,
    pub states: Vec<HotParticle>,
    /// Contacts or recent collisions that are carried into the next part (interval of time); they contain indices of
    /// particles in the store.
    pub carried: Vec<C>,
    pub impacts: Vec<(Between, Impact)>,
    /// Trajectories of the particles in `states`; empty unless the engine reports every velocity change.
    pub trajectories: MemberTrajectories,
}

impl<C> Batch<C> {
    /// Makes an empty batch for the results of the islands with the numbers `which` (groups of particles that may
    /// meet). Its memory is reserved in advance, because threads delay one another if lists grow during the work.
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

/// Results of all islands (groups of particles that may meet) for a part, a piece of the time between two exchanges
/// with the gas.
pub struct IslandResults<'a, C> {
    /// Places of the results of all islands (groups of particles that may meet) in the list `batches`.
    pub landing: &'a Landing,
    /// Results of the islands (groups of particles that may meet); one thread has solved all islands of a batch.
    pub batches: &'a [Batch<C>],
    /// [m/s] velocity that gravity adds from the last exchange with the gas to the end of the part (interval of time).
    /// Velocities in the particle store do not contain it yet.
    pub fallen: Vector3<f64>,
}

/// Results of several islands (groups of particles that may meet), apart from the new positions and velocities of their
/// members: impacts, carried contacts and counts.
pub struct Notes<C> {
    /// Indices in the particle store of the members of the islands (groups of particles that may meet).
    pub members: Vec<u32>,
    /// Contacts or recent collisions that are carried into the next part (interval of time); they contain indices of
    /// particles in the store.
    pub lasting: Vec<C>,
    /// Impacts of these islands, each with the kinds (species or wall) of its two bodies.
    pub impacts: Vec<(Between, Impact)>,
    /// Energies and momenta (ledgers) of all these islands, condensed to a few rows that have the same exact sums.
    pub ledger: Vec<[f64; ENTRIES]>,
    /// Counts of the work in these islands (groups of particles that may meet) and of their members.
    pub counts: IslandCounters,
}

impl<C: Copy + Send + Sync> IslandResults<'_, C> {
    /// Collects the impacts, counts and carried contacts of all islands (groups of particles that may meet), in the
    /// order of the islands. Returns one [`Notes`] for each group of islands that a thread treats as one piece of
    /// work.
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
            notes.members.extend(batch.states[solved.states.clone()].iter().map(|state| state.index));
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

    /// Writes the results of the islands (groups of particles that may meet) into the particle store. `fly` moves the
    /// position (first argument) of each other particle on a straight line by its velocity (second argument). `labels`
    /// contains, by particle index, the marks of the members of islands; the function removes them.
    pub fn put(
        &self,
        particles: &mut Particles,
        labels: &mut [Option<Label>],
        fly: impl Fn(&mut Vector3<f64>, &Vector3<f64>) + Sync,
    ) {
        let parts = particles.motion_chunks(CHUNK).into_iter().zip(labels.chunks_mut(CHUNK));
        work_sharing::for_each(parts, |(mut chunk, labels)| {
            for (index, label) in labels.iter_mut().enumerate() {
                // labels of other particles are not written: threads that write to one cache line wait for each other
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

    /// New state of the island member to which the mark `label` points; `None` if the island of this member has no
    /// result.
    fn state(&self, label: Label) -> Option<&HotParticle> {
        let (kept, number) = self.landing.of_member[label.member()]?;
        let IslandResult { batch, number: which, .. } = self.landing.kept[kept as usize];
        let batch = &self.batches[batch];
        Some(&batch.states[batch.solved[which].states.start + number as usize])
    }
}

/// Memory in which one thread solves one island (group of particles that may meet) after another.
pub struct Workbench<S: Solve> {
    island: Island<S::Carried>,
    scratch: S::Scratch,
}

impl<S: Solve> Default for Workbench<S> {
    fn default() -> Self {
        Self { island: Island::empty(), scratch: S::Scratch::default() }
    }
}

/// Data that all islands (groups of particles that may meet) have in common in a part, a piece of the time between two
/// exchanges with the gas.
pub struct Task<'a, S: Solve> {
    /// Solver of single islands (groups of particles that may meet), which the engine provides.
    pub solver: &'a S,
    pub scene: &'a Scene,
    pub window: Window,
    /// [m/s] velocity that gravity adds from the last exchange with the gas to the start of the part (interval of
    /// time). Velocities in the particle store do not contain it yet.
    pub fallen: Vector3<f64>,
    /// [s] length of the part (interval of time).
    pub part: f64,
    /// Contacts or recent collisions at the start of the part (interval of time), for all islands (groups of particles
    /// that may meet); they contain indices of particles in the store.
    pub carried: &'a [S::Carried],
}

impl<S: Solve> Workbench<S> {
    /// Copies the island with the number `which` (group of particles that may meet) into this workbench, and returns
    /// it with the scratch memory of the solver. `None` if a carried contact (or recent collision) of the island
    /// involves a particle outside the island.
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

    /// Stores the result of the island with the number `which` (group of particles that may meet) in a batch.
    /// `stopped` is what the solver has returned: `None` if the result is valid, or the index, within the island, of a
    /// particle that exceeded its speed limit or was hit unexpectedly. An error is the reason why the island was given
    /// up.
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
                (0..island.hot).map(|k| HotParticle { index: island.indices[k], motion: island.particles.motion(k) }),
            );
            let indices = &island.indices;
            batch.carried.extend(island.carried.iter().map(|c| S::moved(c, &|local| indices[local as usize])));
            batch.impacts.append(&mut island.log.impacts);
            islands.trace(island, &mut batch.trajectories);
        }
        let stop = |index: usize| Stop {
            index: island.indices[index],
            bystander: index >= island.hot,
            speed: island.speed(index),
        };
        batch.solved.push(Solved {
            which,
            stopped: stopped.map(|index| index.into_iter().chain(island.also.iter().copied()).map(stop).collect()),
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

/// Adds the carried item `carried`, such as a contact in progress, to an island (group of particles that may meet).
/// Returns false, and adds nothing, if a particle of the item is not in the island.
fn take_in<S: Solve>(island: &mut Island<S::Carried>, carried: &S::Carried) -> bool {
    let known = S::indices(carried).into_iter().flatten().all(|index| island.local(index).is_some());
    if known {
        let moved = S::moved(carried, &|index| island.local(index).unwrap_or(index));
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

        fn indices(index: &u32) -> [Option<u32>; 2] {
            [Some(*index), None]
        }

        fn moved(index: &u32, index_of: &dyn Fn(u32) -> u32) -> u32 {
            index_of(*index)
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
        island.indices = vec![7, 3];
        assert!(take_in::<Idle>(&mut island, &3));
        assert!(!take_in::<Idle>(&mut island, &5), "a particle that is not there stands at index 0");
        assert_eq!(island.carried, [1]);
    }
}
