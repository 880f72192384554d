//! Islands solved one after the other by one thread, with what came out close together in memory.

use super::cluster::{Clusters, Landing, PiecewiseTrajectory, VelocityChange};
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
    /// Place of the particle in the store.
    pub place: u32,
    /// Its moving state.
    pub motion: Motion,
}

/// A particle that got out of the bounds of its island.
#[derive(Clone, Copy, Debug)]
pub struct Stop {
    /// Place of the particle in the store.
    pub place: u32,
    /// Whether it only stood by.
    pub bystander: bool,
    /// [m/s] speed relative to the frame of the search.
    pub speed: f64,
}

/// An island that could not be solved, or not at a fair price.
#[derive(Clone, Copy, Debug)]
pub enum GivenUp {
    /// The engine failed. The other way takes the window, and meets the failure again at its instant.
    Failed,
    /// It costs too much: it is a crowd, or the other way takes the window where there are no crowds.
    TooExpensive,
}

impl From<Failure> for GivenUp {
    fn from(_: Failure) -> Self {
        Self::Failed
    }
}

/// The result of an island that is done.
#[derive(Clone, Copy)]
pub struct IslandResult {
    /// Number of its batch.
    pub batch: usize,
    /// Its number in that.
    pub number: usize,
    /// Whether this process counts what happened in it.
    pub counts: bool,
}

/// What an island that could not be ended teaches.
pub enum Retry {
    /// Particles got out of bounds.
    Stops(Vec<Stop>),
    /// It is dear: it is a crowd.
    Crowd,
}

/// What came of one island; ranges are of the lists of its batch.
pub struct Solved {
    pub which: usize,
    /// Who got out of bounds; nobody: it is done.
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
    /// Steps of all of a crowd.
    pub crowd_steps: u64,
    /// Contact forces computed in those.
    pub crowd_forces: u64,
    /// Gaps or touch times computed.
    pub pair_checks: u64,
    /// Contact forces computed.
    pub force_evaluations: u64,
    /// Particles moved by stages of steps, and gaps looked at after steps.
    pub updates: u64,
}

/// What came of several islands.
pub struct Batch<C> {
    pub solved: Vec<Solved>,
    pub states: Vec<HotParticle>,
    /// What lasts beyond the window, by place of the particle in the store.
    pub carried: Vec<C>,
    pub impacts: Vec<(Between, Impact)>,
    /// The ways of the particles of `states`, of an engine that says where they turn.
    pub ways: Vec<PiecewiseTrajectory>,
    /// Where they turn.
    pub turns: Vec<VelocityChange>,
}

/// The results of all islands of a part that is done.
pub struct IslandResults<'a, C> {
    /// Where they are.
    pub landing: &'a Landing,
    /// What came of the islands.
    pub batches: &'a [Batch<C>],
    /// [m/s] by which the frame of the store has fallen.
    pub fallen: Vector3<f64>,
}

/// What happened in some islands, and what lasts.
pub struct Notes<C> {
    /// Places of their members.
    pub members: Vec<u32>,
    /// What lasts beyond the part, by place of the particle in the store.
    pub lasting: Vec<C>,
    /// Impacts that have ended.
    pub impacts: Vec<(Between, Impact)>,
    /// Rows with the same exact sums as the ledgers of all.
    pub ledger: Vec<[f64; ENTRIES]>,
    /// How many they were, and of how many particles.
    pub counts: IslandCounters,
}

impl<C: Copy + Send + Sync> IslandResults<'_, C> {
    /// What happened in all islands, some of them after others.
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

    /// Puts the members of islands, which have labels, where they have come to, and moves everybody else by `fly`. Takes the labels.
    pub fn put(
        &self,
        particles: &mut Particles,
        labels: &mut [Option<Label>],
        fly: impl Fn(&mut Vector3<f64>, &Vector3<f64>) + Sync,
    ) {
        let parts = particles.motion_chunks(CHUNK).into_iter().zip(labels.chunks_mut(CHUNK));
        work_sharing::for_each(parts, |(mut chunk, labels)| {
            for (index, label) in labels.iter_mut().enumerate() {
                // labels of the others are read only, so that each thread has a copy of them in its cache
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

    /// Where a member has come to; `None` if nothing came of its island.
    fn state(&self, label: Label) -> Option<&HotParticle> {
        let (kept, number) = self.landing.of_member[label.member()]?;
        let IslandResult { batch, number: which, .. } = self.landing.kept[kept as usize];
        let batch = &self.batches[batch];
        Some(&batch.states[batch.solved[which].states.start + number as usize])
    }
}

/// Memory that is used again from island to island.
pub struct Workbench<S: Solve> {
    island: Island<S::Carried>,
    scratch: S::Scratch,
}

impl<S: Solve> Default for Workbench<S> {
    fn default() -> Self {
        Self { island: Island::empty(), scratch: S::Scratch::default() }
    }
}

/// What all islands of a part have in common.
pub struct Task<'a, S: Solve> {
    /// The working memory of the engine.
    pub solver: &'a S,
    pub scene: &'a Scene,
    pub window: Window,
    /// [m/s] what gravity has added to the velocities of the store.
    pub fallen: Vector3<f64>,
    /// [s] length of the part.
    pub part: f64,
    /// What the engine carries from the part before.
    pub carried: &'a [S::Carried],
}

impl<S: Solve> Workbench<S> {
    /// Solves the islands `which`.
    pub fn solve(&mut self, task: &Task<S>, clusters: &Clusters, which: &[usize]) -> Batch<S::Carried> {
        // lists that grow while another thread's do wait for one another, where the memory was that thread's before
        let members: usize = which.iter().map(|&which| clusters.members(which)).sum();
        let traced = if task.solver.traces() { members } else { 0 };
        let mut batch = Batch {
            solved: Vec::with_capacity(which.len()),
            states: Vec::with_capacity(members),
            carried: Vec::new(),
            impacts: Vec::with_capacity(members),
            ways: Vec::with_capacity(traced),
            turns: Vec::with_capacity(2 * traced),
        };
        for &which in which {
            let island = &mut self.island;
            clusters.fill(island, which, task.scene, task.fallen);
            let mut carried = clusters.carried(which).iter().map(|&k| &task.carried[k as usize]);
            let stopped = if carried.all(|carried| take_in::<S>(island, carried)) {
                task.solver.solve(island, &mut self.scratch, task.scene, task.window, task.part)
            } else {
                Err(GivenUp::Failed)
            };
            let first = (batch.states.len(), batch.carried.len(), batch.impacts.len(), batch.ways.len());
            if matches!(stopped, Ok(None)) {
                batch.states.extend(
                    (0..island.hot)
                        .map(|k| HotParticle { place: island.places[k], motion: island.particles.motion(k) }),
                );
                let places = &island.places;
                batch.carried.extend(island.carried.iter().map(|c| S::moved(c, &|local| places[local as usize])));
                batch.impacts.append(&mut island.log.impacts);
                if task.solver.traces() {
                    // those of one particle stay in the order of time
                    island.turns.sort_by_key(|(local, _)| *local);
                    let mut rest = island.turns.as_slice();
                    for local in 0..island.hot as u32 {
                        let (own, others) = rest.split_at(rest.partition_point(|(of, _)| *of <= local));
                        let first = batch.turns.len();
                        batch.turns.extend(own.iter().map(|(_, turn)| *turn));
                        batch.ways.push(clusters.way(places[local as usize], &batch.turns[first..], first));
                        rest = others;
                    }
                }
            }
            let stop = |place: usize| Stop {
                place: island.places[place],
                bystander: place >= island.hot,
                speed: island.speed(place),
            };
            batch.solved.push(Solved {
                which,
                stopped: stopped.map(|place| place.into_iter().chain(island.also.iter().copied()).map(stop).collect()),
                states: first.0..batch.states.len(),
                carried: first.1..batch.carried.len(),
                impacts: first.2..batch.impacts.len(),
                ways: first.3..batch.ways.len(),
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
        batch
    }
}

/// Takes what is carried into an island that holds its particles; false, and nothing taken, if one of them is not there.
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

    /// An engine that carries the place of a particle and does nothing.
    struct Idle;

    impl Solve for Idle {
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
