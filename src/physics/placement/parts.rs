//! Random starts that several processes make together. Each process generates all particles at random, and keeps the
//! particles in its own block (part of the box) and near this block.

use super::draw::draw;
use super::{
    Crowded, FreeRoom, INSERTION_LIMIT, MARGIN, ROUNDS, StartPlan, There, displaced, initial_state, look_for_overlaps,
};
use crate::communicator::Communicator;
use crate::domain::blocks::Blocks;
use crate::experiment::{Amount, Experiment};
use crate::neighbours::NeighbourList;
use crate::neighbours::region::Region;
use crate::particles::{Particles, fingerprint_of};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rustc_hash::FxHashMap;

/// Initial state of a run, complete or divided among processes.
#[derive(Clone, Debug)]
pub struct Start {
    /// All particles in the order of their ids, or only the particles in the block of this process. The blocks are
    /// those of [`Blocks::of_one_size`].
    pub particles: Particles,
    /// Number of particles of the start in all processes.
    pub count: usize,
    /// Checksum of the particles of all processes, as [`Particles::fingerprint`] computes it.
    pub fingerprint: u64,
    /// True if `particles` are the particles in the block (part of the box) of this process; false if they are all
    /// particles.
    pub is_part: bool,
}

impl From<Particles> for Start {
    /// Makes a start (initial state) from all particles of a run.
    fn from(particles: Particles) -> Self {
        Self { count: particles.len(), fingerprint: particles.fingerprint(), is_part: false, particles }
    }
}

impl Start {
    /// Makes the complete start of an experiment in one process. It depends only on the experiment and its seed.
    ///
    /// # Errors
    /// Errors of [`initial_state`].
    pub fn whole(experiment: &Experiment) -> Result<Self, Crowded> {
        initial_state(experiment).map(Self::from)
    }

    /// Makes the start of an experiment in this process. The start contains the particles of this process if
    /// [`comes_in_parts`] is true, otherwise all particles. All processes must call this function.
    ///
    /// # Errors
    /// Errors of [`initial_state`]; either all processes return an error or none does.
    pub fn part(experiment: &Experiment, communicator: &dyn Communicator) -> Result<Self, Crowded> {
        if !comes_in_parts(experiment) {
            return Self::whole(experiment);
        }
        let particles = part(experiment, communicator)?;
        let fingerprint = fingerprint_of(&particles, Some(communicator));
        Ok(Self { particles, count: experiment.count(), fingerprint, is_part: true })
    }
}

/// True if processes can make a start together, so that no process stores all particles. All particles must start at
/// random positions in the whole box, and all particles of a species must have one size. The volume fraction must be so
/// low that overlapping particles get new random positions. The box must not be sheared.
pub fn comes_in_parts(experiment: &Experiment) -> bool {
    let drawn = experiment.start.iter().all(|population| matches!(population.amount, Amount::Count(_)));
    let anywhere = experiment.start.iter().all(|population| population.region.is_none());
    let is_simple = drawn && anywhere && !experiment.scene.has_sizes() && experiment.scene.domain.shear.is_none();
    is_simple && StartPlan::of(experiment).filled(&FreeRoom::of(&experiment.scene)) <= INSERTION_LIMIT
}

/// Makes the particles in the block of this process, in the order of their ids.
fn part(experiment: &Experiment, communicator: &dyn Communicator) -> Result<Particles, Crowded> {
    let (room, rank) = (FreeRoom::of(&experiment.scene), communicator.rank());
    let domain = &room.scene.domain;
    let blocks = Blocks::of_one_size(communicator.size(), domain);
    let largest = room.scene.species.iter().map(|species| species.largest()).fold(0.0, f64::max);
    // this region contains all particles that can overlap a particle of the block with its enlarged radius
    let around = Region::around(domain, blocks.corners(rank, domain), largest * (1.0 + 2.0 * MARGIN));
    let is_near = |x: &Vector3<f64>| around.depth(x, domain) >= 0.0;
    let is_mine = |x: &Vector3<f64>| blocks.owner(x) == rank;
    let mut random = Xoshiro256PlusPlus::seed_from_u64(experiment.run.seed);
    let mut particles = draw(StartPlan::of(experiment), &vec![&room; experiment.start.len()], &mut random, &is_near);
    particles.radius.iter_mut().for_each(|radius| *radius *= 1.0 + MARGIN);
    let there = There { region: around.clone(), may_move: &|_| true, is_counted: &is_mine };
    let (mut list, mut bad) = (NeighbourList::default(), [0]);
    for _ in 0..ROUNDS {
        let (overlaps, own) = look_for_overlaps(&mut particles, &mut list, &there, &room);
        bad = [own as i64];
        communicator.sum(&mut bad);
        if bad[0] == 0 {
            break;
        }
        let places: Vec<u32> = displaced(&particles, &overlaps, &|_| true).iter().map(|(_, place)| *place).collect();
        let mut again = gathered(&particles, &places, communicator);
        for (place, radius) in again.position.iter_mut().zip(&again.radius) {
            *place = room.somewhere(*radius, &mut random);
        }
        let moved: FxHashMap<u32, ()> = again.id.iter().map(|id| (*id, ())).collect();
        keep(&mut particles, |particles, place| !moved.contains_key(&particles.id[place]));
        let near = |place: &u32| is_near(&again.position[*place as usize]);
        particles.copy_from(&again, &(0..again.len() as u32).filter(near).collect::<Vec<u32>>());
    }
    keep(&mut particles, |particles, place| is_mine(&particles.position[place]));
    particles.sort_by_id();
    particles.shrink();
    let species = &room.scene.species;
    let radius = |kind: &u16| 0.5 * species[usize::from(*kind)].diameter;
    particles.radius = particles.species.iter().map(radius).collect();
    experiment.scene.let_rotate(&mut particles);
    if bad[0] == 0 {
        return Ok(particles);
    }
    let wanted = StartPlan::of(experiment).filled(&room);
    let reached = wanted * (1.0 - bad[0] as f64 / experiment.count() as f64).max(0.0);
    Err(Crowded { wanted, reached, room: room.volume(), given_up: false, most: None })
}

/// Removes all particles for which `stays` returns false. The arguments of `stays` are the particles and the index of
/// one particle.
fn keep(particles: &mut Particles, stays: impl Fn(&Particles, usize) -> bool) {
    let places: Vec<u32> = (0..particles.len() as u32).filter(|place| stays(particles, *place as usize)).collect();
    particles.reorder(&places);
}

/// Returns copies of the particles at the indices `places` of all processes, in the order of their ids. A particle that
/// is stored by several processes occurs once in the result. All processes must call this function.
fn gathered(particles: &Particles, places: &[u32], communicator: &dyn Communicator) -> Particles {
    let mut bytes = Vec::new();
    particles.pack(places, &mut bytes);
    let mut all = Particles::default();
    for bytes in communicator.exchange(vec![bytes; communicator.size()]) {
        // unpacking cannot fail, since `pack` wrote these bytes
        let _ = all.unpack(&bytes);
    }
    all.sort_by_id();
    let once = |place: &u32| *place == 0 || all.id[*place as usize] != all.id[*place as usize - 1];
    let places: Vec<u32> = (0..all.len() as u32).filter(once).collect();
    all.reorder(&places);
    all
}
