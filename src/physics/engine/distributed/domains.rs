//! One run divided among processes. Each process owns the particles in a block of the box. For each part of a window
//! (the time between two exchanges of momentum with the gas) it also borrows ghost particles. These are copies of
//! particles of other processes that may interact with its own. *Carried* contacts continue from one part to the next.
//! The lead process is process 0.
//!
//! A process computes with its own and the borrowed particles as if no others existed. It solves all islands (groups
//! of particles that may meet) whose surroundings it stores completely. These include islands of other processes, so
//! no results need to be sent back. Each process sends checksums of its results to the processes that borrowed its
//! particles. If two processes obtain different members of an island, or an island reaches too far, all processes
//! borrow from farther away and repeat the part.

use super::CrossRankContact;
use super::gathering::GatheredPart;
use super::packing::{ids_of, pack, packed, take_aboard, unpacked};
use crate::communicator::Communicator;
use crate::domain::Domain;
use crate::domain::blocks::Blocks;
use crate::engine::driver::Work;
use crate::engine::islands::{BoundingSphere, Solve};
use crate::engine::population::PopulationSummary;
use crate::exact::ExactSum;
use crate::neighbours::region::Region;
use nalgebra::Vector3;
use rustc_hash::FxHashMap;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::sync::Arc;

/// [-] smallest width of the zone around the block of a process (its region of the box) from which it borrows (copies)
/// particles of other processes. The width is given in units of the largest distance of any point of a particle from
/// the middle of its straight flight.
const SEEN: f64 = 4.0;

/// [-] width of the zone from which a process borrows (copies) particles of other processes in the first part (piece
/// of a window) of a run. It is given in the same unit as [`SEEN`]. The value is large, because in this first part the
/// width that islands (groups of particles that may meet) need is not yet known. A gas of 10⁶ particles in a channel
/// (case D of docs/paper.md) needs the width 8. With too small a width the part is repeated, which costs as much as a
/// whole window.
const SEEN_AT_FIRST: f64 = 10.0;

/// Number of particles per process below which processes do not share uniform steps, because most stored particles
/// would then be ghosts, copies of particles of other processes.
const FEWEST: usize = 200;

/// Division of a run among several processes; `C` is the type of the state that is carried from one interval of time to
/// the next, such as contacts in progress.
pub struct Domains<C> {
    pub(super) communicator: Arc<dyn Communicator>,
    /// Blocks of the box, one per process.
    pub(super) blocks: Blocks,
    /// [m] distance from the block (region of the box) of this process within which it borrows (copies) particles of
    /// other processes.
    pub(super) width: f64,
    /// True if each process stores only the particles of its block; false if the lead process (process 0) stores the
    /// particles of all blocks.
    pub is_cut: bool,
    /// Contacts in progress between a particle of this process and one of another process.
    pub abroad: Vec<CrossRankContact<C>>,
    /// Own data of the lead process (process 0), kept here while copies of particles of all processes replace these
    /// data in the store. `None` at other times, and in other processes.
    pub(super) gathered: Option<GatheredPart<C>>,
    /// Summary of the sizes of all particles of the run.
    pub population: Arc<PopulationSummary>,
}

/// Particles that a process stores in a part (piece of the time between two exchanges with the gas): its own, and
/// copies of particles of other processes.
pub struct LocalParticles<C> {
    /// For each particle in the store, true if this process owns it; empty if this process owns all particles.
    pub(super) mine: Vec<bool>,
    /// Number of particles in the store at the start of the part (interval of time), before those of other processes
    /// were copied.
    pub(super) count: usize,
    /// Contacts in progress (or recent collisions) at the start of the part (interval of time): those among own
    /// particles, and those between an own particle and one of another process.
    pub(super) lasting: (Vec<C>, Vec<CrossRankContact<C>>),
    /// Index in the store of each stored particle that another process owns, by the id of the particle.
    pub(super) strangers: FxHashMap<u32, u32>,
    /// True if all particles that have a carried contact with an own particle are in the store.
    pub complete: bool,
    /// Region of the box in which this process stores all particles, its own and copies of others.
    pub region: Region,
}

impl<C: Copy + Serialize + DeserializeOwned> Domains<C> {
    /// Divides a run among the processes that `communicator` connects. All processes use the summary of sizes of the
    /// lead process (process 0).
    pub fn new(communicator: Arc<dyn Communicator>, population: PopulationSummary) -> Self {
        let population = unpacked(&communicator.broadcast(packed(&population))).unwrap_or(population);
        Self {
            communicator,
            blocks: Blocks::default(),
            width: 0.0,
            is_cut: false,
            abroad: Vec::new(),
            gathered: None,
            population: Arc::new(population),
        }
    }

    /// Returns, in every process, the `value` that the lead process (process 0) has passed. All processes must call
    /// this function.
    pub fn of_lead<T: Serialize + DeserializeOwned>(&self, value: T) -> T {
        unpacked(&self.communicator.broadcast(packed(&value))).unwrap_or(value)
    }

    /// True if this process is the lead process (process 0).
    pub fn is_lead(&self) -> bool {
        self.communicator.is_lead()
    }

    /// Replaces each sum by its total over all processes, if each process stores only its own particles. If the lead
    /// process (process 0) stores all particles, the sums do not change.
    pub fn total(&self, sums: &mut [&mut ExactSum]) {
        if self.is_cut {
            self.communicator.total(sums);
        }
    }

    /// Replaces each count by its sum over all processes, which must all call this function.
    pub fn count(&self, counts: &mut [i64]) {
        self.communicator.sum(counts);
    }

    /// Replaces each value by the largest value of all processes, if each process stores only its own particles. If
    /// the lead process (process 0) stores all particles, the values do not change.
    pub fn largest(&self, values: &mut [f64]) {
        if self.is_cut {
            self.communicator.largest(values);
        }
    }

    /// Sends particles that have left the block (region of the box) to the processes that now own them. Copies from
    /// other processes all particles for which the middle of the flight is within the distance `self.width` of the
    /// block.
    ///
    /// A flight is the straight motion during `part` [s], in a frame with the velocity `frame` [m/s]. `flight` [m] is
    /// the largest distance of any point of a particle from the middle of its flight. If `self.width` is too small for
    /// `flight`, the function first raises `self.width`. Returns the description of the particles now in the store.
    pub fn trade<S: Solve<Carried = C>>(
        &mut self,
        work: &mut Work<C>,
        (frame, part): (Vector3<f64>, f64),
        flight: f64,
    ) -> LocalParticles<C> {
        // partners of own particles, and partners of these partners, must be stored. Islands may need an even larger
        // distance, which is known only after the first part.
        let least = if self.width > 0.0 { SEEN } else { SEEN_AT_FIRST };
        self.width = self.width.max(least * flight);
        let (mut mine, indices) = self.sort_out(work, (frame, part), flight);
        let outgoing = indices.iter().map(|indices| self.cargo::<S>(work, indices)).collect();
        let (count, before) = (work.particles.len(), (work.lasting.clone(), self.abroad.clone()));
        let leavers = (0u32..).zip(&mine).filter(|(_, mine)| !**mine);
        let mut strangers: FxHashMap<u32, u32> =
            leavers.map(|(index, _)| (work.particles.id[index as usize], index)).collect();
        let mut lasting = Vec::new();
        for bytes in self.communicator.exchange(outgoing) {
            let first = work.particles.len();
            lasting.extend(take_aboard::<C>(&bytes, work.particles).into_iter().flatten());
            mine.extend(work.particles.position[first..].iter().map(|x| self.is_mine(x)));
            strangers.extend((first as u32..).zip(&work.particles.id[first..]).map(|(index, &id)| (id, index)));
        }
        let mut agrees = true;
        for CrossRankContact { carried, own, .. } in self.abroad.drain(..) {
            let id = work.particles.id[own as usize];
            let index = |other: u32| if other == id { Some(own) } else { strangers.get(&other).copied() };
            // a partner in contact is near, so it was borrowed; otherwise the part must be repeated
            agrees &= S::indices(&carried).iter().flatten().all(|id| index(*id).is_some());
            work.lasting.push(S::moved(&carried, &|id| index(id).unwrap_or(own)));
        }
        // a contact that involves a particle of this process is stored here already
        for carried in lasting {
            if S::indices(&carried).iter().flatten().all(|id| strangers.contains_key(id)) {
                work.lasting.push(S::moved(&carried, &|id| strangers.get(&id).copied().unwrap_or(id)));
            }
        }
        strangers.retain(|_, index| !mine[*index as usize]);
        let domain = &work.scene.domain;
        let region = Region::around(domain, self.block(domain), self.width);
        LocalParticles { mine, count, lasting: before, strangers, complete: agrees, region }
    }

    /// Decides to which processes the particles of this process are sent. A flight is the straight motion during `part`
    /// [s], in a frame with the velocity `frame` [m/s]. No point of a particle is farther than `flight` [m] from the
    /// middle of its flight. The first result is, for each particle, true if this process owns it. The second result
    /// is, for each process, the indices of the particles to be sent there: those that it now owns, and those of which
    /// it needs copies.
    fn sort_out(&self, work: &Work<C>, (frame, part): (Vector3<f64>, f64), flight: f64) -> (Vec<bool>, Vec<Vec<u32>>) {
        let domain = &work.scene.domain;
        let block = self.block(domain);
        let mut indices: Vec<Vec<u32>> = vec![Vec::new(); self.communicator.size()];
        let mut mine = Vec::with_capacity(work.particles.len());
        // a particle at least this far inside the block stays in the block, and no other process borrows it
        let deep = (self.width + flight) * (1.0 + 1e-9);
        for index in 0..work.particles.len() {
            if self.blocks.is_deep(&work.particles.position[index], &block, deep) {
                mine.push(true);
                continue;
            }
            let owner = self.blocks.owner(&work.particles.position[index]);
            mine.push(owner == self.communicator.rank());
            let middle = BoundingSphere::of(work.particles, index, domain, frame, part).middle;
            let mut to = |rank: usize| {
                if indices[rank].last() != Some(&(index as u32)) {
                    indices[rank].push(index as u32);
                }
            };
            self.for_each_borrower(&middle, (&block, domain), &mut to);
            if owner != self.communicator.rank() {
                to(owner);
            }
        }
        (mine, indices)
    }

    /// Packs the particles at `indices`, and all their carried contacts, into bytes for another process.
    fn cargo<S: Solve<Carried = C>>(&self, work: &Work<C>, indices: &[u32]) -> Vec<u8> {
        if indices.is_empty() {
            return Vec::new();
        }
        let goes = |index: &u32| indices.binary_search(index).is_ok();
        let home = work.lasting.iter().filter(|carried| S::indices(carried).iter().flatten().any(goes));
        let mut lasting = ids_of::<S>(work.particles, home);
        let abroad = self.abroad.iter().filter(|abroad| goes(&abroad.own));
        lasting.extend(abroad.map(|abroad| abroad.carried));
        pack(work.particles, indices, &lasting)
    }

    /// Sends particles that have left the block (region of the box) to the processes that now own them, and copies all
    /// particles of other processes within `width` [m] of the block. The first result is, for each particle, true if
    /// this process owns it. The second result is, for each process, the indices of the own particles of which that
    /// process now has copies. The process may have had copies of some of them before.
    pub fn borrow<S: Solve<Carried = C>>(&mut self, work: &mut Work<C>, width: f64) -> (Vec<bool>, Vec<Vec<u32>>) {
        let before = std::mem::replace(&mut self.width, width);
        let LocalParticles { mine, .. } = self.trade::<S>(work, (Vector3::zeros(), 0.0), 0.0);
        let (domain, mut lent) = (&work.scene.domain, vec![Vec::new(); self.communicator.size()]);
        let block = self.block(domain);
        for (index, x) in (0u32..).zip(&work.particles.position).filter(|(index, _)| mine[*index as usize]) {
            self.for_each_borrower(x, (&block, domain), |rank| lent[rank].push(index));
        }
        self.width = before;
        (mine, lent)
    }

    /// True if several processes share the run, and each has enough particles on average to share uniform time steps.
    pub fn is_worth_it(&self) -> bool {
        let size = self.communicator.size();
        size > 1 && self.population.count >= FEWEST * size
    }

    /// Connection by which the processes that share the run exchange messages.
    pub fn communicator(&self) -> Arc<dyn Communicator> {
        self.communicator.clone()
    }
}

impl<C> Domains<C> {
    /// The block of this process, the region of the box that contains its own particles.
    pub fn region(&self, domain: &Domain) -> Region {
        Region::around(domain, self.block(domain), 0.0)
    }

    fn is_mine(&self, x: &Vector3<f64>) -> bool {
        self.blocks.owner(x) == self.communicator.rank()
    }

    /// Lowest and highest corner [m] of the block of this process.
    pub(super) fn block(&self, domain: &Domain) -> [Vector3<f64>; 2] {
        self.blocks.corners(self.communicator.rank(), domain)
    }

    /// Distance [m] from the block (region of the box) of another process. Own particles within this distance are
    /// copied to that process. The distance exceeds `width` by a billionth, to allow for rounding.
    pub(super) fn lent(&self) -> f64 {
        self.width * (1.0 + 1e-9)
    }

    /// Calls `visit` with the number of every other process that needs a copy of an own particle. `x` [m] is the middle
    /// of the particle's flight, or its position. `block` contains the lowest and highest corner of the block (region
    /// of the box) of this process.
    pub(super) fn for_each_borrower(
        &self,
        x: &Vector3<f64>,
        (block, domain): (&[Vector3<f64>; 2], &Domain),
        mut visit: impl FnMut(usize),
    ) {
        let width = self.lent();
        if !self.blocks.is_deep(x, block, width) {
            let others = |rank: usize| {
                if rank != self.communicator.rank() {
                    visit(rank);
                }
            };
            self.blocks.for_each_within(x, width, domain, others);
        }
    }
}

impl<C> LocalParticles<C> {
    /// Describes the particle store of a single process, which owns all particles of the box.
    pub fn all(domain: &Domain) -> Self {
        Self {
            mine: Vec::new(),
            count: 0,
            lasting: (Vec::new(), Vec::new()),
            strangers: FxHashMap::default(),
            complete: true,
            region: Region::from(domain),
        }
    }

    /// True if this process owns the particle at `index` in the store.
    pub fn is_mine(&self, index: u32) -> bool {
        self.mine.get(index as usize).is_none_or(|mine| *mine)
    }
}
