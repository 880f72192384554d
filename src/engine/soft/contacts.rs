//! Contacts in progress: their forces, their records, and what they dissipate.

use super::block::{BlockScratch, ContactBlock, ForceEvaluation, first_named};
use super::contact::{Alike, Contact, ContactState, Rates, TouchingPair};
use super::pushes::ForceBuffer;
use super::tally::Total;
use crate::communicator::Communicator;
use crate::contact_law::ContactLaw;
use crate::encounter::{Couple, FrameTime};
use crate::engine::Failure;
use crate::neighbours::{NeighbourList, Pair};
use crate::particles::{CHUNK, Particles};
use crate::record::{Between, Impact, Log, Record};
use crate::scene::{Kind, Scene};
use crate::work_sharing;
use serde::{Deserialize, Serialize};

/// Where it is written what happens during steps.
pub struct StepRecord<'a> {
    /// Energy and momentum, and impacts that may still be discarded.
    pub log: &'a mut Log,
    /// Counts impacts as they end, so that nobody keeps those of a whole window; `None` where they may still be discarded.
    pub record: Option<&'a mut Record>,
}

impl StepRecord<'_> {
    /// Takes over impacts, and leaves none.
    fn take(&mut self, impacts: &mut Vec<(Between, Impact)>) {
        match &mut self.record {
            Some(record) => record.count(impacts),
            None => self.log.impacts.append(impacts),
        }
    }
}

/// When forces are evaluated, and for how much time they stand. All times in s.
#[derive(Clone, Copy, Debug)]
pub struct EvaluationTime {
    /// Simulated time at the start of the window.
    pub start: f64,
    /// Since the start of the window, for the positions.
    pub elapsed: f64,
    /// Until the end of the window.
    pub remaining: f64,
    /// The time step.
    pub dt: f64,
    /// Since the start of the window, for the velocities: what gravity has added to them.
    pub fall: f64,
    /// From the given velocities to the middle of the kick, where powers are taken.
    pub to_middle: f64,
    /// Fraction of the step these forces stand for now.
    pub weight: f64,
    /// Whether contacts begin and end here (not in the predicted state of a Runge-Kutta stage).
    pub opens: bool,
    /// Whether the list's account of travel holds for these very positions (Verlet), and not only up to the next step.
    pub travel_is_exact: bool,
    /// Whether a half of this kick is left to the next window.
    pub leaves_half: bool,
}

/// What contacts are looked for in, and when.
#[derive(Clone, Copy)]
pub struct ContactSearch<'a> {
    /// The pairs and walls that may overlap.
    pub list: &'a NeighbourList,
    /// Positions and velocities of the particles.
    pub particles: &'a Particles,
    /// Walls, surfaces and gravity.
    pub scene: &'a Scene,
    /// The instant at which forces are asked for.
    pub at: EvaluationTime,
    /// Whether each particle, by place, is of this process; `None` if all are.
    pub mine: Option<&'a [bool]>,
    /// What all particles have in common, if they are alike.
    pub alike: Option<&'a Alike>,
}

impl ContactSearch<'_> {
    /// Whether a contact is counted here: who has the first of the two does it.
    #[inline(always)]
    pub fn counts(&self, couple: &Couple) -> bool {
        self.mine.is_none_or(|mine| mine[couple.i as usize])
    }

    /// What is known of two bodies that touch.
    pub fn touching(&self, couple: Couple, law: &ContactLaw) -> TouchingPair {
        match self.alike {
            Some(alike) if !couple.is_wall() => alike.touching(couple),
            _ => TouchingPair::new(couple, self.particles, self.scene, law),
        }
    }

    /// Of which kinds two bodies are.
    pub fn kinds(&self, couple: &Couple) -> (u16, Kind) {
        match self.alike {
            Some(alike) if !couple.is_wall() => alike.kinds(),
            _ => couple.kinds(self.particles),
        }
    }
}

/// All contacts of a scene.
pub struct Contacts {
    law: ContactLaw,
    /// Where there are some they hold the contacts, and the two lists below are empty.
    blocks: Vec<ContactBlock>,
    /// In ascending order of slot.
    lasting: Vec<Contact>,
    /// Contacts that the last predicted state met first, in ascending order of slot.
    foreseen: Vec<Contact>,
    /// [J] stored in all contacts.
    elastic_energy: f64,
    /// Of the kick of which a half is still to be booked.
    rates: Rates,
    /// Of all steps of the window so far.
    total: Total,
    /// Scratch: what contacts do in an evaluation.
    scratch: BlockScratch,
}

/// What the last evaluation of the forces leaves to the next one.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Due {
    /// Contacts that the last predicted state met first, in ascending order of slot: their forces acted already, so the
    /// speed of approach is the one seen there.
    foreseen: Vec<Contact>,
    /// [J] stored in all contacts.
    elastic_energy: f64,
    /// Of the kick of which a half is still to be booked.
    rates: Rates,
}

/// Slots per block of a list.
fn block_size(list: &NeighbourList) -> usize {
    let slots = list.slots();
    if slots <= 2 * CHUNK { slots.max(1) } else { CHUNK }
}

/// Blocks of all slots of a list, without contacts so far.
fn blocks(list: &NeighbourList) -> Vec<ContactBlock> {
    let (slots, size) = (list.slots(), block_size(list));
    (0..slots.div_ceil(size).max(1)).map(|k| ContactBlock::of(k * size..((k + 1) * size).min(slots))).collect()
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
            total: Total::default(),
            scratch: BlockScratch::default(),
        }
    }

    pub fn elastic_energy(&self) -> f64 {
        self.elastic_energy
    }

    /// What the last evaluation leaves to the next one.
    pub fn due(&self) -> Due {
        let mut foreseen = self.foreseen.clone();
        foreseen.extend(self.blocks.iter().flat_map(ContactBlock::foreseen));
        Due { foreseen, elastic_energy: self.elastic_energy, rates: self.rates }
    }

    /// Goes on from what an evaluation left.
    pub fn resume(&mut self, due: Due) {
        Due { foreseen: self.foreseen, elastic_energy: self.elastic_energy, rates: self.rates } = due;
    }

    /// Opens a contact for everything that overlaps at the start, at simulated time `now` [s].
    pub fn find(&mut self, list: &NeighbourList, particles: &Particles, scene: &Scene, now: f64) {
        self.gather(list);
        let mut slots = Vec::new();
        list.overlapping(particles, scene, &mut slots);
        for &slot in &slots {
            let touch = TouchingPair::new(list.couple(slot as usize), particles, scene, &self.law);
            let met = touch.couple.meet(particles, scene, FrameTime::default());
            let (overlap, growth) = (met.overlap(), -met.normal_velocity);
            let deepest = ContactState { first_overlap: overlap, maximum_overlap: overlap, ..ContactState::new(now) };
            let course = ContactState { normal_speed: growth, overlap, growth, ..deepest };
            self.lasting.push(Contact { slot, touch, course });
        }
    }

    /// Hands over the contacts in progress. What is due of the last kick stays, in case they come back as they were.
    pub fn take(&mut self, list: &NeighbourList) -> Vec<Contact> {
        self.gather(list);
        std::mem::take(&mut self.lasting)
    }

    /// Shows the contacts in progress, in ascending order of slot.
    pub fn for_each(&self, list: &NeighbourList, visit: &mut dyn FnMut(Contact)) {
        self.lasting.iter().copied().for_each(&mut *visit);
        self.blocks.iter().flat_map(|block| block.contacts(block.couples(list))).for_each(visit);
    }

    /// At the next evaluation all of the list is looked through, as after a run has been stored: so the work that is counted does not depend on that.
    pub fn look_anew(&mut self) {
        self.blocks.iter_mut().for_each(ContactBlock::look_anew);
    }

    /// Drops what is due of the last kick: somebody else has moved the contacts on.
    pub fn forget(&mut self) {
        self.elastic_energy = 0.0;
        self.rates = Rates::default();
    }

    /// Takes contacts in progress over, for a list they are in.
    pub fn put(&mut self, contacts: Vec<Contact>) {
        self.keep_foreseen();
        self.lasting = contacts;
    }

    /// Takes all contacts out of the blocks.
    fn gather(&mut self, list: &NeighbourList) {
        // there are many, so the list does not grow by doubling, and each block gives its memory back before the next one is read
        self.lasting.reserve_exact(self.blocks.iter().map(ContactBlock::count).sum());
        for block in std::mem::take(&mut self.blocks) {
            self.foreseen.extend(block.foreseen());
            self.lasting.extend(block.contacts(block.couples(list)));
        }
    }

    /// Takes those alone out of the blocks that a predicted state met, and gives the blocks up.
    fn keep_foreseen(&mut self) {
        for block in std::mem::take(&mut self.blocks) {
            self.foreseen.extend(block.foreseen());
        }
    }

    /// Hands the contacts to blocks of the list.
    fn spread(&mut self, list: &NeighbourList) {
        let size = block_size(list);
        self.blocks = blocks(list);
        for contact in std::mem::take(&mut self.lasting) {
            self.blocks[contact.slot as usize / size].put(&contact, list);
        }
        for contact in std::mem::take(&mut self.foreseen) {
            self.blocks[contact.slot as usize / size].put_foreseen(contact);
        }
    }

    /// Gives back what is of no use for another list: while that is built much else is in memory. Returns who touches whom in the blocks, which only
    /// the present list knows.
    pub fn shed(&mut self, list: &NeighbourList) -> impl Iterator<Item = Couple> + use<> {
        self.blocks.iter_mut().for_each(ContactBlock::shed);
        // there are many, so the list does not grow by doubling; pairs, which come first, take half of the room of a couple
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

    /// The store has been reordered and the list rebuilt: the particle once at `p` is now at `place_of[p]`. `couples` are those of the contacts in blocks, as
    /// they were before.
    pub fn reorder(&mut self, place_of: &[u32], mut couples: impl Iterator<Item = Couple>, list: &NeighbourList) {
        let follow = |contact: &mut Contact| {
            contact.touch.couple = contact.touch.couple.moved(|place| place_of[place as usize]);
            let slot = list.slot(&contact.touch.couple);
            contact.slot = slot.map_or(contact.slot, |slot| slot as u32);
            slot.is_some()
        };
        if !self.blocks.is_empty() {
            // from block to block: one list of all would be as much memory again
            let (size, mut anew) = (block_size(list), blocks(list));
            for block in std::mem::take(&mut self.blocks) {
                let followed = |mut contact: Contact| follow(&mut contact).then_some(contact);
                for contact in block.contacts(&mut couples).filter_map(followed) {
                    anew[contact.slot as usize / size].put(&contact, list);
                }
                for contact in block.foreseen().iter().copied().filter_map(followed) {
                    anew[contact.slot as usize / size].put_foreseen(contact);
                }
            }
            work_sharing::for_each(anew.chunks_mut(8), |blocks| blocks.iter_mut().for_each(ContactBlock::sort));
            self.blocks = anew;
            return;
        }
        for contacts in [&mut self.lasting, &mut self.foreseen] {
            contacts.retain_mut(follow);
            contacts.sort_unstable_by_key(|contact| contact.slot);
            // two processes may have sent the same
            contacts.dedup_by_key(|contact| contact.slot);
        }
    }

    /// Finds what overlaps, opens and closes contacts, and puts the accelerations into `pushes`. Returns what it did.
    pub fn evaluate(
        &mut self,
        view: ContactSearch,
        pushes: &mut Vec<ForceBuffer>,
        book: &mut StepRecord,
    ) -> Result<ForceEvaluation, Failure> {
        if self.blocks.is_empty() {
            self.spread(view.list);
        }
        // the memory of the last pushes is that of the next
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

    /// Counts what the forces of the last evaluation do, now that all processes agree that they act.
    pub fn count(&mut self, at: EvaluationTime, others: Option<&dyn Communicator>) {
        let mut due = Total::default();
        for ContactBlock { sums, .. } in &self.blocks {
            self.total.add(&sums.rows, at.weight);
            if at.leaves_half {
                due.add(&sums.rows, 1.0);
            }
        }
        if let (Some(others), true) = (others, at.leaves_half) {
            due.gather(others);
        }
        self.rates = due.rates();
    }

    /// Books what contacts have done in steps of `dt` [s] since that was last booked: of several processes the lead does.
    pub fn book(&mut self, dt: f64, book: &mut StepRecord, others: Option<&dyn Communicator>) {
        let mut total = std::mem::take(&mut self.total);
        others.iter().for_each(|others| total.gather(*others));
        if others.is_none_or(|others| others.is_lead()) {
            total.book(dt, &mut book.log.ledger);
        }
    }

    /// Books the half of the last kick that was left for this window; `remaining` [s] is the whole window.
    pub fn settle(&mut self, time: f64, remaining: f64, scene: &Scene, log: &mut Log) {
        self.rates.add(time, remaining, scene, log);
        self.rates = Rates::default();
    }
}
