//! Contacts in progress: forces, records and dissipated energy. Each contact belongs to a slot: the number of a
//! candidate (pair, or particle and wall) in the neighbour list. A window is the time between two exchanges with the
//! gas.

use super::block::{BlockScratch, ContactBlock, ForceEvaluation};
use super::contact::{Alike, Contact, ContactForce, ContactState, TouchingPair, first_named};
use super::contact_sums::{ContactRows, ContactSums};
use super::force_buffer::ForceBuffer;
use super::rates::Rates;
use crate::contact_law::ContactLaw;
use crate::domain::Domain;
use crate::encounter::{Couple, FrameTime};
use crate::engine::Failure;
use crate::engine::distributed::GhostExchange;
use crate::neighbours::{NeighbourList, Pair};
use crate::particles::{CHUNK, Particles};
use crate::record::{Between, FrictionLosses, Impact, Log, Record};
use crate::scene::{Kind, Scene};
use crate::work_sharing;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Log and record to which time steps add energies, momenta and impacts.
pub struct StepRecord<'a> {
    /// Log of energies, momenta and impacts. The log of a crowd (large group of particles that is moved separately) may
    /// be discarded, because the crowd is then moved again.
    pub log: &'a mut Log,
    /// Record that counts impacts when they end, so that the impacts of a whole window need no memory. `None` if the
    /// impacts may still be discarded; they are then stored in `log`.
    pub record: Option<&'a mut Record>,
}

impl StepRecord<'_> {
    /// Shifts the particles of a sheared box by whole periods into the box. Adds the changes of energy and momentum at
    /// its sheared sides to the sums (ledger) in the log. Boxes without shear are not changed.
    pub fn cross(&mut self, particles: &mut Particles, domain: &Domain) {
        if domain.shear.is_some() {
            self.log.ledger += particles.wrap(domain);
        }
    }

    /// Moves all impacts from `impacts` to the record, or to the log if there is no record.
    fn take(&mut self, impacts: &mut Vec<(Between, Impact)>) {
        match &mut self.record {
            Some(record) => record.count(impacts),
            None => self.log.impacts.append(impacts),
        }
    }
}

/// Time of a force evaluation, and the time for which its forces act. All times in s.
#[derive(Clone, Copy, Debug)]
pub struct EvaluationTime {
    /// [s] simulated time at the start of the window.
    pub start: f64,
    /// [s] time from the start of the window to the instant of the positions.
    pub elapsed: f64,
    /// [s] time from the evaluation to the end of the window.
    pub remaining: f64,
    /// [s] length of the time step.
    pub dt: f64,
    /// [s] time since the last evaluation, during which touching surfaces have slipped.
    pub shear_time: f64,
    /// [s] time from the start of the window to the instant of the velocities. The velocities do not yet contain
    /// gravity over this time.
    pub fall: f64,
    /// [s] time from the instant to which the stored velocities belong, to the middle of the kick (change of velocities
    /// by forces). Powers are computed for that middle.
    pub to_middle: f64,
    /// [-] fraction of the time step for which these forces act in the kick (change of velocities) that follows. It is
    /// 0 if that kick is recorded by `record_half_kick`.
    pub weight: f64,
    /// True if this evaluation of forces also finds the contacts that begin or end. False in the second of the two
    /// evaluations of Heun's method, at the end of a step, since its positions are only predicted.
    pub opens: bool,
    /// True if the neighbour list's bound on the distance that particles have moved holds for the present positions, as
    /// in Verlet's method. False for Heun's method.
    pub travel_is_exact: bool,
    /// True if the second half of the kick (change of velocities) by these forces is applied at the start of the next
    /// window.
    pub leaves_half: bool,
}

impl EvaluationTime {
    /// Time of the positions and of the velocities. In Verlet's method velocities are half a step earlier than
    /// positions.
    #[inline(always)]
    pub fn moment(&self) -> FrameTime {
        FrameTime::lagging(self.fall, self.elapsed - self.fall)
    }
}

/// Particles, scene and neighbour list in which contacts are searched, and the time of the search.
#[derive(Clone, Copy)]
pub struct ContactSearch<'a> {
    /// Neighbour list with the pairs and walls that may overlap.
    pub list: &'a NeighbourList,
    /// Positions and velocities of the particles.
    pub particles: &'a Particles,
    /// Walls, surfaces and gravity.
    pub scene: &'a Scene,
    /// Instants of the positions and of the velocities from which forces are computed, and the time step for which
    /// these forces act.
    pub at: EvaluationTime,
    /// True for each particle, by index, that this process owns, if several processes share a run; `None` if this
    /// process owns all particles.
    pub mine: Option<&'a [bool]>,
    /// Mass, species and contact constants that all particles share; `None` if particles differ.
    pub alike: Option<&'a Alike>,
}

impl ContactSearch<'_> {
    /// True if this process counts the contact, because it owns the first of the two bodies.
    #[inline(always)]
    pub fn counts(&self, couple: &Couple) -> bool {
        self.mine.is_none_or(|mine| mine[couple.i as usize])
    }

    /// Contact constants of two bodies that touch, under the law `law`.
    pub fn touching(&self, couple: Couple, law: &ContactLaw) -> TouchingPair {
        match self.alike {
            Some(alike) if !couple.is_wall() => alike.touching(couple),
            _ => TouchingPair::new(couple, self.particles, self.scene, law),
        }
    }

    /// Species of the particle of `couple`, and kind (species or wall) of the second body.
    pub fn kinds(&self, couple: &Couple) -> (u16, Kind) {
        match self.alike {
            Some(alike) if !couple.is_wall() => alike.kinds(),
            _ => couple.kinds(self.particles),
        }
    }
}

/// All contacts of a scene with soft spheres, for uniform steps of all particles.
pub struct Contacts {
    law: ContactLaw,
    /// Contacts in blocks, each for a range of candidates in the neighbour list. If there are blocks, they contain all
    /// contacts, and `lasting` and `foreseen` are empty.
    blocks: Vec<ContactBlock>,
    /// Contacts in progress, in the order of the neighbour list.
    lasting: Vec<Contact>,
    /// Contacts that began in the state last predicted by Heun's method, in the order of the neighbour list.
    foreseen: Vec<Contact>,
    /// [J] elastic energy stored in all contacts; computed only for Heun's method, otherwise 0.
    elastic_energy: f64,
    /// Powers and wall forces of the last kick (change of velocities by forces). The second half of this kick is
    /// applied and recorded in the next window.
    rates: Rates,
    /// [W] parts of the friction power of the last kick (change of velocities by forces), by cause.
    losses: FrictionLosses,
    /// Sums of powers and forces over all steps since the sums were last recorded.
    total: ContactSums,
    /// Working memory of an evaluation, used if there is a single block.
    scratch: BlockScratch,
}

/// State that the last force evaluation of a window passes to the first one of the next window.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Due {
    /// Contacts that began in the state last predicted by Heun's method, in the order of the neighbour list. Their
    /// forces have already acted, so their speed of approach is that of the predicted state.
    foreseen: Vec<Contact>,
    /// [J] elastic energy stored in all contacts; computed only for Heun's method, otherwise 0.
    elastic_energy: f64,
    /// Powers and wall forces of the last kick (change of velocities by forces), whose second half is recorded in the
    /// next window.
    rates: Rates,
    /// [W] parts of the friction power of the last kick (change of velocities by forces), by cause.
    losses: FrictionLosses,
}

/// Number of slots (candidates of the neighbour list) per block, the unit of parallel work.
fn block_size(list: &NeighbourList) -> usize {
    let slots = list.slots();
    if slots <= 2 * CHUNK { slots.max(1) } else { CHUNK }
}

/// Divides the slots (candidates) of a neighbour list into blocks without contacts. All contacts of one particle with
/// one wall are in one block.
fn blocks(list: &NeighbourList) -> Vec<ContactBlock> {
    let (slots, size) = (list.slots(), block_size(list));
    let border = |k: usize| {
        let parts = |slot: &usize| *slot > 0 && *slot < slots && list.couple(*slot).is_further();
        (k * size..).find(|slot| !parts(slot)).unwrap_or(slots).min(slots)
    };
    (0..slots.div_ceil(size).max(1)).map(|k| ContactBlock::of(border(k)..border(k + 1))).collect()
}

/// Block of contacts that contains the slot `slot` (candidate of the neighbour list). Blocks have about `size` slots;
/// their borders may be moved to later slots.
fn block_of(blocks: &mut [ContactBlock], slot: u32, size: usize) -> &mut ContactBlock {
    let k = slot as usize / size;
    let is_before = blocks[k].begins_after(slot);
    &mut blocks[k - usize::from(is_before)]
}

impl Contacts {
    pub fn new(law: ContactLaw) -> Self {
        Self {
            law,
            blocks: Vec::new(),
            lasting: Vec::new(),
            foreseen: Vec::new(),
            elastic_energy: 0.0,
            rates: Rates::default(),
            losses: FrictionLosses::default(),
            total: ContactSums::default(),
            scratch: BlockScratch::default(),
        }
    }

    pub fn elastic_energy(&self) -> f64 {
        self.elastic_energy
    }

    /// Returns the state that the last force evaluation passes to the next one, for storage.
    pub fn due(&self) -> Due {
        let mut foreseen = self.foreseen.clone();
        foreseen.extend(self.blocks.iter().flat_map(ContactBlock::foreseen));
        Due { foreseen, elastic_energy: self.elastic_energy, rates: self.rates, losses: self.losses }
    }

    /// Continues from the stored state `due`, which [`due`](Self::due) returned.
    pub fn resume(&mut self, due: Due) {
        (self.foreseen, self.elastic_energy) = (due.foreseen, due.elastic_energy);
        (self.rates, self.losses) = (due.rates, due.losses);
    }

    /// Begins a contact for every overlap at simulated time `now` [s], the start of a run.
    pub fn find(&mut self, list: &NeighbourList, particles: &Particles, scene: &Scene, now: f64) {
        self.gather(list);
        let mut slots = Vec::new();
        list.overlapping(particles, scene, &mut slots);
        for &slot in &slots {
            let mut touch = TouchingPair::new(list.couple(slot as usize), particles, scene, &self.law);
            let met = touch.couple.meet(particles, scene, FrameTime::default());
            let (overlap, growth) = (met.overlap(), -met.normal_velocity);
            touch.begin_at(growth, (particles, scene), &self.law);
            let begun = ContactState::beginning(now, growth, &touch, scene, &self.law);
            let course = ContactState { first_overlap: overlap, maximum_overlap: overlap, overlap, growth, ..begun };
            self.lasting.push(Contact { slot, touch, course });
        }
    }

    /// Removes and returns the contacts in progress. The sums for the second half of the last kick (change of
    /// velocities by forces) are kept, because the caller may put the contacts back unchanged.
    pub fn take(&mut self, list: &NeighbourList) -> Vec<Contact> {
        self.gather(list);
        std::mem::take(&mut self.lasting)
    }

    /// Calls `visit` for each contact in progress, in the order of the neighbour list.
    pub fn for_each(&self, list: &NeighbourList, visit: &mut dyn FnMut(Contact)) {
        self.lasting.iter().copied().for_each(&mut *visit);
        self.blocks.iter().flat_map(|block| block.contacts(block.couples(list))).for_each(visit);
    }

    /// Makes the next evaluation test all slots (candidates) of the neighbour list, as after a restart from a stored
    /// run. The counts of work are then the same in a restarted run as in an uninterrupted one.
    pub fn look_anew(&mut self) {
        self.blocks.iter_mut().for_each(ContactBlock::look_anew);
    }

    /// Discards the sums for the second half of the last kick (change of velocities by forces). The sums are not needed
    /// if particles have been moved in islands (groups) since then, or if another process records the sums.
    pub fn forget(&mut self) {
        self.elastic_energy = 0.0;
        (self.rates, self.losses) = (Rates::default(), FrictionLosses::default());
    }

    /// Replaces the contacts in progress by `contacts`. Their slots must be valid in the present neighbour list,
    /// unless the list is rebuilt before the next evaluation.
    pub fn put(&mut self, contacts: Vec<Contact>) {
        self.keep_foreseen();
        self.lasting = contacts;
    }

    /// Moves all contacts from the blocks (ranges of the neighbour list) to `lasting` and `foreseen`, and removes the
    /// blocks.
    fn gather(&mut self, list: &NeighbourList) {
        // saves memory: the list does not grow by doubling, and each block is freed before the next one is read
        self.lasting.reserve_exact(self.blocks.iter().map(ContactBlock::count).sum());
        for block in std::mem::take(&mut self.blocks) {
            self.foreseen.extend(block.foreseen());
            self.lasting.extend(block.contacts(block.couples(list)));
        }
    }

    /// Removes the blocks (ranges of the neighbour list). Moves only their contacts that began in a predicted state to
    /// `foreseen`.
    fn keep_foreseen(&mut self) {
        for block in std::mem::take(&mut self.blocks) {
            self.foreseen.extend(block.foreseen());
        }
    }

    /// Moves the contacts from `lasting` and `foreseen` to new blocks (ranges of candidates) of the neighbour list.
    fn spread(&mut self, list: &NeighbourList) {
        let size = block_size(list);
        self.blocks = blocks(list);
        for contact in std::mem::take(&mut self.lasting) {
            block_of(&mut self.blocks, contact.slot, size).put(&contact, list);
        }
        for contact in std::mem::take(&mut self.foreseen) {
            block_of(&mut self.blocks, contact.slot, size).put_foreseen(contact);
        }
    }

    /// Frees memory that the next neighbour list does not need, because building that list requires much memory.
    /// Returns the two bodies of each contact, since slots (numbers of candidates) are valid only in the present list.
    pub fn shed(&mut self, list: &NeighbourList) -> impl Iterator<Item = Couple> + use<> {
        self.blocks.iter_mut().for_each(ContactBlock::shed);
        // saves memory: the list does not grow by doubling, and pairs, which come first, take half the memory of
        // couples
        let mut pairs = Vec::with_capacity(self.blocks.iter().map(ContactBlock::count).sum());
        let mut at_walls = Vec::new();
        for couple in self.blocks.iter().flat_map(|block| block.couples(list)) {
            match couple.j() {
                Some(j) => pairs.push(Pair { i: couple.i, j }),
                None => at_walls.push(couple),
            }
        }
        pairs.into_iter().map(|pair| Couple::pair(pair.i, pair.j)).chain(at_walls)
    }

    /// Applies a new order of the particle store and a new neighbour list. The particle that was at index `p` is now at
    /// `index_of[p]`. `couples` are the couples of the contacts in blocks, with the old indices.
    pub fn reorder(&mut self, index_of: &[u32], mut couples: impl Iterator<Item = Couple>, list: &NeighbourList) {
        let follow = |contact: &mut Contact| {
            contact.touch.couple = contact.touch.couple.moved(|index| index_of[index as usize]);
            let slot = list.slot(&contact.touch.couple);
            contact.slot = slot.map_or(contact.slot, |slot| slot as u32);
            slot.is_some()
        };
        if !self.blocks.is_empty() {
            // contacts are moved block by block, because one list of all contacts would double the memory
            let (size, mut anew) = (block_size(list), blocks(list));
            for block in std::mem::take(&mut self.blocks) {
                let followed = |mut contact: Contact| follow(&mut contact).then_some(contact);
                for contact in block.contacts(&mut couples).filter_map(followed) {
                    block_of(&mut anew, contact.slot, size).put(&contact, list);
                }
                for contact in block.foreseen().iter().copied().filter_map(followed) {
                    block_of(&mut anew, contact.slot, size).put_foreseen(contact);
                }
            }
            work_sharing::for_each(anew.chunks_mut(8), |blocks| blocks.iter_mut().for_each(ContactBlock::sort));
            self.blocks = anew;
            return;
        }
        for contacts in [&mut self.lasting, &mut self.foreseen] {
            contacts.retain_mut(follow);
            contacts.sort_unstable_by_key(|contact| contact.slot);
            // two processes may have sent copies of one contact
            contacts.dedup_by_key(|contact| contact.slot);
        }
    }

    /// Finds overlaps, begins and ends contacts, and writes the contact forces into `pushes`. Impacts that have ended
    /// are added to `book`. Returns counts of the work done, or an error if an overlap is too large or a centre has
    /// passed the other body.
    pub fn evaluate(
        &mut self,
        view: ContactSearch,
        pushes: &mut Vec<ForceBuffer>,
        book: &mut StepRecord,
    ) -> Result<ForceEvaluation, Failure> {
        if self.blocks.is_empty() {
            self.spread(view.list);
        }
        // the memory of the last forces is used again
        pushes.resize_with(self.blocks.len(), ForceBuffer::default);
        let law = &self.law;
        let each = |scratch: &mut BlockScratch, (block, pushes): (&mut ContactBlock, &mut ForceBuffer)| {
            std::mem::swap(&mut block.pushes, pushes);
            block.evaluate(view, law, scratch);
            std::mem::swap(&mut block.pushes, pushes);
        };
        if self.blocks.len() > 1 {
            work_sharing::for_each_with(self.blocks.iter_mut().zip(pushes), BlockScratch::default, each);
        } else {
            self.blocks.iter_mut().zip(pushes).for_each(|both| each(&mut self.scratch, both));
        }
        for block in &mut self.blocks {
            book.take(&mut block.ended);
        }
        let failures = self.blocks.iter_mut().filter_map(|block| block.sums.failure.take());
        if let Some(failure) = failures.fold(None, |first, failure| Some(first_named(first, failure))) {
            return Err(failure);
        }
        let (mut elastic_energy, mut done) = (0.0, ForceEvaluation::default());
        for ContactBlock { sums, .. } in &self.blocks {
            elastic_energy += sums.elastic_energy;
            done.forces += sums.done.forces;
            done.checks += sums.done.checks;
        }
        self.elastic_energy = elastic_energy;
        Ok(done)
    }

    /// Slots (candidates of the neighbour list) at which a contact with a rough wall begins at the present positions,
    /// in ascending order.
    pub fn begun_at_rough_walls(&mut self, view: ContactSearch) -> Vec<u32> {
        if self.blocks.is_empty() {
            self.spread(view.list);
        }
        let mut slots = Vec::new();
        self.blocks.iter().for_each(|block| block.find_begun_at_rough_walls(view, &mut slots));
        slots
    }

    /// Stores the rotation vector `turn` [rad] for the contact that begins at the slot `slot` (candidate of the
    /// neighbour list) in the next evaluation.
    pub fn meet_facet(&mut self, slot: u32, turn: Vector3<f64>, list: &NeighbourList) {
        block_of(&mut self.blocks, slot, block_size(list)).facets.begin(slot, turn);
    }

    /// Removes and returns the couples and rotation vectors [rad] of those contacts with rough walls that ended in the
    /// last evaluation, or that were expected to begin and did not.
    pub fn left_facets(&mut self, list: &NeighbourList) -> Vec<(Couple, Vector3<f64>)> {
        let mut left = Vec::new();
        self.blocks.iter_mut().for_each(|block| block.take_left_facets(list, &mut left));
        left
    }

    /// Adds to the sums the force of a rough wall that acts for one time step. `at` contains the scene, and the time
    /// [s] from the action of the force to the end of the window.
    pub fn count_turn(&mut self, couple: &Couple, force: &ContactForce, at: (&Scene, f64)) {
        let (mut row, mut few) = (ContactRows::default(), ContactRows::default());
        row.add(couple, force, at, &mut few);
        row.leave(&mut few);
        self.total.add(&few, 1.0);
    }

    /// Adds powers and forces of the last evaluation to the sums, after all processes have agreed that these forces
    /// act. If the next window applies the second half of this kick (change of velocities), stores the sums for that
    /// half.
    pub fn count(&mut self, at: EvaluationTime, ghosts: &dyn GhostExchange) {
        for ContactBlock { sums, .. } in &self.blocks {
            self.total.add(&sums.rows, at.weight);
        }
        (self.rates, self.losses) = (Rates::default(), FrictionLosses::default());
        if at.leaves_half {
            let mut due = ContactSums::default();
            self.blocks.iter().for_each(|block| due.add(&block.sums.rows, 1.0));
            ghosts.gather(&mut due);
            (self.rates, self.losses) = (due.rates(), due.friction_losses());
        }
    }

    /// Records the sums over all steps of `dt` [s] since the last call. Of several processes, only the lead process
    /// (number 0) records.
    pub fn book(&mut self, dt: f64, book: &mut StepRecord, ghosts: &dyn GhostExchange) {
        let mut total = std::mem::take(&mut self.total);
        ghosts.gather(&mut total);
        if ghosts.is_lead() {
            total.book(dt, &mut book.log.ledger);
        }
    }

    /// Records the second half of the last kick (change of velocities by forces) of the previous window, which acts in
    /// this window. `time` [s] is the length of this half, and `remaining` [s] the length of the whole window.
    pub fn record_half_kick(&mut self, time: f64, remaining: f64, scene: &Scene, log: &mut Log) {
        self.rates.add(time, remaining, scene, log);
        log.ledger.friction += self.losses * time;
        (self.rates, self.losses) = (Rates::default(), FrictionLosses::default());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encounter::AtWall;
    use crate::neighbours::NearWall;

    /// Checks that the contacts of one particle with one wall are in one block, and that a slot (candidate) is found in
    /// its block. Each particle has seven slots, and the size of a block is not a multiple of seven.
    #[test]
    fn no_border_parts_the_contacts_of_a_particle_with_a_wall() {
        let near = |k: u32| NearWall { particle: k / 7, at: AtWall { wall: 0, which: k % 7 } };
        let slots = 3 * CHUNK as u32 + 3;
        let mut list = NeighbourList::default();
        list.walls.extend((0..slots).map(near));
        let (size, mut all) = (block_size(&list), blocks(&list));
        assert_eq!(all.len(), 4);
        for slot in 0..slots {
            let one = std::ptr::from_ref(block_of(&mut all, slot, size));
            let first = std::ptr::from_ref(block_of(&mut all, slot - slot % 7, size));
            assert!(std::ptr::eq(one, first), "{slot}");
            assert!(block_of(&mut all, slot, size).holds(slot), "{slot}");
        }
    }
}
