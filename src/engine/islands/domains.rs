//! One run cut into domains. Each process has the particles of a block of the box. For each part of a window it borrows
//! the particles of other processes that its own may interact with (ghost particles).
//!
//! A process treats its own and the borrowed particles as if there were no others, and solves all islands that it sees
//! whole. These include islands that other processes own, so no result has to be sent back. It sends its results to the
//! processes that have borrowed its particles. Two processes may disagree on the members of an island, or an island may
//! reach beyond what its owner has borrowed. Then all processes borrow from farther away and repeat the part.

mod parts;
mod whole;

pub use parts::{packed_part, settle};
pub use whole::GatheredPart;

use super::Solve;
use super::cluster::{Clusters, HotParticleDigest};
use super::search::BoundingSphere;
use crate::communicator::Communicator;
use crate::domain::Domain;
use crate::domain::blocks::Blocks;
use crate::encounter::{Couple, FrameTime};
use crate::engine::Overlap;
use crate::engine::driver::{CrossRankContact, Work};
use crate::engine::population::PopulationSummary;
use crate::exact::ExactSum;
use crate::neighbours::region::Region;
use crate::particles::Particles;
use nalgebra::Vector3;
use rustc_hash::FxHashMap;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::sync::Arc;

/// Safety factor of the distance from which particles are borrowed, over the distance needed in the part before. A
/// repeated part costs more than particles borrowed in vain.
const SPARE: f64 = 1.25;

/// Least distance that a process sees beyond its block, in largest reaches of a flight.
const SEEN: f64 = 4.0;

/// Least distance that a process sees beyond its block in the first part of a run, in largest reaches of a flight. Case
/// D with 10⁶ particles needs 8, and a repeated part costs as much as a window.
const SEEN_AT_FIRST: f64 = 10.0;

/// Particles per process below which steps of all particles are not shared: most would be ghost particles of others.
const FEWEST: usize = 200;

/// [bytes] of a stored length.
const LENGTH: usize = 8;

/// One run cut into domains.
pub struct Domains {
    communicator: Arc<dyn Communicator>,
    /// Assignment of blocks to processes.
    blocks: Blocks,
    /// Distance [m] from which particles are borrowed.
    width: f64,
    /// True if the store holds the particles of one block only.
    pub is_cut: bool,
    /// Summary of all particles of the run in a few numbers.
    pub population: Arc<PopulationSummary>,
}

/// The particles that a process sees in a part of a window: its own and the borrowed ones.
pub struct LocalParticles<C> {
    /// Flags by index: true for own particles.
    mine: Vec<bool>,
    /// Number of particles in the store when the part began.
    count: usize,
    /// State carried when the part began: among own particles, and between an own particle and one of another process.
    lasting: (Vec<C>, Vec<CrossRankContact<C>>),
    /// Indices of the particles of other processes, by id.
    strangers: FxHashMap<u32, u32>,
    /// True if all partners in carried state are here.
    pub complete: bool,
    /// Region that holds all these particles.
    pub region: Region,
}

/// Decision of all processes about a part that they have tried.
pub enum PartDecision {
    /// The part is done.
    Done,
    /// The part is to be repeated with particles from farther away.
    Again,
    /// Islands grow too large, or an engine failed.
    Failed,
}

/// Result of one process for a part.
pub struct LocalStatus {
    /// Largest reach [m] of flights and islands.
    pub reach: Reach,
    /// Least distance [m] from the islands of the own particles to the end of the region seen.
    pub room: f64,
    /// True if islands grow too large, or the engine failed.
    pub failed: bool,
    /// True if other processes have the same result.
    pub agrees: bool,
}

/// Largest reach [m] of flights and islands.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reach {
    /// Largest reach of a flight.
    pub flight: f64,
    /// Largest reach of a hot particle about the middle of its flight.
    pub around: f64,
    /// Largest radius of the ball of a hot particle.
    pub ball: f64,
}

impl Reach {
    /// Distance [m] that must be seen around an island to know its surroundings: all flights or balls that may meet it,
    /// and whether those particles are hot.
    pub fn sight(&self) -> f64 {
        self.around.max(self.flight) + 2.0 * self.flight
    }
}

impl Domains {
    /// Domains of a box shared by the given processes. The summary of all particles is that of the lead process.
    pub fn new(communicator: Arc<dyn Communicator>, population: PopulationSummary) -> Self {
        let population = unpacked(&communicator.broadcast(packed(&population))).unwrap_or(population);
        Self { communicator, blocks: Blocks::default(), width: 0.0, is_cut: false, population: Arc::new(population) }
    }

    /// Value of the lead process, sent to all processes.
    pub fn of_lead<T: Serialize + DeserializeOwned>(&self, value: T) -> T {
        unpacked(&self.communicator.broadcast(packed(&value))).unwrap_or(value)
    }

    /// True if this process is the lead.
    pub fn is_lead(&self) -> bool {
        self.communicator.is_lead()
    }

    /// Sums over all processes, if each has particles of its own.
    pub fn total(&self, sums: &mut [&mut ExactSum]) {
        if self.is_cut {
            self.communicator.total(sums);
        }
    }

    /// Sums counts over all processes.
    pub fn count(&self, counts: &mut [i64]) {
        self.communicator.sum(counts);
    }

    /// Largest values over all processes, if each has particles of its own.
    pub fn largest(&self, values: &mut [f64]) {
        if self.is_cut {
            self.communicator.largest(values);
        }
    }

    /// Sends particles that have left the block to their owners, and borrows those whose flights come near. A flight
    /// takes `part` [s] and is seen from `frame` [m/s]; `flight` [m] is the largest reach of a flight.
    pub fn trade<S: Solve>(
        &mut self,
        work: &mut Work<S::Carried>,
        (frame, part): (Vector3<f64>, f64),
        flight: f64,
    ) -> LocalParticles<S::Carried> {
        // partners of own particles and the partners of those must be seen; further needs of islands are known after
        // the first part
        let least = if self.width > 0.0 { SEEN } else { SEEN_AT_FIRST };
        self.width = self.width.max(least * flight);
        let (domain, size) = (&work.scene.domain, self.communicator.size());
        let block = self.block(domain);
        let mut places: Vec<Vec<u32>> = vec![Vec::new(); size];
        let mut mine = Vec::with_capacity(work.particles.len());
        // a particle so deep inside does not leave, and no other process needs it
        let deep = (self.width + flight) * (1.0 + 1e-9);
        for place in 0..work.particles.len() {
            if self.blocks.is_deep(&work.particles.position[place], &block, deep) {
                mine.push(true);
                continue;
            }
            let owner = self.blocks.owner(&work.particles.position[place]);
            mine.push(owner == self.communicator.rank());
            let middle = BoundingSphere::of(work.particles, place, domain, frame, part).middle;
            let mut to = |rank: usize| {
                if places[rank].last() != Some(&(place as u32)) {
                    places[rank].push(place as u32);
                }
            };
            self.for_each_borrower(&middle, (&block, domain), &mut to);
            if owner != self.communicator.rank() {
                to(owner);
            }
        }
        let cargo = |places: &Vec<u32>| {
            if places.is_empty() {
                return Vec::new();
            }
            let goes = |place: &u32| places.binary_search(place).is_ok();
            let home = work.lasting.iter().filter(|carried| S::places(carried).iter().flatten().any(goes));
            let mut lasting = ids_of::<S>(work.particles, home);
            let abroad = work.abroad.iter().filter(|abroad| goes(&abroad.own));
            lasting.extend(abroad.map(|abroad| abroad.carried));
            pack(work.particles, places, &lasting)
        };
        let outgoing = places.iter().map(cargo).collect();
        let (count, before) = (work.particles.len(), (work.lasting.clone(), work.abroad.clone()));
        let leavers = (0u32..).zip(&mine).filter(|(_, mine)| !**mine);
        let mut strangers: FxHashMap<u32, u32> =
            leavers.map(|(place, _)| (work.particles.id[place as usize], place)).collect();
        let mut lasting = Vec::new();
        for bytes in self.communicator.exchange(outgoing) {
            let first = work.particles.len();
            lasting.extend(take_aboard::<S::Carried>(&bytes, work.particles).into_iter().flatten());
            mine.extend(work.particles.position[first..].iter().map(|x| self.is_mine(x)));
            strangers.extend((first as u32..).zip(&work.particles.id[first..]).map(|(place, &id)| (id, place)));
        }
        let mut agrees = true;
        for CrossRankContact { carried, own, .. } in work.abroad.drain(..) {
            let id = work.particles.id[own as usize];
            let place = |other: u32| if other == id { Some(own) } else { strangers.get(&other).copied() };
            // any particle in contact with it comes within reach of it
            agrees &= S::places(&carried).iter().flatten().all(|id| place(*id).is_some());
            work.lasting.push(S::moved(&carried, &|id| place(id).unwrap_or(own)));
        }
        // the carried state of own particles is known already
        for carried in lasting {
            if S::places(&carried).iter().flatten().all(|id| strangers.contains_key(id)) {
                work.lasting.push(S::moved(&carried, &|id| strangers.get(&id).copied().unwrap_or(id)));
            }
        }
        strangers.retain(|_, place| !mine[*place as usize]);
        let region = Region::around(domain, block, self.width);
        LocalParticles { mine, count, lasting: before, strangers, complete: agrees, region }
    }

    /// Sends particles that have left the block to their owners, and borrows all within `width` [m] of it. Returns
    /// flags by index, true for own particles. Also returns the indices of the particles that each process has
    /// borrowed; some of these may have been there before.
    pub fn borrow<S: Solve>(&mut self, work: &mut Work<S::Carried>, width: f64) -> (Vec<bool>, Vec<Vec<u32>>) {
        let before = std::mem::replace(&mut self.width, width);
        let LocalParticles { mine, .. } = self.trade::<S>(work, (Vector3::zeros(), 0.0), 0.0);
        let (domain, mut lent) = (&work.scene.domain, vec![Vec::new(); self.communicator.size()]);
        let block = self.block(domain);
        for (place, x) in (0u32..).zip(&work.particles.position).filter(|(place, _)| mine[*place as usize]) {
            self.for_each_borrower(x, (&block, domain), |rank| lent[rank].push(place));
        }
        self.width = before;
        (mine, lent)
    }

    /// Keeps only the own particles, by flags in order of index, and carried state that involves them.
    pub fn keep_own<S: Solve>(&self, solver: &S, work: &mut Work<S::Carried>, mine: &[bool]) {
        drop(keep(solver, work, mine));
    }

    /// True if there are enough particles to share the steps of all of them.
    pub fn is_worth_it(&self) -> bool {
        let size = self.communicator.size();
        size > 1 && self.population.count >= FEWEST * size
    }

    /// Communicator of the processes.
    pub fn communicator(&self) -> Arc<dyn Communicator> {
        self.communicator.clone()
    }

    /// Returns borrowed particles: the store is as it was before.
    pub fn give_back<C>(&self, work: &mut Work<C>, view: LocalParticles<C>) {
        work.particles.truncate(view.count);
        (*work.lasting, *work.abroad) = view.lasting;
    }

    /// Keeps only the own particles and their carried state after a part that is done.
    pub fn keep<S: Solve>(
        &self,
        solver: &S,
        work: &mut Work<S::Carried>,
        view: LocalParticles<S::Carried>,
        members: &mut Vec<u32>,
    ) {
        let stay = keep(solver, work, &view.mine);
        *members = members.iter().filter_map(|&place| stay.place(place)).collect();
    }

    /// True if other processes have the same result for the islands of this process. All processes must call it; one
    /// that has `failed` sends nothing.
    pub fn compare<C>(&self, clusters: &Clusters, view: &LocalParticles<C>, failed: bool) -> bool {
        let mut told: Vec<Vec<HotParticleDigest>> = vec![Vec::new(); self.communicator.size()];
        if !failed {
            let space = (&self.block(clusters.domain()), clusters.domain());
            clusters.tell(
                |place| view.is_mine(place),
                |middle| !self.blocks.is_deep(middle, space.0, self.lent()),
                |one, middle| self.for_each_borrower(middle, space, |rank| told[rank].push(one.clone())),
            );
        }
        let outgoing = told.iter().map(|told| if told.is_empty() { Vec::new() } else { packed(told) }).collect();
        let heard = self.communicator.exchange(outgoing);
        let heard = heard.iter().filter_map(|bytes| unpacked::<Vec<HotParticleDigest>>(bytes)).flatten();
        let heard = heard.filter_map(|one| Some((*view.strangers.get(&one.id)?, one))).collect();
        !failed && clusters.agree_with(|place| view.is_mine(place), heard)
    }

    /// Joint decision of all processes about a part, in a box whose longest edge is `size` [m].
    pub fn vote(&mut self, opinion: &LocalStatus, half_period: f64, size: f64) -> PartDecision {
        let LocalStatus { reach, room, failed, agrees } = *opinion;
        let flag = |set: bool| if set { 1.0 } else { 0.0 };
        let mut votes = [reach.flight, reach.around, reach.ball, -room, flag(failed), flag(!agrees)];
        self.communicator.largest(&mut votes);
        let [flight, around, ball, nearest, failed, differs] = votes;
        let reach = Reach { flight, around, ball };
        if failed > 0.0 || !reach.fits(half_period) {
            return PartDecision::Failed;
        }
        let missing = reach.sight() + nearest;
        let needed = self.width + missing;
        if missing > 0.0 {
            self.width = SPARE * needed;
            return PartDecision::Again;
        }
        if differs > 0.0 {
            // every process has seen all particles, so results cannot differ; a shorter part is another try
            if self.width > size {
                return PartDecision::Failed;
            }
            self.width = SPARE * (self.width + reach.sight());
            return PartDecision::Again;
        }
        self.width = (SPARE * needed).clamp(0.9 * self.width, self.width.max(SPARE * needed));
        PartDecision::Done
    }

    /// Region with the particles of this process.
    pub fn region(&self, domain: &Domain) -> Region {
        Region::around(domain, self.block(domain), 0.0)
    }

    fn is_mine(&self, x: &Vector3<f64>) -> bool {
        self.blocks.owner(x) == self.communicator.rank()
    }

    /// Corners [m] of the block of this process.
    fn block(&self, domain: &Domain) -> [Vector3<f64>; 2] {
        self.blocks.corners(self.communicator.rank(), domain)
    }

    /// Distance [m] from another block within which particles are lent: a little more than the other process relies on.
    fn lent(&self) -> f64 {
        self.width * (1.0 + 1e-9)
    }

    /// Calls `visit` with every other process that borrows a particle whose flight has its middle at `x`; `block` are
    /// the corners of the own block.
    fn for_each_borrower(
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

impl Reach {
    /// True if no particle can meet an image of another other than the nearest, which is at most half a period [m]
    /// away.
    pub fn fits(&self, half_period: f64) -> bool {
        self.ball + self.around.max(self.flight) <= half_period
    }
}

impl<C> LocalParticles<C> {
    /// True if the particle at an index is in the block of this process.
    pub fn is_mine(&self, place: u32) -> bool {
        self.mine[place as usize]
    }
}

/// New indices of particles after others have been removed.
struct Stay<'a> {
    /// Flags by old index: true for particles that stay.
    mine: &'a [bool],
    /// Number of particles that stay.
    count: u32,
    /// Old and new index of the last particles, which move into the gaps, in ascending order.
    moves: Vec<(u32, u32)>,
}

impl<'a> Stay<'a> {
    fn of(mine: &'a [bool]) -> Self {
        let count = mine.iter().filter(|mine| **mine).count();
        let (first, last) = mine.split_at(count);
        let holes = (0u32..).zip(first).filter(|(_, mine)| !**mine).map(|(place, _)| place);
        let movers = (count as u32..).zip(last).filter(|(_, mine)| **mine).map(|(place, _)| place);
        Self { mine, count: count as u32, moves: movers.zip(holes).collect() }
    }

    /// New index of a particle, by its old one, if it stays.
    fn place(&self, before: u32) -> Option<u32> {
        if !self.mine[before as usize] {
            return None;
        }
        if before < self.count {
            return Some(before);
        }
        let which = self.moves.binary_search_by_key(&before, |(from, _)| *from).ok()?;
        Some(self.moves[which].1)
    }
}

/// Keeps some of the particles, and carried state that involves them.
fn keep<'a, S: Solve>(solver: &S, work: &mut Work<S::Carried>, mine: &'a [bool]) -> Stay<'a> {
    let stay = Stay::of(mine);
    let (particles, id) = (&*work.particles, &work.particles.id);
    let overlap = |couple: Couple| Overlap {
        depth: couple.meet(particles, work.scene, FrameTime::default()).overlap(),
        diameter: couple.diameter(particles),
    };
    work.abroad.clear();
    let mut home = Vec::new();
    for carried in work.lasting.drain(..) {
        let of = S::places(&carried);
        let mut here = of.iter().flatten().filter_map(|&place| stay.place(place));
        match here.next() {
            Some(own) if of.iter().flatten().any(|&place| stay.place(place).is_none()) => {
                let overlap = solver.touching(&carried).map(overlap);
                work.abroad.push(CrossRankContact {
                    carried: S::moved(&carried, &|place| id[place as usize]),
                    own,
                    overlap,
                });
            }
            Some(_) => home.push(S::moved(&carried, &|place| stay.place(place).unwrap_or(place))),
            None => {}
        }
    }
    *work.lasting = home;
    work.particles.relocate(&stay.moves);
    work.particles.truncate(stay.count as usize);
    stay
}

/// Packs particles and carried state for sending: the length of the particle bytes, these bytes, then the carried
/// state.
fn pack<C: Serialize>(particles: &Particles, places: &[u32], lasting: &[C]) -> Vec<u8> {
    let mut bytes = vec![0; LENGTH];
    particles.pack(places, &mut bytes);
    let length = (bytes.len() - LENGTH) as u64;
    bytes[..LENGTH].copy_from_slice(&length.to_le_bytes());
    let lasting = packed(&lasting);
    bytes.reserve_exact(lasting.len());
    bytes.extend(lasting);
    bytes
}

/// Appends packed particles, and returns the carried state; `None`, with nothing appended, if the bytes are not of that
/// form.
pub fn take_aboard<C: DeserializeOwned>(bytes: &[u8], particles: &mut Particles) -> Option<Vec<C>> {
    let (length, rest) = bytes.split_first_chunk::<LENGTH>()?;
    let (of_particles, rest) = rest.split_at_checked(u64::from_le_bytes(*length) as usize)?;
    let (lasting, count) = (unpacked(rest)?, particles.len());
    if particles.unpack(of_particles).is_none() {
        particles.truncate(count);
    }
    Some(lasting)
}

/// Carried state with ids in place of indices.
fn ids_of<'a, S: Solve>(particles: &Particles, lasting: impl Iterator<Item = &'a S::Carried>) -> Vec<S::Carried>
where
    S::Carried: 'a,
{
    lasting.map(|carried| S::moved(carried, &|place| particles.id[place as usize])).collect()
}

fn packed<T: Serialize>(value: &T) -> Vec<u8> {
    postcard::to_stdvec(value).unwrap_or_default()
}

fn unpacked<T: DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    postcard::from_bytes(bytes).ok()
}
