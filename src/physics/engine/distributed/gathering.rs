//! Distributing particles from the lead process to all processes, and gathering them in the lead process again. The
//! lead process is process 0.

use super::CrossRankContact;
use super::domains::Domains;
use super::packing::{add_received_contacts, ids_of, pack, packed, take_aboard, unpacked};
use crate::domain::Domain;
use crate::domain::blocks::Blocks;
use crate::engine::driver::Work;
use crate::engine::islands::{Solve, in_order};
use crate::particles::Particles;
use nalgebra::Vector3;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// [-] ratio of the largest number of particles of a process to the mean number, above which the borders of the blocks
/// (regions of the box) are moved. This is done because all processes must wait for the process with most particles.
const FULLEST: f64 = 1.1;

/// Approximate number of particles whose positions determine new borders of the blocks (regions of the box).
const ASKED: usize = 1 << 16;

/// Largest number of particles that a process sends in one message. The limit keeps the memory of messages small for
/// any number of particles.
const SLICE: usize = 1 << 17;

/// Own data of the lead process, kept here while copies of particles of all processes replace these data in the store.
pub struct GatheredPart<C> {
    /// Own particles of the lead process (process 0).
    pub particles: Particles,
    /// Contacts in progress (or recent collisions) among the own particles of the lead process (process 0).
    pub lasting: Vec<C>,
    /// Contacts in progress between an own particle of the lead process (process 0) and a particle of another process.
    pub abroad: Vec<CrossRankContact<C>>,
    /// Indices of the own particles that were members of islands (groups of particles that may meet) when islands were
    /// last solved.
    pub members: Vec<u32>,
}

impl<C: Copy + Serialize + DeserializeOwned> Domains<C> {
    /// Distributes all particles and their contacts in progress (or recent collisions) from the lead process (process
    /// 0) to the processes that own the blocks (regions of the box). New blocks with about equal numbers of particles
    /// are made first.
    pub fn cut<S: Solve<Carried = C>>(&mut self, solver: &S, work: &mut Work<C>) {
        let (domain, size) = (&work.scene.domain, self.communicator.size());
        work.particles.wrap(domain);
        self.blocks = self.of_lead(Blocks::of(&work.particles.position, size, domain));
        let lead = self.is_lead();
        let mut outgoing = vec![Vec::new(); size];
        if lead {
            let owners: Vec<usize> = work.particles.position.iter().map(|x| self.blocks.owner(x)).collect();
            for (rank, bytes) in outgoing.iter_mut().enumerate().skip(1) {
                let is_theirs = |index: &u32| owners[*index as usize] == rank;
                let indices: Vec<u32> = (0..work.particles.len() as u32).filter(is_theirs).collect();
                let lasting = work.lasting.iter().filter(|carried| S::indices(carried).iter().flatten().any(is_theirs));
                *bytes = pack(work.particles, &indices, &ids_of::<S>(work.particles, lasting));
            }
            let mine: Vec<bool> = owners.iter().map(|owner| *owner == 0).collect();
            self.keep_own(solver, work, &mine);
            work.particles.shrink();
        } else {
            work.particles.clear();
            work.lasting.clear();
            self.abroad.clear();
        }
        let incoming = self.communicator.exchange(outgoing);
        self.is_cut = true;
        let Some(lasting) = incoming.first().filter(|_| !lead).and_then(|bytes| take_aboard(bytes, work.particles))
        else {
            return;
        };
        self.abroad = add_received_contacts::<S>(lasting, work);
    }

    /// Moves all particles and contacts to the lead process (process 0), so that the other processes have none.
    /// `members` lists the particles that were in islands (groups of particles that may meet) when islands were last
    /// solved; the function adapts their indices.
    pub fn assemble<S: Solve<Carried = C>>(&mut self, solver: &S, work: &mut Work<C>, members: &mut Vec<u32>) {
        drop(self.gather_sample(solver, work, members, 1));
        if !self.is_lead() {
            *work.particles = Particles::default();
            work.lasting.clear();
            self.abroad.clear();
            members.clear();
        }
        self.is_cut = false;
    }

    /// Replaces the particles of the lead process (process 0) by copies of particles of all processes, until
    /// [`scatter`](Self::scatter) is called. Copies are made of all particles whose id is divisible by `every`, and of
    /// those that are in contact with them. All processes must call this function.
    pub fn gather<S: Solve<Carried = C>>(
        &mut self,
        solver: &S,
        work: &mut Work<C>,
        members: &mut Vec<u32>,
        every: u32,
    ) {
        self.gathered = self.gather_sample(solver, work, members, every);
    }

    /// Restores the own particles of the lead process (process 0), their contacts in progress and the list `members`
    /// of members of islands (groups of particles that may meet), after [`gather`](Self::gather) has replaced them by
    /// copies. Returns false, and changes nothing, if `gather` was not called before.
    pub fn scatter(&mut self, particles: &mut Particles, lasting: &mut Vec<C>, members: &mut Vec<u32>) -> bool {
        let Some(part) = self.gathered.take() else { return false };
        (*particles, *lasting, self.abroad, *members) = (part.particles, part.lasting, part.abroad, part.members);
        true
    }

    /// Begins a run with blocks (regions of the box) of equal size; each process must already store the particles of
    /// its block.
    pub fn begin_cut(&mut self, domain: &Domain) {
        self.blocks = Blocks::of_one_size(self.communicator.size(), domain);
        self.is_cut = true;
    }

    /// Moves the borders of the blocks (regions of the box) if one process has many more particles than the mean. The
    /// particles that are then in the block of another process are sent to it later, when the processes next exchange
    /// particles.
    pub fn balance(&mut self, particles: &Particles, domain: &Domain) {
        let (mut most, count) = ([particles.len() as f64], self.population.count);
        self.communicator.largest(&mut most);
        if most[0] * self.communicator.size() as f64 <= FULLEST * count as f64 {
            return;
        }
        // borders are computed from a sample of all particles, chosen by id
        let every = count.div_ceil(ASKED).max(1) as u32;
        let asked = particles.id.iter().zip(&particles.position).filter(|(id, _)| id.is_multiple_of(every));
        let mut sample = Particles::default();
        asked.for_each(|(_, x)| sample.push(domain.wrap(x), Vector3::zeros(), 0.0, 0.0, 0));
        let mut bytes = Vec::new();
        sample.pack(&sample.id, &mut bytes);
        let mut all = Particles::default();
        for bytes in self.communicator.collect(bytes) {
            // unpacking cannot fail, since `pack` wrote these bytes
            let _ = all.unpack(&bytes);
        }
        self.blocks = self.of_lead(Blocks::of(&all.position, self.communicator.size(), domain));
    }

    /// Fills the store of the lead process (process 0) with copies of particles of all processes: those with an id
    /// divisible by `every`, and those in contact with them. The lead process returns its own data that were in the
    /// store before; the other processes return `None`. In the lead process, `members` then lists the copies of
    /// particles that were in islands (groups of particles that may meet).
    fn gather_sample<S: Solve<Carried = C>>(
        &mut self,
        solver: &S,
        work: &mut Work<C>,
        members: &mut Vec<u32>,
        every: u32,
    ) -> Option<GatheredPart<C>> {
        let (chosen, mut lasting) = chosen::<S>(work, &self.abroad, every);
        let (mut total, mut most) = ([chosen.len() as i64], [chosen.len() as f64]);
        self.communicator.sum(&mut total);
        self.communicator.largest(&mut most);
        let mut slices = chosen.chunks(SLICE);
        let rounds = (most[0] as usize).div_ceil(SLICE).max(1);
        let is_chosen = |index: &&u32| chosen.binary_search(index).is_ok();
        let ids = members.iter().filter(is_chosen).map(|&index| work.particles.id[index as usize]);
        let mut ids: Vec<u32> = ids.collect();
        if !self.is_lead() {
            self.communicator.collect(packed(&ids));
            for _ in 0..rounds {
                let slice = slices.next().unwrap_or_default();
                self.communicator.collect(pack(work.particles, slice, &std::mem::take(&mut lasting)));
            }
            return None;
        }
        for others in self.communicator.collect(Vec::new()).iter().skip(1) {
            ids.extend(unpacked::<Vec<u32>>(others).unwrap_or_default());
        }
        let own = std::mem::take(work.particles);
        let all = &mut *work.particles;
        all.reserve(total[0] as usize);
        all.copy_from(&own, &chosen);
        for _ in 0..rounds {
            for bytes in self.communicator.collect(Vec::new()).iter().skip(1) {
                lasting.extend(take_aboard::<C>(bytes, all).into_iter().flatten());
            }
        }
        let mut index_of = vec![0; all.id.iter().map(|&id| id as usize + 1).max().unwrap_or(0)];
        for (index, &id) in (0u32..).zip(&all.id) {
            index_of[id as usize] = index;
        }
        let index = |id: u32| index_of[id as usize];
        let lasting = lasting.iter().map(|carried| S::moved(carried, &index)).collect();
        let part = GatheredPart {
            particles: own,
            lasting: std::mem::replace(work.lasting, lasting),
            abroad: std::mem::take(&mut self.abroad),
            members: std::mem::replace(members, ids.into_iter().map(index).collect()),
        };
        in_order(solver, work);
        Some(part)
    }
}

/// Indices, in ascending order, of the particles whose id is divisible by `every`, and of those in contact with them.
/// Also returns the contacts of the particles with such an id; these contacts name particles by id instead of index.
/// `abroad` contains the contacts with particles of other processes.
fn chosen<S: Solve>(
    work: &Work<S::Carried>,
    abroad: &[CrossRankContact<S::Carried>],
    every: u32,
) -> (Vec<u32>, Vec<S::Carried>) {
    let id = &work.particles.id;
    let followed = |id: u32| id.is_multiple_of(every.max(1));
    let home = work
        .lasting
        .iter()
        .filter(|carried| S::indices(carried).iter().flatten().any(|&index| followed(id[index as usize])));
    let abroad = abroad.iter().filter(|abroad| S::indices(&abroad.carried).iter().flatten().any(|&id| followed(id)));
    let mut indices: Vec<u32> = (0..id.len() as u32).filter(|&index| followed(id[index as usize])).collect();
    if every > 1 {
        indices.extend(home.clone().flat_map(|carried| S::indices(carried).into_iter().flatten()));
        indices.extend(abroad.clone().map(|abroad| abroad.own));
        indices.sort_unstable();
        indices.dedup();
    }
    let mut lasting = ids_of::<S>(work.particles, home);
    lasting.extend(abroad.map(|abroad| abroad.carried));
    (indices, lasting)
}
