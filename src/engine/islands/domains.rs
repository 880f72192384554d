//! One run cut into domains: each process has the particles of a block of the box, and borrows for each part of a window those of the
//! others that its own may have to do with.
//!
//! A process looks at its particles and the borrowed ones as if there were nobody else, and solves all islands that it sees whole,
//! also those that others own: so nothing has to be sent back. What it found out about particles that others have borrowed from it, it
//! tells them; where two processes do not agree on who belongs to an island, or where an island reaches beyond what its owner has borrowed,
//! all borrow from farther away and do the part again.

use super::blocks::Blocks;
use super::cluster::{Clusters, Told};
use super::search::Spot;
use super::{Solve, in_order};
use crate::communicator::Communicator;
use crate::domain::Domain;
use crate::engine::driver::{Abroad, Work};
use crate::engine::population::Population;
use crate::exact::ExactSum;
use crate::neighbours::region::Region;
use crate::particles::Particles;
use nalgebra::Vector3;
use rustc_hash::FxHashMap;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::sync::Arc;

/// [-] borrowed from farther away than was needed in the part before by this factor: a part that has to be done again costs more than what is borrowed in
/// vain.
const SPARE: f64 = 1.25;

/// One run cut into domains.
pub struct Domains {
    communicator: Arc<dyn Communicator>,
    /// Which block is whose.
    blocks: Blocks,
    /// [m] from how far away particles are borrowed.
    width: f64,
    /// Whether the store holds the particles of one block only.
    pub is_cut: bool,
    /// All particles of the run in a few numbers.
    pub population: Arc<Population>,
}

/// The particles that a process sees in a part of a window: its own and those that it has borrowed.
pub struct View<C> {
    /// Whether each, by place, is its own.
    mine: Vec<bool>,
    /// How many it had when the part began.
    count: usize,
    /// What lasted then, among its own and between one of them and another's.
    lasting: (Vec<C>, Vec<Abroad<C>>),
    /// Places of those that are not its own, by id.
    strangers: FxHashMap<u32, u32>,
    /// Whether everybody came whom something lasts with.
    pub complete: bool,
    /// Where they all are.
    pub region: Region,
}

/// What travels between processes. Places are ids.
struct Cargo<C> {
    particles: Particles,
    lasting: Vec<C>,
}

impl<C> Default for Cargo<C> {
    fn default() -> Self {
        Self { particles: Particles::default(), lasting: Vec::new() }
    }
}

impl<C> Cargo<C> {
    /// Copies of the particles at those places, and of what lasts.
    fn of<'a, S: Solve<Carried = C>>(all: &Particles, places: &[u32], lasting: impl Iterator<Item = &'a C>) -> Self
    where
        C: 'a,
    {
        let mut particles = Particles::default();
        particles.copy_from(all, places);
        let lasting = lasting.map(|carried| S::moved(carried, &|place| all.id[place as usize])).collect();
        Self { particles, lasting }
    }
}

impl<C: Serialize + DeserializeOwned> Cargo<C> {
    /// As bytes: those of the particles behind their length, and what lasts.
    fn packed(&self) -> Vec<u8> {
        let particles = self.particles.packed();
        let mut bytes = (particles.len() as u64).to_le_bytes().to_vec();
        bytes.extend(particles);
        bytes.extend(packed(&self.lasting));
        bytes
    }

    /// From bytes; `None` if these are not of one.
    fn unpacked(bytes: &[u8]) -> Option<Self> {
        let (length, rest) = bytes.split_first_chunk()?;
        let (of_particles, rest) = rest.split_at_checked(u64::from_le_bytes(*length) as usize)?;
        let mut particles = Particles::default();
        particles.unpack(of_particles)?;
        Some(Self { particles, lasting: unpacked(rest)? })
    }
}

/// What all processes make of a part that they have tried.
pub enum Verdict {
    /// It is done.
    Done,
    /// It is to be done again, with what is farther away.
    Again,
    /// Islands grow too large, or an engine failed.
    Failed,
}

/// What one process makes of it.
pub struct Opinion {
    /// [m] how far flights and islands reach.
    pub reach: Reach,
    /// [m] from the islands of its own particles to the end of what it sees, at least.
    pub room: f64,
    /// Whether islands grow too large, or the engine failed.
    pub failed: bool,
    /// Whether others have found the same.
    pub agrees: bool,
}

/// How far flights and islands reach [m].
#[derive(Clone, Copy, Debug, Default)]
pub struct Reach {
    /// The largest reach of a flight.
    pub flight: f64,
    /// The largest reach of a hot particle about the middle of its flight.
    pub around: f64,
    /// The largest radius of the ball of a hot particle.
    pub ball: f64,
}

impl Reach {
    /// [m] how far around an island one must see to know what it has to do with: whose flights or balls may meet it, and whether
    /// those are hot.
    pub fn sight(&self) -> f64 {
        self.around.max(self.flight) + 2.0 * self.flight
    }
}

impl Domains {
    /// Of a box shared by those processes.
    pub fn new(communicator: Arc<dyn Communicator>, population: Population) -> Self {
        Self { communicator, blocks: Blocks::default(), width: 0.0, is_cut: false, population: Arc::new(population) }
    }

    /// What the lead knows.
    pub fn of_lead<T: Serialize + DeserializeOwned>(&self, value: T) -> T {
        unpacked(&self.communicator.broadcast(packed(&value))).unwrap_or(value)
    }

    /// Whether this process is the lead.
    pub fn is_lead(&self) -> bool {
        self.communicator.is_lead()
    }

    /// Adds up over all processes, if each has particles of its own.
    pub fn total(&self, sums: &mut [ExactSum]) {
        if self.is_cut {
            let mut words: Vec<i64> = sums.iter_mut().flat_map(|sum| sum.words().to_vec()).collect();
            self.communicator.sum(&mut words);
            let mut words = words.as_slice();
            for sum in sums {
                let (own, rest) = words.split_at(sum.words().len());
                sum.words().copy_from_slice(own);
                words = rest;
            }
        }
    }

    /// Adds up counts over all processes.
    pub fn count(&self, counts: &mut [i64]) {
        self.communicator.sum(counts);
    }

    /// The largest of all processes, if each has particles of its own.
    pub fn largest(&self, values: &mut [f64]) {
        if self.is_cut {
            self.communicator.largest(values);
        }
    }

    /// Gives each process the particles of its block, which the lead has, and what lasts between one of them and another.
    pub fn cut<S: Solve>(&mut self, work: &mut Work<S::Carried>) {
        let (domain, size) = (&work.scene.domain, self.communicator.size());
        work.particles.wrap(domain);
        self.blocks = self.of_lead(Blocks::of(&work.particles.position, size, domain));
        let owners: Vec<usize> = work.particles.position.iter().map(|x| self.blocks.owner(x)).collect();
        let cargo = |rank: usize| {
            let is_theirs = |place: &u32| owners[*place as usize] == rank;
            let places: Vec<u32> = (0..work.particles.len() as u32).filter(is_theirs).collect();
            let lasting = work.lasting.iter().filter(|carried| S::places(carried).iter().flatten().any(is_theirs));
            Cargo::of::<S>(work.particles, &places, lasting).packed()
        };
        let outgoing =
            (0..size).map(|rank| if self.communicator.is_lead() { cargo(rank) } else { Vec::new() }).collect();
        let incoming = self.communicator.exchange(outgoing);
        work.particles.clear();
        work.lasting.clear();
        work.abroad.clear();
        let Cargo { particles, lasting } =
            incoming.first().and_then(|bytes| Cargo::unpacked(bytes)).unwrap_or_default();
        let places: FxHashMap<u32, u32> = particles.id.iter().copied().zip(0..).collect();
        *work.particles = particles;
        for carried in lasting {
            let here: Vec<Option<u32>> =
                S::places(&carried).iter().flatten().map(|id| places.get(id).copied()).collect();
            match here.iter().flatten().next() {
                Some(&own) if here.iter().any(Option::is_none) => work.abroad.push(Abroad { carried, own }),
                Some(_) => work.lasting.push(S::moved(&carried, &|id| places.get(&id).copied().unwrap_or(id))),
                None => {}
            }
        }
        self.is_cut = true;
    }

    /// Gives all particles to the lead. `members`, by place, are followed.
    pub fn assemble<S: Solve>(&mut self, solver: &S, work: &mut Work<S::Carried>, members: &mut Vec<u32>) {
        let id = &work.particles.id;
        let ids: Vec<u32> = members.iter().map(|&place| id[place as usize]).collect();
        let home = work.lasting.iter().map(|carried| S::moved(carried, &|place| id[place as usize]));
        let lasting = home.chain(work.abroad.iter().map(|abroad| abroad.carried)).collect();
        let own = Cargo { particles: std::mem::take(work.particles), lasting };
        work.lasting.clear();
        work.abroad.clear();
        members.clear();
        let mut all_ids = Vec::new();
        let ids = self.communicator.collect(packed(&ids));
        for (bytes, ids) in self.communicator.collect(own.packed()).iter().zip(ids) {
            let Some(cargo) = Cargo::<S::Carried>::unpacked(bytes) else { continue };
            let ids: Vec<u32> = unpacked(&ids).unwrap_or_default();
            take_aboard(work.particles, &cargo.particles);
            work.lasting.extend(cargo.lasting);
            all_ids.extend(ids);
        }
        let mut place_of = vec![0; work.particles.id.iter().map(|&id| id as usize + 1).max().unwrap_or(0)];
        for (place, &id) in (0u32..).zip(&work.particles.id) {
            place_of[id as usize] = place;
        }
        for carried in work.lasting.iter_mut() {
            *carried = S::moved(carried, &|id| place_of[id as usize]);
        }
        in_order(solver, work);
        members.extend(all_ids.iter().map(|&id| place_of[id as usize]));
        self.is_cut = false;
    }

    /// Gives particles that have left the block to those whose they are, and borrows those whose flights of `part` [s], seen from `frame`
    /// [m/s], come near. `flight` [m] is the largest reach of a flight.
    pub fn trade<S: Solve>(
        &mut self,
        work: &mut Work<S::Carried>,
        (frame, part): (Vector3<f64>, f64),
        flight: f64,
    ) -> View<S::Carried> {
        // partners of one's own and theirs must be seen
        self.width = self.width.max(4.0 * flight);
        let (domain, size) = (&work.scene.domain, self.communicator.size());
        let block = self.block(domain);
        let mut places: Vec<Vec<u32>> = vec![Vec::new(); size];
        let mut mine = Vec::with_capacity(work.particles.len());
        for place in 0..work.particles.len() {
            let owner = self.blocks.owner(&work.particles.position[place]);
            mine.push(owner == self.communicator.rank());
            let middle = Spot::of(work.particles, place, domain, frame, part).middle;
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
            let mut cargo = Cargo::of::<S>(work.particles, places, home);
            let abroad = work.abroad.iter().filter(|abroad| goes(&abroad.own));
            cargo.lasting.extend(abroad.map(|abroad| abroad.carried));
            cargo.packed()
        };
        let outgoing = places.iter().map(cargo).collect();
        let (count, before) = (work.particles.len(), (work.lasting.clone(), work.abroad.clone()));
        let leavers = (0u32..).zip(&mine).filter(|(_, mine)| !**mine);
        let mut strangers: FxHashMap<u32, u32> =
            leavers.map(|(place, _)| (work.particles.id[place as usize], place)).collect();
        let mut lasting = Vec::new();
        for bytes in self.communicator.exchange(outgoing) {
            let Some(cargo) = Cargo::<S::Carried>::unpacked(&bytes) else { continue };
            let first = work.particles.len();
            take_aboard(work.particles, &cargo.particles);
            mine.extend(cargo.particles.position.iter().map(|x| self.is_mine(x)));
            strangers.extend((first as u32..).zip(&cargo.particles.id).map(|(place, &id)| (id, place)));
            lasting.extend(cargo.lasting);
        }
        let mut agrees = true;
        for Abroad { carried, own } in work.abroad.drain(..) {
            let id = work.particles.id[own as usize];
            let place = |other: u32| if other == id { Some(own) } else { strangers.get(&other).copied() };
            // whoever touches it comes within reach of it
            agrees &= S::places(&carried).iter().flatten().all(|id| place(*id).is_some());
            work.lasting.push(S::moved(&carried, &|id| place(id).unwrap_or(own)));
        }
        // what lasts of one's own particles is known already
        for carried in lasting {
            if S::places(&carried).iter().flatten().all(|id| strangers.contains_key(id)) {
                work.lasting.push(S::moved(&carried, &|id| strangers.get(&id).copied().unwrap_or(id)));
            }
        }
        strangers.retain(|_, place| !mine[*place as usize]);
        let region = Region::around(domain, block, self.width);
        View { mine, count, lasting: before, strangers, complete: agrees, region }
    }

    /// Gives back what was borrowed: everything is as it was before.
    pub fn give_back<C>(&self, work: &mut Work<C>, view: View<C>) {
        work.particles.truncate(view.count);
        (*work.lasting, *work.abroad) = view.lasting;
    }

    /// Keeps what is its own after a part that is done.
    pub fn keep<S: Solve>(&self, work: &mut Work<S::Carried>, view: View<S::Carried>, members: &mut Vec<u32>) {
        let mut places = Vec::with_capacity(view.mine.len());
        let mut next = 0;
        for &mine in &view.mine {
            places.push(next);
            next += u32::from(mine);
        }
        members.retain(|&place| view.mine[place as usize]);
        members.iter_mut().for_each(|place| *place = places[*place as usize]);
        keep::<S>(work, &view.mine);
    }

    /// Whether the others have found the same about the islands of this process. All must call it; who has `failed` has nothing to tell.
    pub fn compare<C>(&self, clusters: &Clusters, view: &View<C>, failed: bool) -> bool {
        let mut told: Vec<Vec<Told>> = vec![Vec::new(); self.communicator.size()];
        if !failed {
            let block = self.block(clusters.domain());
            clusters.tell(
                |place| view.is_mine(place),
                |one, middle| {
                    self.for_each_borrower(middle, (&block, clusters.domain()), |rank| told[rank].push(one));
                },
            );
        }
        let outgoing = told.iter().map(|told| if told.is_empty() { Vec::new() } else { packed(told) }).collect();
        let heard = self.communicator.exchange(outgoing);
        let heard = heard.iter().filter_map(|bytes| unpacked::<Vec<Told>>(bytes)).flatten();
        let heard = heard.filter_map(|one| Some((*view.strangers.get(&one.id)?, one))).collect();
        !failed && clusters.agree_with(|place| view.is_mine(place), heard)
    }

    /// What all make of a part, in a box whose longest edge is `size` [m].
    pub fn vote(&mut self, opinion: &Opinion, half_period: f64, size: f64) -> Verdict {
        let Opinion { reach, room, failed, agrees } = *opinion;
        let flag = |set: bool| if set { 1.0 } else { 0.0 };
        let mut votes = [reach.flight, reach.around, reach.ball, -room, flag(failed), flag(!agrees)];
        self.communicator.largest(&mut votes);
        let [flight, around, ball, nearest, failed, differs] = votes;
        let reach = Reach { flight, around, ball };
        if failed > 0.0 || !reach.fits(half_period) {
            return Verdict::Failed;
        }
        let missing = reach.sight() + nearest;
        let needed = self.width + missing;
        if missing > 0.0 {
            self.width = SPARE * needed;
            return Verdict::Again;
        }
        if differs > 0.0 {
            // everybody has seen everything: no two may differ, and a shorter part is another try
            if self.width > size {
                return Verdict::Failed;
            }
            self.width = SPARE * (self.width + reach.sight());
            return Verdict::Again;
        }
        self.width = (SPARE * needed).clamp(0.9 * self.width, self.width.max(SPARE * needed));
        Verdict::Done
    }

    /// Where the particles of this process are.
    pub fn region(&self, domain: &Domain) -> Region {
        Region::around(domain, self.block(domain), 0.0)
    }

    fn is_mine(&self, x: &Vector3<f64>) -> bool {
        self.blocks.owner(x) == self.communicator.rank()
    }

    /// [m] the corners of the block of this process.
    fn block(&self, domain: &Domain) -> [Vector3<f64>; 2] {
        self.blocks.corners(self.communicator.rank(), domain)
    }

    /// Calls `visit` with every other process that borrows what flies about `x`; `block` are the corners of the own one.
    fn for_each_borrower(
        &self,
        x: &Vector3<f64>,
        (block, domain): (&[Vector3<f64>; 2], &Domain),
        mut visit: impl FnMut(usize),
    ) {
        // a little farther than others count on
        let width = self.width * (1.0 + 1e-9);
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
    /// Whether nobody can meet a further image of somebody than the nearest, which is at most half a period [m] away.
    pub fn fits(&self, half_period: f64) -> bool {
        self.ball + self.around.max(self.flight) <= half_period
    }
}

impl<C> View<C> {
    /// Whether the particle at a place is of the block of this process.
    pub fn is_mine(&self, place: u32) -> bool {
        self.mine[place as usize]
    }
}

/// Keeps some of the particles, and what lasts between one of them and another.
fn keep<S: Solve>(work: &mut Work<S::Carried>, mine: &[bool]) {
    let places: Vec<u32> = (0u32..).zip(mine).filter(|(_, mine)| **mine).map(|(place, _)| place).collect();
    let new_place = |place: u32| places.binary_search(&place).ok().map(|place| place as u32);
    let id = &work.particles.id;
    work.abroad.clear();
    let mut home = Vec::new();
    for carried in work.lasting.drain(..) {
        let of = S::places(&carried);
        let mut here = of.iter().flatten().filter_map(|&place| new_place(place));
        match here.next() {
            Some(own) if of.iter().flatten().any(|&place| new_place(place).is_none()) => {
                work.abroad.push(Abroad { carried: S::moved(&carried, &|place| id[place as usize]), own });
            }
            Some(_) => home.push(S::moved(&carried, &|place| new_place(place).unwrap_or(place))),
            None => {}
        }
    }
    *work.lasting = home;
    work.particles.reorder(&places);
}

fn take_aboard(particles: &mut Particles, others: &Particles) {
    particles.copy_from(others, &(0..others.len() as u32).collect::<Vec<u32>>());
}

fn packed<T: Serialize>(value: &T) -> Vec<u8> {
    postcard::to_stdvec(value).unwrap_or_default()
}

fn unpacked<T: DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    postcard::from_bytes(bytes).ok()
}
